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

/// `model` with the assembly, all in it and all joints to it marked as removed.
/// Errors: no such assembly, with what there is.
Result<SceneModelPtr> with_removed(const SceneModel& model, const std::string& name);

/// `model` with `joint` at the end: between bodies that are there, holding them as `joint` says.
/// Decides `closes_loop` of it. Errors: a name that is taken, an end that is not there.
Result<SceneModelPtr> with_joint(const SceneModel& model, Joint joint);

/// `model` without a joint, its motors and the sensors on it. Errors: no such joint.
Result<SceneModelPtr> with_joint_removed(const SceneModel& model, const std::string& name);

/// `model` with other limits on one axis of a joint; empty: as it was.
/// Errors: no such joint or axis, lower not below upper.
Result<SceneModelPtr> with_limits(const SceneModel& model, const std::string& joint, int axis,
                                  std::optional<double> lower, std::optional<double> upper);

/// `model` with a body, or all bodies of an assembly, made static or dynamic again. Errors: neither
/// body nor assembly; kinematic or massless bodies.
Result<SceneModelPtr> with_static(const SceneModel& model, const std::string& name, bool on);

}  // namespace cogrsim
