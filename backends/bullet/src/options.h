// The options of Bullet's worlds, by Bullet's names and with its defaults.
#pragma once

#include <memory>
#include <string>

#include "cogrsim/core/parameter.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::bullet {

/// Shared, not copied: a world is made again with the same ones.
using OptionsPtr = std::shared_ptr<const Parameters>;

const ParameterTable& world_option_table();

/// Of a scene, complete. Errors: what complete_parameters() finds, with its source position.
Result<OptionsPtr> read_options(const SceneModel& model);

/// A value of complete options.
template <class T>
const T& option(const Parameters& options, const char* key) {
  return std::get<T>(options.at(key));
}

}  // namespace cogrsim::bullet
