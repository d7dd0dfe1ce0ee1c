// Where a scene begins, and World::set_state for engines in maximal coordinates, where every body
// has a pose of its own. For backends; header only.
#pragma once

#include <algorithm>
#include <vector>

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

/// A scene's own start: poses, twists and joint coordinates.
inline WorldState initial_state(const SceneModel& model) {
  WorldState out;
  for (const Body& body : model.bodies) {
    out.poses.push_back(body.X_WB);
    out.twists.push_back(body.V_WB);
  }
  out.joint_positions.resize(static_cast<std::size_t>(model.joint_positions));
  out.joint_velocities.resize(static_cast<std::size_t>(model.joint_speeds));
  for (const Joint& joint : model.joints) {
    std::copy(joint.position.begin(), joint.position.end(),
              out.joint_positions.begin() + joint.position_offset);
    std::copy(joint.velocity.begin(), joint.velocity.end(),
              out.joint_velocities.begin() + joint.speed_offset);
  }
  return out;
}

namespace detail {

/// Puts the other end of `joint` where the coordinates in `state` say, seen from the end that is
/// placed: the parent if `forward`.
inline void place_across(const Joint& joint, bool forward, WorldState& state) {
  const int from = forward ? joint.parent : joint.child;
  const auto to = static_cast<std::size_t>(forward ? joint.child : joint.parent);
  const bool of_world = from == kWorld;
  const Pose X_from = of_world ? Pose() : state.poses[static_cast<std::size_t>(from)];
  const Twist V_from = of_world ? Twist() : state.twists[static_cast<std::size_t>(from)];
  const double* const q = state.joint_positions.data() + joint.position_offset;
  const double* const u = state.joint_velocities.data() + joint.speed_offset;
  const Twist V_FM = joint_twist(joint, q, u);
  const Pose X_PC = joint.X_PF * joint_pose(joint, q) * joint.X_CM.inverse();
  const Pose X_to = X_from * (forward ? X_PC : X_PC.inverse());
  // The child's motion against the parent at M's origin, world axes.
  const Quat F = (forward ? X_from : X_to).q * joint.X_PF.q;
  const Vec3 M = (forward ? X_to : X_from) * joint.X_CM.p;
  const double sign = forward ? 1.0 : -1.0;
  const Vec3 spin = V_from.angular + sign * (F * V_FM.angular);
  const Vec3 at_M = V_from.at(M - X_from.p) + sign * (F * V_FM.linear);
  state.poses[to] = X_to;
  state.twists[to] = {at_M + spin.cross(X_to.p - M), spin};
}

}  // namespace detail

/// Places all that tree joints connect by the joints' coordinates in `state`, outwards from what no
/// joint moves or, in a tree that floats, from its first body.
inline void place_by_joints(const SceneModel& model, WorldState& state) {
  std::vector<char> placed;
  for (const Body& body : model.bodies) {
    placed.push_back(body.removed || body.kind != BodyKind::dynamic);
  }
  const auto is_placed = [&](int b) { return b == kWorld || placed[static_cast<std::size_t>(b)]; };
  for (std::size_t start = 0; start <= placed.size(); ++start) {
    for (bool found = true; found;) {
      found = false;
      for (const Joint& joint : model.joints) {
        const bool forward = is_placed(joint.parent);
        if (joint.removed || joint.closes_loop || forward == is_placed(joint.child)) continue;
        detail::place_across(joint, forward, state);
        placed[static_cast<std::size_t>(forward ? joint.child : joint.parent)] = 1;
        found = true;
      }
    }
    if (start < placed.size()) placed[start] = 1;
  }
}

}  // namespace cogrsim
