// Changes of a running world, determined by comparing two scenes: see World::add(), remove() and
// change(). For backends; header only.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/model/mass_properties.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// The operation: World::add(), remove() or change().
enum class SceneStep { add, remove, change };

/// The difference between the running scene and the next one, as indices of elements.
struct SceneChange {
  std::vector<int> attached;  ///< new joints between two bodies that already exist
  std::vector<int> removed_bodies, removed_joints;
  std::vector<int> kinds;  ///< bodies that change from dynamic to fixed or from fixed to dynamic
  std::vector<int> axes;   ///< joints whose Joint::axes differ
};

namespace detail {

inline bool same_axes(const Joint& a, const Joint& b) {
  if (a.axes.size() != b.axes.size()) return false;
  for (std::size_t i = 0; i < a.axes.size(); ++i) {
    const JointAxis &x = a.axes[i], &y = b.axes[i];
    if (x.lower != y.lower || x.upper != y.upper || x.damping != y.damping ||
        x.friction != y.friction || x.stiffness != y.stiffness || x.rest != y.rest ||
        x.max_effort != y.max_effort || x.max_speed != y.max_speed ||
        x.rotor_inertia != y.rotor_inertia) {
      return false;
    }
  }
  return true;
}

inline Result<> check_axes(const Joint& joint) {
  const std::string what = "joint '" + joint.name + "': ";
  for (const JointAxis& axis : joint.axes) {
    // This form of the comparison also rejects NaN.
    if (!(axis.lower <= axis.upper)) return fail(what + "its lower limit is not below its upper");
    const double laws[] = {axis.damping, axis.friction, axis.stiffness, axis.rotor_inertia};
    for (const double law : laws) {
      if (!(law >= 0.0) || !std::isfinite(law)) {
        return fail(
            what +
            "damping, friction, stiffness and rotor inertia must be finite and not negative");
      }
    }
    if (!std::isfinite(axis.rest)) return fail(what + "the rest position must be finite");
    if (!(axis.max_effort >= 0.0) || !(axis.max_speed >= 0.0)) {
      return fail(what + "limits of effort and speed must not be negative");
    }
  }
  return {};
}

inline Result<> check_kinds(const Body& now, const Body& next) {
  const std::string what = "body '" + next.name + "': ";
  if (now.kind == BodyKind::kinematic || next.kind == BodyKind::kinematic) {
    return fail(what + "a kinematic body stays kinematic, and no other becomes one");
  }
  if (next.kind == BodyKind::static_body) return {};
  if (auto massive = check_mass_properties(next.mass, next.inertia); !massive) {
    return fail(what + "it cannot move: " + massive.error().message);
  }
  for (const Shape& shape : next.shapes) {
    if (shape.collides && (shape.type == ShapeType::plane || shape.type == ShapeType::mesh ||
                           shape.type == ShapeType::heightmap)) {
      return fail(what + "it cannot move: a " + to_string(shape.type) +
                  " cannot be moved by forces");
    }
  }
  return {};
}

}  // namespace detail

