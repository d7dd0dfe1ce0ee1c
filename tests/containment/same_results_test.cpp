// A controller in its own process does to the last bit what it does in the simulation's.
#include <cstdio>
#include <filesystem>

#include "../support/catalog.h"
#include "../support/engines.h"
#include "../support/temporary_folder.h"
#include "cogrsim/simulation/snapshot_file.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

/// Compiled from a file; the test fails with what the compiler says.
SceneModelPtr scene_of(const std::string& path) {
  const auto plugins = loader();
  LoadingCatalog catalog(*plugins);
  dsl::CompileOptions options;
  options.plugins = &catalog;
  const auto compiled = dsl::compile_file(path, options);
  if (!compiled.ok()) UNSCOPED_INFO(dsl::to_text(compiled.diagnostics));
  REQUIRE(compiled.ok());
  return compiled.model;
}

/// The same scene with all controllers apart.
SceneModelPtr apart(const SceneModelPtr& scene) {
  auto changed = std::make_shared<SceneModel>(*scene);
  for (ControllerModel& mind : changed->controllers) mind.isolation = Isolation::process;
  for (TemplateModel& made : changed->templates) {
    if (made.fragment) made.fragment = apart(made.fragment);
  }
  return changed;
}

/// All that a run leaves: states after every hundredth step, outputs, readings, messages.
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

TEST_CASE("a controller that uses everything finds it all in its own process", "[containment]") {
  const std::string backend = GENERATE(engines());
  const SceneModelPtr scene = scene_of(kLaboratory);
  const std::string here = traces(*simulate(scene, backend), 0.4);
  const std::string there = traces(*simulate(apart(scene), backend), 0.4);
  CHECK(here == there);
  CHECK(here.find("'student' of 'lab': at ") != std::string::npos);
  // The comparison sees a controller that sees something else.
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
  const std::string there = traces(*simulate(apart(scene), backend), 0.5);
  CHECK(here == there);
}

TEST_CASE("snapshots carry a controller's process over", "[containment]") {
  const SceneModelPtr scene = scene_of(kLaboratory);
  const TemporaryFolder folder;
  const std::string file = folder / "laboratory.snap";
  auto whole = simulate(apart(scene), "bullet");
  whole->run_until(0.2);
  REQUIRE(write_snapshot(*whole, file));
  SimulationOptions options;
  options.backend = "bullet";
  // Loaded into either, it goes on in the same way.
  std::string rest[2];
  for (const bool own : {false, true}) {
    const auto resumed =
        resume(*SnapshotFile::read(file), own ? apart(scene) : scene, options, loader());
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
    auto simulation = simulate(own ? apart(scene) : scene, "bullet");
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
