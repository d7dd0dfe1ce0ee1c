// The benchmark scenes for CogRSim's own side.
#pragma once

#include <string>

#include "cogrsim/model/scene_model.h"
#include "scene.h"

namespace cogrsim::bench {

/// The scene as a model; bodies in the order of Scene::things. `world_anchors`: for engines that take
/// a joint's place in the world, which is then, to the last digit, what the bare engine's program
/// gives them.
SceneModelPtr model_of(const Scene& scene, bool world_anchors = false);

/// A scene file of `count` boxes, some of them in pairs on hinges.
std::string scene_text(int count);

}  // namespace cogrsim::bench
