// Simulations for tests, and their messages.
#pragma once

#include <catch2/catch.hpp>

#include <memory>
#include <string>
#include <utility>

#include "cogrsim/simulation/simulation.h"

namespace cogrsim::test {

/// A simulation, or the test fails with the diagnostics of create().
inline std::unique_ptr<Simulation> simulate(const SceneModelPtr& scene,
                                            const SimulationOptions& options,
                                            std::shared_ptr<PluginLoader> plugins) {
  auto simulation = Simulation::create(scene, options, std::move(plugins));
  if (!simulation) {
    for (const Diagnostic& d : simulation.error()) UNSCOPED_INFO(d.code << " " << d.message);
  }
  REQUIRE(simulation);
  return std::move(*simulation);
}

/// The diagnostics of create() for a scene that must be refused, one line each.
inline std::string refusal(const SceneModelPtr& scene, const std::string& backend,
                           std::shared_ptr<PluginLoader> plugins) {
  SimulationOptions options;
  options.backend = backend;
  auto simulation = Simulation::create(scene, options, std::move(plugins));
  REQUIRE_FALSE(simulation);
  std::string out;
  for (const Diagnostic& d : simulation.error())
    out += d.code + " " + d.message + "\n" + d.help + "\n";
  return out;
}

/// The messages of a run, except those of its backend at the start about approximations.
inline std::vector<RunMessage> run_messages(const Simulation& simulation) {
  std::vector<RunMessage> out;
  for (const RunMessage& m : simulation.messages()) {
    if (m.source != "backend") out.push_back(m);
  }
  return out;
}

/// run_messages() with their times, a line each.
inline std::string messages_of(const Simulation& simulation) {
  std::string out;
  for (const RunMessage& m : run_messages(simulation)) {
    out += std::to_string(m.time) + " " + m.source + ": " + m.message + "\n";
  }
  return out;
}

/// Of a flywheel that was run for longer: its controller had a fault at `time`, reported once, and
/// the run ended there or continued without it, according to the policy.
inline void check_fault(Simulation& simulation, RunStatus end, FaultPolicy policy, double time) {
  REQUIRE(run_messages(simulation).size() == 1);
  CHECK(run_messages(simulation)[0].time == Approx(time));
  if (policy == FaultPolicy::end_run) {
    CHECK(end == RunStatus::fault);
    CHECK(simulation.time() == Approx(time));
  } else {
    CHECK(end == RunStatus::completed);
    // Without its controller the wheel comes to rest.
    CHECK(simulation.frame()->state.joint_velocities[0] == Approx(0.0).margin(1e-9));
  }
}

}  // namespace cogrsim::test
