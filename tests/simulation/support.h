// Small scenes and simulations of them.
#pragma once

#include <catch2/catch.hpp>

#include <memory>
#include <string>

#include "cogrsim/model/builder.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim::test {

/// The engines every test here runs on.
inline auto both_backends() {
  return Catch::Generators::values<std::string>({"bullet", "simbody"});
}

std::shared_ptr<PluginLoader> loader();

/// A simulation, or the test fails with what create() said.
std::unique_ptr<Simulation> simulate(const SceneModelPtr& scene, const std::string& backend,
                                     SimulationOptions options = {});

/// What create() said of a scene that must be refused, one line each.
std::string refusal(const SceneModelPtr& scene, const std::string& backend);

/// A flywheel (I = 0.02 kg m^2 about its axle) in a robot "bot", with a motor "left" and an
/// encoder "encoder"; no gravity. The builder can still be changed.
struct Flywheel {
  static constexpr double kInertia = 0.02;
  ModelBuilder builder{"flywheel"};
  int assembly = -1, wheel = -1, joint = -1, motor = -1;

  explicit Flywheel(MotorMode mode = MotorMode::velocity);
  void add_mind(const std::string& mode, double rate = 0.0,
                FaultPolicy policy = FaultPolicy::stop_controller);
};

/// All messages of a run, a line each.
std::string messages_of(const Simulation& simulation);

/// A ball falling freely, 10 m up.
ModelBuilder falling_ball();

}  // namespace cogrsim::test
