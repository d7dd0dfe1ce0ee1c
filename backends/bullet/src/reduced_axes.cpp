// The free axes of a ReducedGroup: which ones have something acting on them, and by what law.
#include <algorithm>
#include <cmath>
#include <limits>

#include "convert.h"
#include "reduced_group.h"

namespace cogrsim::bullet {

namespace {

// Below this speed friction of a ball joint has no direction yet [rad/s].
constexpr double kAtRest = 1e-9;

}  // namespace

ReducedGroup::Axis& ReducedGroup::next_axis(int tree_joint) {
  if (axis_count_ == axes_.size()) axes_.emplace_back();
  Axis& axis = axes_[axis_count_++];
  axis.part = AxisPart::whole;
  axis.tree_joint = tree_joint;
  axis.number = 0;
  axis.count = 1;
  axis.weight[0] = 1.0;
  axis.motors.clear();
  axis.impulse = 0.0;
  return axis;
}

void ReducedGroup::gather_axes(const SceneModel& model, const std::vector<Drive>& drives,
                               const std::vector<double>& q) {
  axis_count_ = 0;
  for (std::size_t t = 0; t < slots_.size(); ++t) {
    const TreeJoint& tree_joint = tree_.joints()[t];
    if (tree_joint.type == JointType::fixed) continue;
    const Joint& joint = model.joints[static_cast<std::size_t>(tree_joint.joint)];
    const double* own = q.data() + joint.position_offset;
    if (joint.type == JointType::ball) {
      gather_ball(joint, static_cast<int>(t), own);
      continue;
    }
    for (std::size_t k = 0; k < joint.axes.size(); ++k) {
      const JointAxis& law = joint.axes[k];
      const std::vector<int>& motors = slots_[t].motors[k];
      const bool driven = std::any_of(motors.begin(), motors.end(), [&](int m) {
        return acts(drives[static_cast<std::size_t>(m)]);
      });
      if (!driven && law.stiffness <= 0.0 && law.damping <= 0.0 && law.friction <= 0.0 &&
          !law.has_limit()) {
        continue;
      }
      Axis& axis = next_axis(static_cast<int>(t));
      axis.number = static_cast<int>(k);
      axis.q = own[k];
      axis.first = tree_joint.speed(static_cast<int>(k));
      axis.motors = motors;
    }
  }
}

void ReducedGroup::gather_ball(const Joint& joint, int tree_joint, const double* q) {
  const JointAxis& law = joint.axes.front();
  if (law.stiffness <= 0.0 && law.damping <= 0.0 && law.friction <= 0.0 &&
      !std::isfinite(law.upper)) {
    return;
  }
  const TreeJoint& t = tree_.joints()[static_cast<std::size_t>(tree_joint)];
  // From F's axes to those of the speeds, which are the link's and of its turning against the tree.
  const btMatrix3x3 to_link = tree_.frame(t.to).getBasis().transpose() * tree_.X_WF(t).getBasis();
  const double sign = t.reversed ? -1.0 : 1.0;
  const btVector3 turn = rotation_vector(btQuaternion(q[1], q[2], q[3], q[0]));
  const auto add = [&](const btVector3& in_F, double coordinate, AxisPart part) {
    Axis& axis = next_axis(tree_joint);
    axis.part = part;
    axis.q = coordinate;
    axis.in_F = in_F;
    axis.first = t.first;
    axis.count = 3;
    const btVector3 weights = to_link * in_F * sign;
    for (int k = 0; k < 3; ++k) axis.weight[k] = weights[k];
  };
  // The triad: with friction one axis lies along the motion, which it opposes as a whole.
  btVector3 triad[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto s = static_cast<std::size_t>(t.first);
  const btVector3 w = (btVector3(u_start_[s], u_start_[s + 1], u_start_[s + 2]) * sign) * to_link;
  if (law.friction > 0.0 && w.length() > kAtRest) {
    triad[0] = w.normalized();
    btPlaneSpace1(triad[0], triad[1], triad[2]);
  }
  if (law.stiffness > 0.0 || law.damping > 0.0 || law.friction > 0.0) {
    for (const btVector3& axis : triad) add(axis, turn.dot(axis), AxisPart::ball_spring);
  }
  const double angle = turn.length();
  if (std::isfinite(law.upper) && angle > 1e-9) add(turn / angle, angle, AxisPart::ball_cone);
}

void ReducedGroup::fill_law(const SceneModel& model, Axis& axis, double dt,
                            const std::vector<Drive>& drives) {
  const TreeJoint& t = tree_.joints()[static_cast<std::size_t>(axis.tree_joint)];
  const JointAxis& law =
      model.joints[static_cast<std::size_t>(t.joint)].axes[static_cast<std::size_t>(axis.number)];
  const AxisState state{axis.q, along(axis, u_start_), dt, axis.inverse_inertia};
  fill_axis_law(axis.law, axis.part, law, state, axis.motors, drives);
}

}  // namespace cogrsim::bullet
