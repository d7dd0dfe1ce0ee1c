// The options of the backend: MuJoCo's own, by its own names.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/parameter.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::mujoco {

const ParameterTable& world_option_table();
/// What materials, joints and couplings may have of their own, by the world's names.
const ParameterTable& element_option_table(std::string_view element);

/// Options in force.
struct Options {
  Parameters values;      ///< the world's
  bool implicit = false;  ///< the integrator of this name
  std::string option;     ///< attributes of <option>
  std::string flag;       ///< attributes of <flag>

  /// The world's, with those of an element in their place.
  Parameters with(const std::map<std::string, Parameters>& blocks) const;
  /// Attributes of joints, solreflimit …
  std::string joint(const Joint& joint) const;
  /// Attributes of equalities.
  std::string equality(const std::map<std::string, Parameters>& blocks) const;
};

/// The first number of the solref of contacts that bounce.
double bounce_stiffness(const SceneModel& model);

/// Errors, with source position: of complete_parameters(); lists of wrong length or mixed signs.
Result<Options> read_options(const SceneModel& model);

/// The shortest text that is read back as the same numbers.
std::string numbers(const double* values, std::size_t count);

}  // namespace cogrsim::mujoco
