// Where links are and how they move, by closed forms of the joints.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"
#include "mechanism/placement.h"
#include "mechanism/spatial.h"
#include "mechanism/tree_plan.h"

namespace cogrsim::dynamics {

struct Link;

/// Where a link is and how its origin moves, world.
struct LinkMotion {
  Placement X;
  Vec3 angular = Vec3::Zero();  ///< [rad/s]
  Vec3 linear = Vec3::Zero();   ///< [m/s]
  Vec3 velocity_at(const Vec3& point) const { return linear + angular.cross(point - X.p); }
};

/// How a joint connects a link to its inboard body. Frames: I is the joint's frame on the inboard side, O
/// the one on the outboard side, B the link's body, P the body inboard of it.
struct Mounting {
  enum class Kind {
    fixed,  ///< not at all
    axis,   ///< turns about and slides along z of I: hinge, slider, screw, cylindrical
    other   ///< as the model defines the joint
  };
  Kind kind = Kind::axis;
  Placement X_PI;  ///< X_WI where nothing inboard moves
  Placement X_OB;
  Vec3 p_BO = Vec3::Zero();
  // axis: with the outboard side the joint's parent, all goes backwards.
  double sign = 1.0;
  double lead = 0.0;   ///< slides by this per angle [m/rad]
  bool turns = false;  ///< by its first coordinate
  int slide = -1;      ///< which coordinate it slides by; -1: none
};

Mounting mount(const SceneModel& model, const PlannedLink& plan);

/// Poses of all links, a parent before its children, at coordinates `q`.
void find_poses(const SceneModel& model, const std::vector<Link>& links, const double* q,
                std::vector<LinkMotion>& out);

/// How they move at speeds `u`; the poses are in `out` already.
void find_velocities(const SceneModel& model, const std::vector<Link>& links, const double* q,
                     const double* u, std::vector<LinkMotion>& out);

/// X_WI of a link: `motions` has the poses of the links before it.
Placement inboard_frame(const Link& link, const std::vector<LinkMotion>& motions);

/// Of a link whose joint has no fixed axis (Mounting::Kind::other): its velocity, world axes, about
/// `origin`, per unit of each of its speeds. X_WI: its frame I; `q`: its own coordinates.
void find_joint_columns(const SceneModel& model, const Link& link, const Placement& X_WI,
                        const double* q, const Vec3& origin, Spatial* columns);

/// Likewise: the rate of those columns, as seen from I, times its own speeds `u`.
Spatial find_joint_bias(const SceneModel& model, const Link& link, const Placement& X_WI,
                        const double* q, const double* u, const Vec3& origin);

/// Rates of the coordinates `q` at the speeds `u`: qdot = N(q) u. `qdot` is not `u`.
void find_rates(const std::vector<Link>& links, const double* q, const double* u, double* qdot);

}  // namespace cogrsim::dynamics
