// A controller in its own process gives bit-identical results to one in the simulation's process.
#include <cstdio>
#include <filesystem>

#include "../support/engines.h"
#include "../support/temporary_folder.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/simulation/snapshot_file.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

/// Compiled from a file; the test fails with what the compiler says.
SceneModelPtr scene_of(const std::string& path) {
  const auto plugins = loader();
  dsl::LoaderCatalog catalog(plugins);
  dsl::CompileOptions options;
  options.plugins = &catalog;
  const auto compiled = dsl::compile_file(path, options);
  if (!compiled.ok()) UNSCOPED_INFO(dsl::to_text(compiled.diagnostics));
  REQUIRE(compiled.ok());
  return compiled.model;
}

/// The same scene with all controllers out-of-process.
SceneModelPtr out_of_process(const SceneModelPtr& scene) {
  auto changed = std::make_shared<SceneModel>(*scene);
  for (ControllerModel& controller : changed->controllers) controller.isolation = Isolation::process;
  for (TemplateModel& made : changed->templates) {
    if (made.fragment) made.fragment = out_of_process(made.fragment);
  }
  return changed;
}

/// All results of a run: states after every hundredth step, outputs, readings, messages.
std::string traces(Simulation& simulation, double until) {
  std::string out;
  while (simulation.time() < until - 1e-9) {
    simulation.run_until(std::min(until, simulation.time() + 0.1));
    const FramePtr frame = simulation.frame();
    out += std::to_string(state_hash(frame->state)) + "\n";
    for (const auto& outputs : frame->controller_outputs) {
      for (const double value : outputs) out += std::to_string(value) + " ";
    }
    for (const Reading& reading : frame->readings) {
      out += reading.enabled ? "+" : "-";
      out += reading.valid ? "+" : "-";
      for (const double value : reading.values) out += std::to_string(value) + " ";
    }
  }
  return out + messages_of(simulation);
}

const std::string kLaboratory = COGRSIM_TEST_SCENES "/laboratory.scene.xml";

}  // namespace

TEST_CASE("a controller that uses the whole interface works in its own process", "[containment]") {
  const std::string backend = GENERATE(engines());
  const SceneModelPtr scene = scene_of(kLaboratory);
  const std::string here = traces(*simulate(scene, backend), 0.4);
  const std::string there = traces(*simulate(out_of_process(scene), backend), 0.4);
  CHECK(here == there);
  CHECK(here.find("'student' of 'lab': at ") != std::string::npos);
  // The comparison detects a controller with different inputs.
  auto other = std::make_shared<SceneModel>(*scene);
  other->controllers[0].parameters["number"] = 1.26;
  CHECK(traces(*simulate(other, backend), 0.4) != here);
}

TEST_CASE("the controllers of the examples do the same in their own processes", "[containment]") {
  const std::string backend = GENERATE(engines());
  const std::string example = GENERATE("010_two_wheels/two_wheels", "040_servo_arm/arm",
                                       "050_navigation/navigation", "060_transport/transport");
  const SceneModelPtr scene =
      scene_of(std::string(COGRSIM_EXAMPLES) + "/" + example + ".scene.xml");
  REQUIRE_FALSE(scene->controllers.empty());
  const std::string here = traces(*simulate(scene, backend), 0.5);
  const std::string there = traces(*simulate(out_of_process(scene), backend), 0.5);
  CHECK(here == there);
}

TEST_CASE("snapshots carry a controller's process over", "[containment]") {
  const SceneModelPtr scene = scene_of(kLaboratory);
  const TemporaryFolder folder;
  const std::string file = folder / "laboratory.snap";
  auto whole = simulate(out_of_process(scene), "bullet");
  whole->run_until(0.2);
  REQUIRE(write_snapshot(*whole, file));
  SimulationOptions options;
  options.backend = "bullet";
  // Loaded into either, it continues identically.
  std::string rest[2];
  for (const bool own : {false, true}) {
    const auto resumed =
        resume(*SnapshotFile::read(file), own ? out_of_process(scene) : scene, options, loader());
    REQUIRE(resumed);
    CHECK(resumed->same_scene);
    rest[own] = traces(*resumed->simulation, 0.3);
  }
  CHECK(rest[0] == rest[1]);
}

TEST_CASE("a run in memory goes back with its controller's random numbers", "[containment]") {
  std::string after[2];
  for (const bool own : {false, true}) {
    const SceneModelPtr scene = scene_of(kLaboratory);
    auto simulation = simulate(own ? out_of_process(scene) : scene, "bullet");
    simulation->run_until(0.1);
    const auto snapshot = simulation->save();
    simulation->run_until(0.2);
    REQUIRE(simulation->restore(snapshot));
    after[own] = traces(*simulation, 0.2);
    REQUIRE(simulation->restore(snapshot, true));
    after[own] += traces(*simulation, 0.2);
  }
  CHECK(after[0] == after[1]);
}
