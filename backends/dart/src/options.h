// The options of `<dart …/>`, by DART's own names and with its own defaults but one.
#pragma once

#include "cogrsim/core/parameter.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::dart_engine {

struct Options {
  bool pgs = false;  ///< PgsBoxedLcpSolver, else DantzigBoxedLcpSolver and Pgs where that fails
  int max_iteration = 30;
  double delta_x_threshold = 1e-6, relative_delta_x_tolerance = 1e-3;
  double epsilon_for_division = 1e-9;
  std::size_t max_num_contacts = 10000;
};

const ParameterTable& world_option_table();

/// Those of the model and the defaults. Errors: as complete_parameters(), with its source position.
Result<Options> read_options(const SceneModel& model);

}  // namespace cogrsim::dart_engine
