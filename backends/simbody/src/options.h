// The options of the backend: Simbody's own, by its own names, and those of contact.
#pragma once

#include <Simbody.h>

#include <memory>
#include <string>

#include "collision/compliant_contact.h"

#include "cogrsim/core/parameter.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::simbody {

const ParameterTable& world_option_table();

struct Options {
  std::string integrator;
  double accuracy = 1e-3;
  int substeps = 0;
  bool trackers = false;  ///< contact="simbody"
  dynamics::CompliantLaw contact;
  double modulus = 0.0, stop_dissipation = 0.0;
};

Options options_from(const Parameters& complete);
/// The integrator's class as Simbody calls it.
std::string integrator_class(const std::string& name);

/// An integrator for steps of `dt` [s] at most, not yet initialized.
std::unique_ptr<SimTK::Integrator> make_integrator(const Options& options,
                                                   const SimTK::System& system, double dt);

}  // namespace cogrsim::simbody
