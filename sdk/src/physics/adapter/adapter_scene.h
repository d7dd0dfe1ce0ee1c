// A scene as the JSON that goes to an adapter.
#pragma once

#include <string>

#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// Bodies, joints, motors, couplings, the surfaces of pairs of materials, meshes and heights, the pairs
/// that never collide, and the options of the engine `name`; `options` are those of the world. The
/// page docs/plugins/backends-in-any-language.md lists the members.
std::string scene_for_adapter(const SceneModel& model, const std::string& name,
                              const Parameters& options);

/// Options as a flat JSON object.
std::string options_for_adapter(const Parameters& options);

}  // namespace cogrsim
