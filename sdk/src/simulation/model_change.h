// Changed copies of a scene model, for adding and removing elements of a running simulation.
#pragma once

#include <optional>
#include <string>

#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// Maximum number of bodies of a run, including removed ones.
inline constexpr std::size_t kMaxBodies = 100000;

/// Appends the elements of `fragment` to `model` as a new assembly `name`, with the world frame of
/// the fragment at `pose`. Errors: the name is empty or exists, or there are too many bodies.
Result<SceneModelPtr> with_added(const SceneModel& model, const SceneModel& fragment,
                                 const std::string& name, const Pose& pose);

/// Marks an assembly (or a body that belongs to none), its contents, all joints to it, and the
/// motors, sensors, doors and regions that depend on them as removed. Errors: the assembly or body
/// does not exist (with the existing names), or the body belongs to an assembly.
Result<SceneModelPtr> with_removed(const SceneModel& model, const std::string& name);

/// Appends `joint` between two existing bodies. Sets its `closes_loop`; missing axes get the
/// defaults. Errors: the name is empty or exists, a body does not exist, both bodies are the same,
/// the axes do not match the type or have inverted limits, or there are too many joints.
Result<SceneModelPtr> with_joint(const SceneModel& model, Joint joint);

/// Marks a joint, its motors, its sensors and its doors as removed. A joint that closed a loop with
/// it becomes a tree joint. Errors: the joint does not exist.
Result<SceneModelPtr> with_joint_removed(const SceneModel& model, const std::string& name);

/// Changes the limits of one axis of a joint; an empty limit is unchanged. Errors: the joint or
/// axis does not exist, a limit is NaN, lower exceeds upper, or a ball joint gets a lower limit.
Result<SceneModelPtr> with_limits(const SceneModel& model, const std::string& joint, int axis,
                                  std::optional<double> lower, std::optional<double> upper);

/// Makes a body, or all bodies of an assembly, static or dynamic. `closes_loop` of the joints is
/// determined again, because static bodies belong to the ground. Errors: the name is neither a body
/// nor an assembly, a body is kinematic, or a body cannot be dynamic because of its mass or shapes.
Result<SceneModelPtr> with_static(const SceneModel& model, const std::string& name, bool on);

}  // namespace cogrsim
