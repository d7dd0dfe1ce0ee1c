// The initial state of a scene, helpers for World::set_state() in engines with maximal coordinates,
// where every body has a pose of its own, and the reports of a step. For backends; header only.
#pragma once

#include <algorithm>
#include <tuple>
#include <vector>

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

/// The initial state of a scene: poses, twists, joint coordinates and joint speeds.
inline WorldState initial_state(const SceneModel& model) {
  WorldState out;
  for (const Body& body : model.bodies) {
    out.poses.push_back(body.X_WB);
    out.twists.push_back(body.V_WB);
  }
  out.joint_positions.resize(model.joint_positions);
  out.joint_velocities.resize(model.joint_speeds);
  for (const Joint& joint : model.joints) {
    std::copy(joint.position.begin(), joint.position.end(),
              out.joint_positions.begin() + joint.position_offset);
    std::copy(joint.velocity.begin(), joint.velocity.end(),
              out.joint_velocities.begin() + joint.speed_offset);
  }
  return out;
}

/// The state `now` of a running world with the initial state of what `next` has beyond it.
inline WorldState extended_state(const SceneModel& next, const WorldState& now) {
  WorldState out = initial_state(next);
  const auto take = [](const auto& from, auto& to) {
    std::copy(from.begin(), from.end(), to.begin());
  };
  take(now.poses, out.poses);
  take(now.twists, out.twists);
  take(now.joint_positions, out.joint_positions);
  take(now.joint_velocities, out.joint_velocities);
  return out;
}

/// Order of the contacts of a step: by bodies, then by shapes.
inline bool comes_before(const Contact& a, const Contact& b) {
  return std::tie(a.body_a, a.body_b, a.shape_a, a.shape_b) <
         std::tie(b.body_a, b.body_b, b.shape_a, b.shape_b);
}

/// Coordinates `q` and speeds `u` of a joint from the motions of its two bodies in `state`. `q` holds
/// earlier coordinates: full turns and the signs of quaternions remain nearest to them.
inline void read_joint(const Joint& joint, const WorldState& state, double* q, double* u) {
  const auto pose = [&](int b) { return b == kWorld ? Pose() : state.poses[b]; };
  const auto twist = [&](int b) { return b == kWorld ? Twist() : state.twists[b]; };
  const Pose X_WP = pose(joint.parent), X_WC = pose(joint.child);
  const Pose X_FM = relative_pose(joint, X_WP, X_WC);
  joint_position(joint, X_FM, q, q);
  joint_velocity(joint, X_FM,
                 relative_twist(joint, X_WP, twist(joint.parent), X_WC, twist(joint.child)), q, u);
}

/// Where a body with a constant twist (of its origin, in world axes) is after dt [s].
inline Pose moved(const Pose& X_WB, const Twist& V_WB, double dt) {
  Pose out = X_WB;
  out.p += V_WB.linear * dt;
  const double angle = V_WB.angular.norm() * dt;
  if (angle > 0) {
    const Quat turn(Eigen::AngleAxisd(angle, V_WB.angular.normalized()));
    out.q = (turn * out.q).normalized();
  }
  return out;
}

/// Whether any joint of a scene has a rotor.
inline bool has_rotors(const SceneModel& model) {
  return std::any_of(model.joints.begin(), model.joints.end(), [](const Joint& joint) {
    return !joint.removed && std::any_of(joint.axes.begin(), joint.axes.end(),
                                         [](const auto& axis) { return axis.rotor_inertia > 0.0; });
  });
}

/// What a backend reports of a step, kept while its engine has no step to report: before the first
/// one and after a change of the scene.
struct StepReport {
  std::vector<double> joint_efforts, motor_efforts;
  std::vector<Wrench> reactions;
  std::vector<Contact> contacts;

  void clear(const SceneModel& model) {
    *this = {};
    resize(model);
  }

