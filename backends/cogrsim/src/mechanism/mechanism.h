// The scene as trees of links, tied by welds where they form loops.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mechanism/components.h"
#include "mechanism/kinematics.h"
#include "mechanism/tree_plan.h"
#include "state.h"

namespace cogrsim::dynamics {

/// A body and what carries it. A base moves in its centre of mass (kinematic: in its origin), so that
/// its speeds are angular velocity and velocity of that point, in world axes.
struct Link {
  PlannedLink plan;
  std::unique_ptr<const Mounting> mounting;  ///< none: a base
  bool kinematic = false;
  bool has_quaternion = false;  ///< its first four q; else the rates of q are its u
  int first_q = 0, nq = 0, first_u = 0, nu = 0;
  /// q_map[i]: index, among its own q, of the model's q_i; u_map likewise.
  std::array<std::uint8_t, 7> q_map{0, 1, 2, 3, 4, 5, 6};
  std::array<std::uint8_t, 6> u_map{0, 1, 2, 3, 4, 5};
  double mass = 0.0;                ///< its share
  Vec3 com = Vec3::Zero();          ///< body frame
  Mat3 inertia = Mat3::Identity();  ///< its share, about com, body axes
  Mat3 root = Mat3::Identity();  ///< of the inverse inertia: root root^T
  int component = -1;  ///< -1: kinematic
  /// Of a base: the point whose coordinates are its own, in its body's frame [m].
  Vec3 centre() const { return kinematic ? Vec3(Vec3::Zero()) : com; }
};

class Mechanism {
 public:
  /// Throws std::runtime_error when loops cannot be closed.
  explicit Mechanism(SceneModelPtr model);

  const SceneModel& model() const { return *model_; }
  const SceneModelPtr& model_ptr() const { return model_; }
  const std::vector<Link>& links() const { return links_; }
  int body_link(int body) const { return body < 0 ? -1 : plan_.body_link[std::size_t(body)]; }
  int joint_link(int joint) const { return plan_.joint_link[std::size_t(joint)]; }
  std::vector<Component>& components() { return components_; }
  const std::vector<Component>& components() const { return components_; }
  bool has_loops() const { return has_loops_; }
  /// u index of an axis of a joint; -1: the joint moves nothing. Not for ball and free joints.
  int axis_speed(int joint, int axis) const;
  int axis_position(int joint, int axis) const;

  State state;

  /// Sets the external forces on each body (nbody), or none at all, beside the weights.
  void set_external(const std::vector<Wrench>& forces);
  /// Weight and external forces of each link, through its centre of mass (nlink).
  const std::vector<Wrench>& loads() const { return loads_; }

  /// Rates of the coordinates at the state.
  void calc_qdot(Values& out) const { multiply_by_n(state.u(), out); }
  /// out := N(q) u.
  void multiply_by_n(const Values& u, Values& out) const;

  /// Quaternions back to unit length and, with loops, coordinates and speeds back onto them.
  void project();
  void normalize_quaternions();
  /// Speeds to the nearest that keep loops closed, at the state's coordinates.
  void project_speeds();

  // Of one link's own coordinates, without touching the others.
  void set_base(const Link& link, const Pose& X_WB, const Twist& V_WB);
  void set_joint(const Link& link, const double* q, const double* u);
  void get_joint(const Link& link, double* q, double* u) const;

  /// Of every link, at the state. Found once for each state.
  const std::vector<LinkMotion>& motions() const;
  const LinkMotion& motion(const Link& link) const {
    return motions()[std::size_t(&link - links_.data())];
  }

 private:
  Link make_link(const PlannedLink& plan) const;
  void make_components();
  // Trees and welds of a component.
  void arrange(Component& component) const;
  void add_rotors(Component& component) const;
  // Least changes, in the norm of the mass matrix, that close the loops; see loops.h.
  void close_coordinates();

  SceneModelPtr model_;
  TreePlan plan_;
  std::vector<Link> links_;
  std::vector<Component> components_;
  std::vector<Wrench> loads_;
  std::vector<int> quaternions_;  ///< first q of each
  bool has_loops_ = false;
  // What `motions_` holds is of these versions of q and u.
  mutable std::vector<LinkMotion> motions_;
  mutable std::int64_t q_version_ = -1, u_version_ = -1;
};

}  // namespace cogrsim::dynamics
