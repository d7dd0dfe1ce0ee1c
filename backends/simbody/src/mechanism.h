// The scene as a Simbody system: bodies, mobilizers, welds that close loops.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "components.h"
#include "convert.h"
#include "tree_plan.h"

namespace cogrsim::simbody {

/// A mobilized body. Simbody's body frame is the model's body frame; a base moves in its centre of
/// mass (kinematic: in its origin), so that its generalized speeds are angular velocity and
/// velocity of that point, in world axes.
struct Link {
  PlannedLink plan;
  bool kinematic = false;
  SimTK::MobilizedBody mobod;
  int first_q = 0, nq = 0, first_u = 0, nu = 0;
  std::array<int, 7> q_map{};  ///< q_map[i]: place, among the mobilizer's q, of the model's q_i
  std::array<int, 6> u_map{};
  double mass = 0.0;                ///< its share
  Vec3 com = Vec3::Zero();          ///< body frame
  Mat3 inertia = Mat3::Identity();  ///< its share, about com, body axes
  Mat3 inverse_inertia = Mat3::Identity();
  int component = -1;  ///< -1: kinematic
};

/// Where a link is and how its origin moves, world.
struct LinkMotion {
  Placement X;
  Vec3 angular = Vec3::Zero();  ///< [rad/s]
  Vec3 linear = Vec3::Zero();   ///< [m/s]
  Vec3 velocity_at(const Vec3& point) const { return linear + angular.cross(point - X.p); }
};

class Mechanism {
 public:
  /// Throws what Simbody throws, and std::runtime_error when loops cannot be closed.
  explicit Mechanism(SceneModelPtr model);

  const SceneModel& model() const { return *model_; }
  const SceneModelPtr& model_ptr() const { return model_; }
  const std::vector<Link>& links() const { return links_; }
  int body_link(int body) const { return body < 0 ? -1 : plan_.body_link[std::size_t(body)]; }
  int joint_link(int joint) const { return plan_.joint_link[std::size_t(joint)]; }
  std::vector<Component>& components() { return components_; }
  bool has_loops() const { return has_loops_; }
  int largest_component() const { return largest_; }

  /// u index of an axis of a joint; -1: the joint moves nothing. Not for ball and free joints.
  int axis_speed(int joint, int axis) const;
  int axis_position(int joint, int axis) const;

  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter;
  SimTK::State state;

  void realize_velocity() { system.realize(state, SimTK::Stage::Velocity); }
  /// Rates of the coordinates at the state.
  void calc_qdot(SimTK::Vector& out) const {
    system.realize(state, SimTK::Stage::Position);
    matter.multiplyByN(state, false, state.getU(), out);
  }

  /// Quaternions back to unit length and, with loops, coordinates and speeds back onto them.
  void project();
  void normalize_quaternions();

  // Of one link's own coordinates, without touching the others.
  void set_base(const Link& link, const Pose& X_WB, const Twist& V_WB);
  void set_joint(const Link& link, const double* q, const double* u);
  void get_joint(const Link& link, double* q, double* u) const;

  /// Of every link, at the state, which is realized to Position: velocities are the system's Jacobian
  /// times u, without the Coriolis terms that Simbody's velocity stage finds too. Read once for each
  /// state: Simbody's accessors are slow.
  const std::vector<LinkMotion>& motions() const;
  Placement placement(const Link& link) const {
    return placement_of(link.mobod.getBodyTransform(state));
  }

 private:
  void add_link(const PlannedLink& plan);
  void close_loops();
  void make_components();

  SceneModelPtr model_;
  TreePlan plan_;
  std::vector<Link> links_;
  std::vector<Component> components_;
  std::vector<int> quaternions_;  ///< first q of each
  bool has_loops_ = false;
  int largest_ = 0;
  // What `motions_` holds is of these versions of q and u.
  mutable std::vector<LinkMotion> motions_;
  mutable SimTK::Vector_<SimTK::SpatialVec> velocities_;  ///< by mobilized body
  mutable SimTK::ValueVersion q_version_ = -1, u_version_ = -1;
};

}  // namespace cogrsim::simbody
