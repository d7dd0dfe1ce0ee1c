// How the place where two surfaces touch moves.
#pragma once

#include "collision/colliders.h"

namespace cogrsim::dynamics {

/// Radius of curvature of what is straight [m]: so long that what it leaves of a turn is rounding.
inline constexpr double kStraight = 1e4;
/// Of a corner on a corner, which have none, neither normal is known: between the two [m].
inline constexpr double kSharp = 1e-3;

/// Rates at a contact point of two bodies that turn, slide and roll, world axes.
struct ContactRates {
  Vec3 on_a = Vec3::Zero();    ///< velocity of the point over the surface of a [m/s]
  Vec3 on_b = Vec3::Zero();    ///< over that of b
  Vec3 normal = Vec3::Zero();  ///< of the unit normal, from a to b [rad/s]
};

/// `alone`: the pair has no other point. `turn_a`, `turn_b`: angular velocities [rad/s]; `slip`: velocity
/// of b's surface against a's at the point [m/s].
ContactRates find_contact_rates(const Collider& a, const Collider& b, const ContactPoint& point,
                                bool alone, const Vec3& turn_a, const Vec3& turn_b,
                                const Vec3& slip);

}  // namespace cogrsim::dynamics
