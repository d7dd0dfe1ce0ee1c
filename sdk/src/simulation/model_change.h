// New scene models from old ones: what a running simulation adds and removes.
#pragma once

#include <optional>
#include <string>

#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// More bodies than this in one run, removed ones counted, are refused.
inline constexpr std::size_t kMaxBodies = 100000;

/// `model` with the elements of `fragment` at the end, in a new assembly `name`, its world frame at
/// `pose`. Errors: a name that is taken or empty, too many bodies.
Result<SceneModelPtr> with_added(const SceneModel& model, const SceneModel& fragment,
                                 const std::string& name, const Pose& pose);

/// `model` with the assembly (or a body that belongs to none), all in it and all joints to it marked
/// as removed, and what hangs on those: motors, sensors, doors, regions. Errors: no such assembly or
/// body, with what there is; a body inside an assembly.
Result<SceneModelPtr> with_removed(const SceneModel& model, const std::string& name);

/// `model` with `joint` at the end: between bodies that are there, holding them as `joint` says.
/// Decides `closes_loop` of it; empty axes are filled with plain ones. Errors: a name that is empty
/// or taken, an end that is not there, both ends the same, axes that do not fit the type or have
/// limits the wrong way round, too many joints.
Result<SceneModelPtr> with_joint(const SceneModel& model, Joint joint);

/// `model` without a joint, its motors, the sensors on it and the doors it moves. A joint that
/// closed a loop with it carries from now on. Errors: no such joint.
Result<SceneModelPtr> with_joint_removed(const SceneModel& model, const std::string& name);

/// `model` with other limits on one axis of a joint; empty: as it was.
/// Errors: no such joint or axis, not a number, lower not below upper, a lower limit on a ball.
Result<SceneModelPtr> with_limits(const SceneModel& model, const std::string& joint, int axis,
                                  std::optional<double> lower, std::optional<double> upper);

/// `model` with a body, or all bodies of an assembly, made static or dynamic again; which joints
/// close loops is decided anew, since static bodies are ground. Errors: neither body nor assembly;
/// kinematic bodies; bodies made dynamic without mass, or with shapes that only static bodies have.
Result<SceneModelPtr> with_static(const SceneModel& model, const std::string& name, bool on);

}  // namespace cogrsim