  /// For the next scene: nothing remains of what has been removed.
  void carry_over(const SceneModel& next) {
    resize(next);
    const auto is_removed = [&](int b) { return next.bodies[b].removed; };
    contacts.erase(std::remove_if(contacts.begin(), contacts.end(),
                                  [&](const Contact& contact) {
                                    return is_removed(contact.body_a) || is_removed(contact.body_b);
                                  }),
                   contacts.end());
    for (std::size_t j = 0; j < next.joints.size(); ++j) {
      const Joint& joint = next.joints[j];
      if (!joint.removed) continue;
      reactions[j] = Wrench();
      std::fill_n(joint_efforts.begin() + joint.speed_offset, speed_count(joint.type), 0.0);
    }
    for (std::size_t m = 0; m < next.motors.size(); ++m) {
      if (next.motors[m].removed) motor_efforts[m] = 0.0;
    }
  }

 private:
  void resize(const SceneModel& model) {
    joint_efforts.resize(model.joint_speeds);
    motor_efforts.resize(model.motors.size());
    reactions.resize(model.joints.size());
  }
};

namespace detail {

/// Computes the pose and twist of one body of `joint` from those of the other body and the joint
/// coordinates in `state`: of the child from the parent if `forward`, otherwise of the parent.
inline void place_across(const Joint& joint, bool forward, WorldState& state) {
  const int from = forward ? joint.parent : joint.child;
  const auto to = static_cast<std::size_t>(forward ? joint.child : joint.parent);
  const bool of_world = from == kWorld;
  const Pose X_from = of_world ? Pose() : state.poses[from];
  const Twist V_from = of_world ? Twist() : state.twists[from];
  const double* const q = state.joint_positions.data() + joint.position_offset;
  const double* const u = state.joint_velocities.data() + joint.speed_offset;
  const Twist V_FM = joint_twist(joint, q, u);
  const Pose X_PC = joint.X_PF * joint_pose(joint, q) * joint.X_CM.inverse();
  const Pose X_to = X_from * (forward ? X_PC : X_PC.inverse());
  // Motion of the child relative to the parent at the origin of M, in world axes.
  const Quat F = (forward ? X_from : X_to).q * joint.X_PF.q;
  const Vec3 M = (forward ? X_to : X_from) * joint.X_CM.p;
  const double sign = forward ? 1.0 : -1.0;
  const Vec3 spin = V_from.angular + sign * (F * V_FM.angular);
  const Vec3 at_M = V_from.at(M - X_from.p) + sign * (F * V_FM.linear);
  state.poses[to] = X_to;
  state.twists[to] = {at_M + spin.cross(X_to.p - M), spin};
}

}  // namespace detail

/// A joint of a tree, passed from the body nearer to the tree's start to the other one: to its child
/// if `forward`, otherwise to its parent.
struct TreeJoint {
  int joint = -1;
  bool forward = true;
};

/// The trees of joints of a scene. Each starts at its immobile bodies or, if it floats, at its first
/// body. Removed joints and those that close a loop are in none.
struct JointTrees {
  std::vector<int> floating;      ///< first bodies of those that float
  std::vector<TreeJoint> joints;  ///< each after those between it and the start
};

inline JointTrees joint_trees(const SceneModel& model) {
  JointTrees out;
  std::vector<char> placed;
  for (const Body& body : model.bodies) {
    placed.push_back(body.removed || body.kind != BodyKind::dynamic);
  }
  const auto is_placed = [&](int b) { return b == kWorld || placed[b]; };
  for (std::size_t start = 0; start <= placed.size(); ++start) {
    for (bool found = true; found;) {
      found = false;
      for (std::size_t j = 0; j < model.joints.size(); ++j) {
        const Joint& joint = model.joints[j];
        const bool forward = is_placed(joint.parent);
        if (joint.removed || joint.closes_loop || forward == is_placed(joint.child)) continue;
        out.joints.push_back({static_cast<int>(j), forward});
        placed[forward ? joint.child : joint.parent] = 1;
        found = true;
      }
    }
    if (start == placed.size() || placed[start]) continue;
    placed[start] = 1;
    out.floating.push_back(static_cast<int>(start));
  }
  return out;
}

/// Computes the poses and twists of all bodies in trees of joints from the joint coordinates in
/// `state`, and from the motions of the bodies where the trees start.
inline void place_by_joints(const SceneModel& model, WorldState& state) {
  for (const TreeJoint& t : joint_trees(model).joints)
    detail::place_across(model.joints[t.joint], t.forward, state);
}

}  // namespace cogrsim
