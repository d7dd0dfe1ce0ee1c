#include "cogrsim/physics/tree_dynamics.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "cogrsim/physics/scene_state.h"

namespace cogrsim {
namespace {

/// Recursive Newton-Euler over the joint trees, at one state.
class Trees {
 public:
  Trees(const SceneModel& model, const WorldState& state)
      : model_(model), trees_(joint_trees(model)), state_(state) {
    place_by_joints(model, state_);
  }

  int size() const { return model_.joint_speeds + 6 * int(trees_.floating.size()); }

  void zero_velocities() {
    std::fill(state_.joint_velocities.begin(), state_.joint_velocities.end(), 0.0);
    state_.twists.assign(state_.twists.size(), Twist());
  }

  Eigen::VectorXd efforts(const Vec3& gravity, const Eigen::VectorXd& du) const {
    assert(du.size() == size());
    // Accelerations of the bodies' origins, as their twists; kinematic ones have none.
    std::vector<Twist> rates(model_.bodies.size());
    int at = model_.joint_speeds;
    for (const int b : trees_.floating) {
      rates[std::size_t(b)] = {du.segment<3>(at), du.segment<3>(at + 3)};
      at += 6;
    }
    for (const TreeJoint& t : trees_.joints) add_rate(t, du, rates);

    std::vector<Wrench> wrenches(model_.bodies.size());  // about the bodies' origins
    for (std::size_t b = 0; b < wrenches.size(); ++b) {
      const Body& body = model_.bodies[b];
      if (body.removed || body.kind != BodyKind::dynamic) continue;
      const Mat3 R = state_.poses[b].q.toRotationMatrix();
      const Mat3 I = R * body.inertia * R.transpose();
      const Vec3 r = R * body.com, &w = state_.twists[b].angular;
      const Vec3 a = rates[b].at(r) + w.cross(w.cross(r));
      wrenches[b].force = body.mass * (a - body.gravity_scale * gravity);
      wrenches[b].torque = I * rates[b].angular + w.cross(I * w) + r.cross(wrenches[b].force);
    }

    Eigen::VectorXd tau = Eigen::VectorXd::Zero(size());
    for (auto t = trees_.joints.rbegin(); t != trees_.joints.rend(); ++t)
      project_wrench(*t, du, wrenches, tau);
    at = model_.joint_speeds;
    for (const int b : trees_.floating) {
      tau.segment<3>(at) = wrenches[std::size_t(b)].force;
      tau.segment<3>(at + 3) = wrenches[std::size_t(b)].torque;
      at += 6;
    }
    return tau;
  }

 private:
  struct Ends {
    const Joint& joint;
    int inboard, outboard;
    double sign;  ///< +1: the outboard body is the child; -1: the parent
    Quat R;       ///< orientation of F
    Vec3 M;       ///< origin of M, world
    const double* q;
  };
  Ends ends(const TreeJoint& t) const {
    const Joint& joint = model_.joints[std::size_t(t.joint)];
    return {joint,
            t.forward ? joint.parent : joint.child,
            t.forward ? joint.child : joint.parent,
            t.forward ? 1.0 : -1.0,
            pose(joint.parent).q * joint.X_PF.q,
            pose(joint.child) * joint.X_CM.p,
            state_.joint_positions.data() + joint.position_offset};
  }
  Pose pose(int b) const { return b == kWorld ? Pose() : state_.poses[std::size_t(b)]; }
  Twist twist(int b) const { return b == kWorld ? Twist() : state_.twists[std::size_t(b)]; }

  /// Acceleration of the outboard body from that of the inboard body:
  ///   a_C(M) = a_P(M) + 2 w_P x v + a,  alpha_C = alpha_P + w_P x w + alpha
  /// with v, w, a, alpha of M relative to F, and a_B(M) the acceleration of the point of B at M.
  void add_rate(const TreeJoint& t, const Eigen::VectorXd& du, std::vector<Twist>& rates) const {
    const Ends e = ends(t);
    const double* const u = state_.joint_velocities.data() + e.joint.speed_offset;
    const Twist V = joint_twist(e.joint, e.q, u);
    Twist A = joint_twist(e.joint, e.q, du.data() + e.joint.speed_offset);
    A.angular += joint_twist_rate(e.joint, e.q, u).angular;
    const Vec3 w_P = twist(e.joint.parent).angular;
    const Vec3 linear = 2 * w_P.cross(e.R * V.linear) + e.R * A.linear;
    const Vec3 angular = w_P.cross(e.R * V.angular) + e.R * A.angular;

    const Twist from = e.inboard == kWorld ? Twist() : rates[std::size_t(e.inboard)];
    const auto centripetal = [&](int b) -> Vec3 {
      const Vec3 w = twist(b).angular;
      return w.cross(w.cross(e.M - pose(b).p));
    };
    Twist& to = rates[std::size_t(e.outboard)];
    to.angular = from.angular + e.sign * angular;
    const Vec3 at_M = from.at(e.M - pose(e.inboard).p) + centripetal(e.inboard) + e.sign * linear;
    to.linear = at_M - centripetal(e.outboard) - to.angular.cross(e.M - pose(e.outboard).p);
  }

  void project_wrench(const TreeJoint& t, const Eigen::VectorXd& du, std::vector<Wrench>& wrenches,
                      Eigen::VectorXd& tau) const {
    const Ends e = ends(t);
    const Wrench& load = wrenches[std::size_t(e.outboard)];
    const Vec3 p = pose(e.outboard).p;
    const Vec3 force = e.R.conjugate() * load.force;
    const Vec3 torque = e.R.conjugate() * (load.torque + (p - e.M).cross(load.force));
    const int count = speed_count(e.joint.type);
    for (int k = 0; k < count; ++k) {
      std::array<double, 6> unit{};
      unit[std::size_t(k)] = 1.0;
      const Twist column = joint_twist(e.joint, e.q, unit.data());
      const int at = e.joint.speed_offset + k;
      tau[at] = e.sign * (column.linear.dot(force) + column.angular.dot(torque));
      const std::size_t axis = e.joint.type == JointType::ball ? 0 : std::size_t(k);
      if (axis < e.joint.axes.size()) tau[at] += e.joint.axes[axis].rotor_inertia * du[at];
    }
    if (e.inboard == kWorld) return;
    Wrench& inboard = wrenches[std::size_t(e.inboard)];
    inboard.force += load.force;
    inboard.torque += load.torque + (p - pose(e.inboard).p).cross(load.force);
  }

  const SceneModel& model_;
  JointTrees trees_;
  WorldState state_;
};

}  // namespace

std::vector<int> floating_bases(const SceneModel& model) { return joint_trees(model).floating; }

Eigen::VectorXd inverse_dynamics(const SceneModel& model, const WorldState& state,
                                 const Eigen::VectorXd& acceleration) {
  return Trees(model, state).efforts(model.physics.gravity, acceleration);
}

Eigen::MatrixXd mass_matrix(const SceneModel& model, const WorldState& state) {
  Trees trees(model, state);
  trees.zero_velocities();
  Eigen::MatrixXd out(trees.size(), trees.size());
  for (int k = 0; k < trees.size(); ++k)
    out.col(k) = trees.efforts(Vec3::Zero(), Eigen::VectorXd::Unit(trees.size(), k));
  return out;
}

}  // namespace cogrsim
