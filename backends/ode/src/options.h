// The options of `<ode …/>`, by ODE's own names and with its own defaults.
#pragma once

#include "cogrsim/core/parameter.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::ode {

enum class Solver { automatic, step, quick };

struct Options {
  Solver solver = Solver::automatic;
  int iterations = 20;
  double sor = 1.3, erp = 0.2, cfm = 1e-10;
  double contact_max_correcting_velocity = 0.0;  ///< [m/s]; 0: any
  double contact_surface_layer = 0.0;            ///< [m]
  double contact_slip = 0.0;                     ///< [m/(N s)]
  bool pyramid = true;                           ///< dContactApprox1
  int max_contacts = 32;
  unsigned long seed = 0;
};

const ParameterTable& world_option_table();

/// Those of the model, completed by the defaults. Errors: as complete_parameters(), with the place.
Result<Options> read_options(const SceneModel& model);

/// The world's step: dWorldQuickStep, else dWorldStep.
bool is_quick(const Options& options, const SceneModel& model);

}  // namespace cogrsim::ode
