// Inputs of controllers: numbers that somebody sets while the run goes.
#include <cmath>

#include "../support/temporary_folder.h"
#include "cogrsim/simulation/snapshot_file.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::Contains;

namespace {

ControllerModel asker(Isolation isolation) {
  ControllerModel controller;
  controller.plugin = "asker";
  controller.rate = 1000.0;
  controller.isolation = isolation;
  return controller;
}

double asked(Simulation& simulation) { return simulation.frame()->controller_outputs[0][0]; }

/// What the controller has in the step after these commands.
double after(Simulation& simulation, const SetInput& command) {
  simulation.send(command);
  simulation.step();
  return asked(simulation);
}

}  // namespace

TEST_CASE("an input reaches its controller in the next step", "[inputs]") {
  auto simulation =
      simulate(flywheel(asker(GENERATE(Isolation::none, Isolation::process))), "bullet");
  simulation->step();
  CHECK(asked(*simulation) == 1.0);
  const std::vector<ControllerInputs> all = simulation->controller_inputs();
  REQUIRE(all.size() == 1);
  CHECK(all[0].controller == "bot.driver");
  REQUIRE(all[0].inputs.size() == 1);
  const ControllerInput& input = all[0].inputs[0];
  CHECK((input.name == "speed" && input.unit == "rad/s"));
  CHECK((input.lower == -2.0 && input.upper == 3.0 && input.value == 1.0));
  CHECK(after(*simulation, {"bot.driver", "speed", 2.5}) == 2.5);
  CHECK(simulation->controller_inputs()[0].inputs[0].value == 2.5);
  // By the assembly that has this controller alone; it stays.
  CHECK(after(*simulation, {"bot", "speed", -2.0}) == -2.0);
  simulation->run_until(0.1);
  CHECK(asked(*simulation) == -2.0);
  CHECK(messages_of(*simulation).empty());
  simulation->send(Restart{});
  simulation->step();
  simulation->step();
  CHECK(asked(*simulation) == 1.0);
}

TEST_CASE("inputs that there are not, and values outside of their limits, are refused",
          "[inputs]") {
  auto simulation = simulate(flywheel(asker(Isolation::none)), "bullet");
  for (const double wrong : {3.1, -2.1, std::nan(""), HUGE_VAL})
    CHECK(after(*simulation, {"bot", "speed", wrong}) == 1.0);
  CHECK_THAT(messages_of(*simulation),
             Contains("input 'speed' of 'bot.driver': 3.1 is not from -2 to 3"));
  CHECK(after(*simulation, {"bot", "sped", 2.0}) == 1.0);
  CHECK_THAT(messages_of(*simulation),
             Contains("has no input 'sped'") && Contains("did you mean 'speed'?"));
  CHECK(after(*simulation, {"bod.driver", "speed", 2.0}) == 1.0);
  CHECK_THAT(messages_of(*simulation), Contains("there is no controller 'bod.driver'"));
}

TEST_CASE("inputs are part of snapshots", "[inputs]") {
  const SceneModelPtr scene = flywheel(asker(GENERATE(Isolation::none, Isolation::process)));
  auto simulation = simulate(scene, "bullet");
  after(*simulation, {"bot", "speed", 2.5});
  const auto kept = simulation->save();
  const TemporaryFolder folder;
  const std::string file = (folder.path / "a.snap").string();
  REQUIRE(write_snapshot(*simulation, file));
  CHECK(after(*simulation, {"bot", "speed", 0.5}) == 0.5);
  REQUIRE(simulation->restore(kept));
  simulation->step();
  CHECK(asked(*simulation) == 2.5);
  const auto read = SnapshotFile::read(file);
  REQUIRE(read);
  SimulationOptions options;
  options.backend = "bullet";
  const auto resumed = resume(*read, scene, options, loader());
  REQUIRE(resumed);
  resumed->simulation->step();
  CHECK(asked(*resumed->simulation) == 2.5);
}

