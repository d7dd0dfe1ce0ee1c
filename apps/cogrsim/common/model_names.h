// Which names a scene has from the start.
#pragma once

#include <algorithm>
#include <string>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::cli {

/// Whether an element that can have signals has this dotted name.
inline bool in_scene(const SceneModel& model, const std::string& name) {
  const auto among = [&](const auto& elements) {
    return std::any_of(elements.begin(), elements.end(),
                       [&](const auto& element) { return element.name == name; });
  };
  return among(model.bodies) || among(model.assemblies) || among(model.frames) ||
         among(model.joints) || among(model.motors) || among(model.sensors) ||
         among(model.controllers) || among(model.supervisors) || among(model.regions) ||
         among(model.doors);
}

}  // namespace cogrsim::cli
