#include "build/check_overlap.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/model/joint_kinematics.h"

namespace cogrsim::dsl {
namespace {

// Cosine between the motion that a joint allows and the direction of separation; below it, the
// joint does not let the bodies separate.
constexpr double kAcross = 0.05;
constexpr double kAtLimit = 1e-9;  // [rad], [m]

/// Whether a joint lets its child move along `away` (unit vector, world) at `point`.
struct Separation {
  bool free = false;     ///< yes
  bool limited = false;  ///< yes, but for a limit
};

Separation separation_along(const SceneModel& model, const Joint& joint, const Vec3& point,
                            const Vec3& away) {
  const auto pose = [&](int body) { return body == kWorld ? Pose() : model.bodies[body].X_WB; };
  const Pose X_WF = pose(joint.parent) * joint.X_PF, X_WM = pose(joint.child) * joint.X_CM;
  const auto count = static_cast<std::size_t>(speed_count(joint.type));
  Separation separation;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<double> speeds(count, 0.0);
    speeds[i] = 1.0;
    const Twist V = joint_twist(joint, joint.position.data(), speeds.data());
    const Vec3 velocity = X_WF.q * V.linear + (X_WF.q * V.angular).cross(point - X_WM.p);
    const double out = velocity.dot(away);
    if (std::abs(out) <= kAcross * velocity.norm() || velocity.norm() < 1e-9) continue;
    const bool has_limit = joint.axes.size() == count && joint.position.size() == count;
    const bool stopped =
        has_limit && (out > 0.0 ? joint.position[i] >= joint.axes[i].upper - kAtLimit
                                : joint.position[i] <= joint.axes[i].lower + kAtLimit);
    (stopped ? separation.limited : separation.free) = true;
  }
  return separation;
}

}  // namespace

JointPaths::JointPaths(const SceneModel& model) : model_(model), joints_(model.bodies.size() + 1) {
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed || joint.type == JointType::free) continue;
    joints_[node(joint.parent)].push_back(static_cast<int>(j));
    joints_[node(joint.child)].push_back(static_cast<int>(j));
  }
}

std::size_t JointPaths::node(int body) const {
  const bool moves = body != kWorld && model_.bodies[body].kind == BodyKind::dynamic;
  return moves ? static_cast<std::size_t>(body) : model_.bodies.size();
}

// Joints from one body to another, breadth first; empty: they are not connected.
std::vector<int> JointPaths::path(int from, int to) const {
  constexpr int kUnseen = -2, kStart = -1;
  std::vector<int> came_by(joints_.size(), kUnseen);
  const std::size_t start = node(from), end = node(to);
  std::vector<std::size_t> queue = {start};
  came_by[start] = kStart;
  const auto beyond = [&](int j, std::size_t here) {
    const Joint& joint = model_.joints[j];
    return node(joint.parent) == here ? node(joint.child) : node(joint.parent);
  };
  for (std::size_t next = 0; next < queue.size() && came_by[end] == kUnseen; ++next)
    for (const int j : joints_[queue[next]]) {
      const std::size_t there = beyond(j, queue[next]);
      if (came_by[there] != kUnseen) continue;
      came_by[there] = j;
      queue.push_back(there);
    }
  std::vector<int> out;
  for (std::size_t here = end; came_by[here] >= 0; here = beyond(came_by[here], here))
    out.push_back(came_by[here]);
  std::reverse(out.begin(), out.end());
  return out;
}

std::optional<Pressing> JointPaths::pressing(const geometry::Overlap& overlap) const {
  Pressing all, limited;
  limited.limits = true;
  std::size_t here = node(overlap.body_a);
  all.joints = path(overlap.body_a, overlap.body_b);
  if (all.joints.empty()) return std::nullopt;
  for (const int j : all.joints) {
    const Joint& joint = model_.joints[j];
    const bool forwards = node(joint.parent) == here;
    here = forwards ? node(joint.child) : node(joint.parent);
    const Separation separation =
        separation_along(model_, joint, overlap.point, forwards ? overlap.normal : -overlap.normal);
    if (separation.free) return std::nullopt;
    if (separation.limited) limited.joints.push_back(j);
  }
  return limited.joints.empty() ? all : limited;
}

}  // namespace cogrsim::dsl
