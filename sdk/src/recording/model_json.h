// A scene model as text, to the last bit, so that a recording needs neither scene files nor the
// scene compiler.
#pragma once

#include <string>
#include <string_view>

#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// Everything but the contents of meshes and heightmaps. Numbers are written so that reading gives
/// the same bits; infinities and NaN are the texts "inf", "-inf" and "nan".
std::string model_to_json(const SceneModel& model);

/// The reverse; what is missing keeps its default. Errors: no JSON, a value of the wrong type.
Result<SceneModel> model_from_json(std::string_view text);

/// Refuses a model whose indices point nowhere or whose sizes do not fit each other: what came from
/// a file must not lead anybody astray. Errors: "'robot.axle' has a wrong child".
Result<> check_model(const SceneModel& model);
/// The same without a look into meshes and heightmaps.
Result<> check_references(const SceneModel& model);

}  // namespace cogrsim
