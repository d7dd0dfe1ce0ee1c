// The options of the backend: MuJoCo's own, by its own names.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/parameter.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::mujoco {

const ParameterTable& world_option_table();

/// Options in force, as MJCF.
struct Options {
  bool implicit = false;  ///< the integrator of this name
  std::string option;     ///< attributes of <option>
  std::string flag;       ///< attributes of <flag>
  std::string solref;     ///< of contacts without restitution
  std::string contact;    ///< other attributes of geoms and pairs
  std::string joint;      ///< attributes of joints, solreflimit …
  std::string equality;   ///< attributes of equalities
};

/// Errors, with source position: of complete_parameters(); lists of wrong length or mixed signs.
Result<Options> read_options(const SceneModel& model);

/// The shortest text that is read back as the same numbers.
std::string numbers(const double* values, std::size_t count);

}  // namespace cogrsim::mujoco
