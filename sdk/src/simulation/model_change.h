// New scene models from old ones: what a running simulation adds and removes.
#pragma once

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

}  // namespace cogrsim