TEST_CASE("a resumed run has the scene's start of inputs that nobody had set", "[inputs]") {
  const auto isolation = GENERATE(Isolation::none, Isolation::process);
  const auto scene = [&](double start) {
    ControllerModel controller = asker(isolation);
    controller.parameters["start"] = start;
    return flywheel(controller);
  };
  auto simulation = simulate(scene(1.0), "bullet");
  simulation->run_until(0.01);
  const TemporaryFolder folder;
  const auto resumed = [&](const char* name) {
    const std::string file = (folder.path / name).string();
    REQUIRE(write_snapshot(*simulation, file));
    const auto read = SnapshotFile::read(file);
    REQUIRE(read);
    SimulationOptions options;
    options.backend = "bullet";
    auto edited = resume(*read, scene(-1.5), options, loader());
    REQUIRE(edited);
    edited->simulation->step();
    return asked(*edited->simulation);
  };
  CHECK(resumed("start.snap") == -1.5);
  after(*simulation, {"bot", "speed", 2.5});
  CHECK(resumed("set.snap") == 2.5);
}

TEST_CASE("another plugin does not have the inputs of the previous one", "[inputs]") {
  auto simulation = simulate(flywheel(asker(Isolation::none)), "bullet");
  after(*simulation, {"bot", "speed", 2.5});
  const TemporaryFolder folder;
  const std::string file = (folder.path / "a.snap").string();
  REQUIRE(write_snapshot(*simulation, file));
  const auto read = SnapshotFile::read(file);
  REQUIRE(read);
  ControllerModel other = asker(Isolation::none);
  other.plugin = "counter";
  SimulationOptions options;
  options.backend = "bullet";
  const auto resumed =
      resume(*read, flywheel(other), options, loader(COGRSIM_TEST_CONTROLLERS "/version_1"));
  REQUIRE(resumed);
  CHECK(resumed->simulation->controller_inputs()[0].inputs[0].value == 1.0);
}

TEST_CASE("a controller that has stopped has no inputs", "[inputs]") {
  ControllerModel controller = asker(GENERATE(Isolation::none, Isolation::process));
  controller.parameters["wrong"] = std::string("throw");
  auto simulation = simulate(flywheel(controller), "bullet");
  simulation->run_until(0.01);
  CHECK(simulation->controller_inputs().empty());
  after(*simulation, {"bot", "speed", 2.5});
  CHECK_THAT(messages_of(*simulation), Contains("controller 'bot.driver' has stopped"));
}

TEST_CASE("an input that is declared while the run goes is a fault", "[inputs]") {
  ControllerModel controller = asker(GENERATE(Isolation::none, Isolation::process));
  controller.parameters["wrong"] = std::string("late");
  auto simulation = simulate(flywheel(controller), "bullet");
  simulation->run_until(0.01);
  CHECK_THAT(messages_of(*simulation),
             Contains("input 'late' is declared after configure() has ended"));
  CHECK(simulation->controller_inputs().empty());
}

TEST_CASE("going back in a run gives inputs the value that they had, set or not", "[inputs]") {
  auto simulation =
      simulate(flywheel(asker(GENERATE(Isolation::none, Isolation::process))), "bullet");
  simulation->step();
  const auto kept = simulation->save();
  after(*simulation, {"bot", "speed", 2.5});
  REQUIRE(simulation->restore(kept));
  simulation->step();
  CHECK(asked(*simulation) == 1.0);
}

TEST_CASE("inputs that are declared wrongly are errors of the scene", "[inputs]") {
  const auto isolation = GENERATE(Isolation::none, Isolation::process);
  const auto said = [&](const char* wrong) {
    ControllerModel controller = asker(isolation);
    controller.parameters["wrong"] = std::string(wrong);
    return refusal(flywheel(controller));
  };
  CHECK_THAT(said("twice"), Contains("input 'speed' is declared twice"));
  CHECK_THAT(said("limits"), Contains("input 'a': its limits 1 and -1 are no range"));
  CHECK_THAT(said("nan"), Contains("are no range"));
  CHECK_THAT(said("value"), Contains("input 'a': its value 2 is not from -1 to 1"));
  CHECK_THAT(said("name"), Contains("a name has 1 to 100 bytes"));
  for (const char* text : {"bytes", "control", "unit"})
    CHECK_THAT(said(text), Contains("are UTF-8 without control characters"));
  CHECK_THAT(said("many"), Contains("a controller has at most 64"));
}
