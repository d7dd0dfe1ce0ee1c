// The options of `<ode …/>`, by ODE's own names and with its own defaults.
#pragma once

#include "cogrsim/core/parameter.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::ode {

struct Options {
  bool quick = true;  ///< dWorldQuickStep, else dWorldStep
  int iterations = 20;
  double sor = 1.3, erp = 0.2, cfm = 1e-10;
  double contact_max_correcting_velocity = 0.0;  ///< [m/s]; 0: any
  double contact_surface_layer = 0.0;            ///< [m]
  bool pyramid = true;                           ///< dContactApprox1
};

const ParameterTable& world_option_table();

/// Those of the model and the defaults. Errors: as complete_parameters(), with its source position.
Result<Options> read_options(const SceneModel& model);

}  // namespace cogrsim::ode
