// The options of the backend: Simbody's own, by its own names, and those of contact.
#pragma once

#include <Simbody.h>

#include <memory>
#include <string>

#include "cogrsim/core/parameter.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::simbody {

const ParameterTable& world_option_table();

struct Options {
  std::string integrator;
  double accuracy = 1e-3;
  int substeps = 0;
  bool trackers = false;  ///< contact="simbody"
  double stiffness = 0.0, frequency = 0.0, dissipation = 0.0, impact_speed = 1.0;
  double transition_velocity = 0.01, modulus = 0.0;
  double stop_dissipation = 0.0;
};

Options options_from(const Parameters& complete);
/// Errors: what complete_parameters() finds, with its source position.
Result<Options> read_options(const SceneModel& model);

/// The integrator's class as Simbody calls it.
std::string integrator_class(const std::string& name);

/// An integrator for steps of `dt` [s] at most, not yet initialized.
std::unique_ptr<SimTK::Integrator> make_integrator(const Options& options,
                                                   const SimTK::System& system, double dt);

/// Hunt and Crossley's dissipation c [s/m] of a linear spring, f = k x (1 + c xdot), from which a body
/// that comes with `speed` [m/s] leaves with `restitution` of it. Restitutions below 0.04 count as
/// 0.04, c = 25 s/m at 1 m/s: overlap is taken back at 1 / c at most.
double dissipation_of(double restitution, double speed);

}  // namespace cogrsim::simbody
