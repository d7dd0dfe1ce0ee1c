// Exact conversion of a scene model to text and back, so that a recording needs neither the scene
// files nor the scene compiler.
#pragma once

#include <string>
#include <string_view>

#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// The model as JSON, without the contents of meshes and heightmaps. Numbers are exact to the last
/// bit; infinities and NaN are the texts "inf", "-inf" and "nan".
std::string model_to_json(const SceneModel& model);

/// Parses the output of model_json(); missing fields have their defaults. Errors: the text is not
/// JSON, or a value has the wrong type.
Result<SceneModel> model_from_json(std::string_view text);

/// Checks that all indices of a model from a file are valid and that its sizes are consistent.
/// Errors: for example "'robot.axle' has a wrong child".
Result<> check_model(const SceneModel& model);
/// As check_model(), without the contents of meshes and heightmaps.
Result<> check_references(const SceneModel& model);

}  // namespace cogrsim
