// One rigid body: what of it ODE moves.
#pragma once

#include <ode/ode.h>

#include <array>

#include "cogrsim/physics/engine_world.h"
#include "library.h"

namespace cogrsim::ode {

inline constexpr StateBounds kBounds{1e6, 1e5, 1e9};

/// What ODE knows of a body from one step to the next, to the bit.
struct Motion {
  std::array<dReal, 3> p{};  ///< centre of mass (kinematic bodies: their origin) [m]
  std::array<dReal, 4> q{};  ///< w x y z
  std::array<dReal, 3> v{};  ///< [m/s]
  std::array<dReal, 3> w{};  ///< world axes [rad/s]
};

/// A body of ODE's. Its frame has the axes of the scene's and lies at the centre of mass, that of a
/// kinematic body at the origin, whose twist is constant.
class BodyLink {
 public:
  /// Makes the body at the pose and with the twist of the scene. Throws where ODE does not take its
  /// mass. Without it there is none, and nothing below does anything.
  void create(dWorldID world, const Body& body);
  bool exists() const { return id_ != nullptr; }
  dBodyID id() const { return id_; }

  /// For the next step.
  void push(const Wrench& wrench) {
    if (!id_) return;
    dBodyAddForce(id_, wrench.force.x(), wrench.force.y(), wrench.force.z());
    dBodyAddTorque(id_, wrench.torque.x(), wrench.torque.y(), wrench.torque.z());
  }

  Pose pose() const { return from_centre(to_vec(p_), to_quat(q_)); }
  /// Where it was before the step of h that made its present velocity.
  Pose pose_before(double h) const;
  Vec3 centre_before(double h) const { return to_vec(p_) - h * to_vec(v_); }
  Twist twist() const;
  void set_pose(const Pose& X_WB);
  void set_twist(const Twist& V_WB);

  /// Also false of what is not a number.
  bool is_within_bounds() const;
  double spin_squared() const;
  Motion motion() const;
  /// As it was, bit for bit; ODE's own function would normalise the quaternion again.
  void set_motion(const Motion& motion);

 private:
  Pose from_centre(const Vec3& c, const Quat& q) const {
    return {shifted_ ? Vec3(c - q * com_) : c, q};
  }
  dBodyID id_ = nullptr;
  const dReal *p_ = nullptr, *q_ = nullptr, *v_ = nullptr, *w_ = nullptr;  // ODE's own
  Vec3 com_ = Vec3::Zero();
  bool shifted_ = false;
};

/// One end of a joint: a body of ODE's, or what never moves.
struct JointEnd {
  BodyLink* body = nullptr;
  Pose start;  ///< where joints are made
  Pose pose() const { return body ? body->pose() : start; }
  Pose pose_before(double h) const { return body ? body->pose_before(h) : start; }
  Twist twist() const { return body ? body->twist() : Twist(); }
  dBodyID id() const { return body ? body->id() : nullptr; }
};

}  // namespace cogrsim::ode
