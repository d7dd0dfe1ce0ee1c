// Small scenes and simulations of them.
#pragma once

#include <memory>
#include <string>

#include "../support/engines.h"
#include "../support/flywheel.h"
#include "../support/runs.h"

namespace cogrsim::test {

std::shared_ptr<PluginLoader> loader();

std::unique_ptr<Simulation> simulate(const SceneModelPtr& scene, const std::string& backend,
                                     SimulationOptions options = {});

std::string refusal(const SceneModelPtr& scene, const std::string& backend);

/// With an encoder "encoder".
struct Flywheel : BareFlywheel {
  explicit Flywheel(MotorMode mode = MotorMode::velocity);
  /// The controller "probe_controller".
  void add_controller(const std::string& mode, double rate = 0.0,
                FaultPolicy policy = FaultPolicy::stop_controller);
};

/// A ball falling freely, 10 m up.
ModelBuilder falling_ball();

}  // namespace cogrsim::test