/// Determines the changes from the scene `now` to the scene `next`. Errors: `next` lacks elements
/// of `now`, restores removed ones or has joints between other bodies; a joint refers to a missing
/// body; or `next` contains changes that do not belong to `step`. Joint::closes_loop may change in
/// every operation.
inline Result<SceneChange> find_scene_change(const SceneModel& now, const SceneModel& next,
                                             SceneStep step) {
  const std::size_t bodies = now.bodies.size(), joints = now.joints.size();
  if (next.bodies.size() < bodies || next.joints.size() < joints ||
      next.motors.size() < now.motors.size()) {
    return fail("the next scene lacks elements; removed elements must stay, marked as removed");
  }
  SceneChange out;
  for (std::size_t b = 0; b < bodies; ++b) {
    const Body &was = now.bodies[b], &is = next.bodies[b];
    if (was.removed && !is.removed) {
      return fail("body '" + is.name + "' was removed and cannot be restored", "", "add a new one");
    }
    if (is.removed != was.removed) out.removed_bodies.push_back(static_cast<int>(b));
    if (is.kind == was.kind || is.removed) continue;
    if (auto fine = detail::check_kinds(was, is); !fine) return tl::unexpected(fine.error());
    out.kinds.push_back(static_cast<int>(b));
  }
  const auto there = [&](int body, const std::vector<Body>& of) {
    return body == kWorld || (body >= 0 && body < static_cast<int>(of.size()) && !of[body].removed);
  };
  for (std::size_t j = 0; j < next.joints.size(); ++j) {
    const Joint& is = next.joints[j];
    if (!is.removed && (!there(is.parent, next.bodies) || !there(is.child, next.bodies))) {
      return fail("joint '" + is.name + "' refers to a body that does not exist");
    }
    if (j >= joints) {
      if (is.removed) continue;
      if (auto fine = detail::check_axes(is); !fine) return tl::unexpected(fine.error());
      if (there(is.parent, now.bodies) && there(is.child, now.bodies)) {
        out.attached.push_back(static_cast<int>(j));
      }
      continue;
    }
    const Joint& was = now.joints[j];
    if (was.removed && !is.removed) {
      return fail("joint '" + is.name + "' was removed and cannot be restored", "",
                  "add a new one");
    }
    if (is.removed != was.removed) out.removed_joints.push_back(static_cast<int>(j));
    if (is.removed) continue;
    if (is.type != was.type || is.parent != was.parent || is.child != was.child) {
      return fail("joint '" + is.name + "' cannot change its type or its bodies", "",
                  "remove it and add a new one");
    }
    if (detail::same_axes(was, is)) continue;
    if (auto fine = detail::check_axes(is); !fine) return tl::unexpected(fine.error());
    out.axes.push_back(static_cast<int>(j));
  }
  const bool grown = next.bodies.size() > bodies || next.joints.size() > joints ||
                     next.motors.size() > now.motors.size();
  const bool shrunk = !out.removed_bodies.empty() || !out.removed_joints.empty();
  const bool changed = !out.kinds.empty() || !out.axes.empty();
  const char* other = nullptr;
  if (grown && step != SceneStep::add) other = "adds elements";
  if (shrunk && step != SceneStep::remove) other = "removes elements";
  if (changed && step != SceneStep::change) other = "changes bodies or joints";
  if (other) {
    return fail(std::string("the next scene also ") + other, "",
                "add, remove and change one after the other");
  }
  return out;
}

/// The bodies of an inelastic impact that a change makes: of new joints, and what is joined to a body
/// that has become static or dynamic. The world may be among them.
inline std::vector<int> struck_bodies(const SceneModel& next, const SceneChange& change) {
  std::vector<int> out;
  const auto add = [&](const Joint& joint) { out.insert(out.end(), {joint.parent, joint.child}); };
  for (const int j : change.attached) add(next.joints[j]);
  for (const int b : change.kinds)
    for (const Joint& joint : next.joints)
      if (!joint.removed && (joint.parent == b || joint.child == b)) add(joint);
  return out;
}

/// Largest constraint violation of a joint when it is attached.
inline constexpr double kAttachGap = 1e-3;  ///< [m], [rad]

/// Checks that a new joint fits the current poses of its parent and child bodies in the world. The
/// error states the constraint violation.
inline Result<> check_attachment(const Joint& joint, const Pose& X_WP, const Pose& X_WC) {
  const JointError gap = joint_error(joint, relative_pose(joint, X_WP, X_WC));
  if (gap.distance <= kAttachGap && gap.angle <= kAttachGap) return {};
  return fail("joint '" + joint.name + "' does not fit the poses of its bodies: its frames are " +
                  std::to_string(gap.distance) + " m and " + std::to_string(gap.angle) +
                  " rad apart",
              "", "set its frames so that they coincide");
}

/// The same for all joints that a change attaches; `pose_of(body)` is the current pose of a body.
template <class PoseOf>
Result<> check_attachments(const SceneModel& next, const SceneChange& change,
                           const PoseOf& pose_of) {
  for (const int j : change.attached) {
    const Joint& joint = next.joints[j];
    auto fits = check_attachment(joint, pose_of(joint.parent), pose_of(joint.child));
    if (!fits) return fits;
  }
  return {};
}

}  // namespace cogrsim
