// Changing a running world: only by commands, at step boundaries.
#include "../support/temporary_folder.h"
#include "cogrsim/simulation/snapshot_file.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

SceneModelPtr crate_fragment() {
  ModelBuilder builder("crate");
  builder.box("crate", Vec3(0.2, 0.2, 0.2), 1.0, Pose{});
  return builder.build();
}

SceneModelPtr floor_and_ball() {
  ModelBuilder builder("floor and ball");
  builder.sphere("ball", 0.1, 1.0, Pose(Vec3(0, 0, 0.1), Quat(1, 0, 0, 0)));
  builder.plane("floor");
  return builder.build();
}

}  // namespace

TEST_CASE("an assembly is added and removed while the rest stays", "[commands]") {
  const std::string backend = GENERATE(engines());
  auto simulation = simulate(floor_and_ball(), backend);
  simulation->run_until(0.2);
  const Vec3 ball = simulation->frame()->state.poses[0].p;
  simulation->send(AddAssembly{crate_fragment(), "late", Pose(Vec3(2, 0, 1), Quat(1, 0, 0, 0))});
  simulation->step();
  REQUIRE(find_body(*simulation->model(), "late.crate") == 2);
  CHECK((simulation->frame()->state.poses[0].p - ball).norm() < 1e-6);
  simulation->run_until(1.5);
  CHECK(simulation->frame()->state.poses[2].p.z() == Approx(0.1).margin(1e-3));
  simulation->send(Remove{"late"});
  simulation->run_until(1.6);
  CHECK(find_body(*simulation->model(), "late.crate") == -1);
  CHECK((simulation->frame()->state.poses[0].p - ball).norm() < 1e-5);
  // The name is free again, and existing indices stay.
  simulation->send(AddAssembly{crate_fragment(), "late", Pose(Vec3(2, 0, 1), Quat(1, 0, 0, 0))});
  simulation->step();
  CHECK(find_body(*simulation->model(), "late.crate") == 3);
  CHECK(messages_of(*simulation).empty());
}

TEST_CASE("commands that cannot be carried out are reported and change nothing", "[commands]") {
  const std::string backend = GENERATE(engines());
  auto simulation = simulate(floor_and_ball(), backend);
  auto undisturbed = simulate(floor_and_ball(), backend);
  simulation->send(Remove{"bal"});
  simulation->send(SetMotor{"left", 1.0});
  simulation->send(AddAssembly{crate_fragment(), "ball", Pose{}});
  simulation->send(SetKinematicTwist{"ball", Twist{}});
  Flywheel broken;
  broken.add_controller("missing-devices");
  simulation->send(
      AddAssembly{broken.builder.build(), "robot", Pose(Vec3(5, 5, 5), Quat(1, 0, 0, 0))});
  simulation->run_until(0.1);
  undisturbed->run_until(0.1);
  const std::string said = messages_of(*simulation);
  CHECK(said.find("cannot remove 'bal'") != std::string::npos);
  CHECK(said.find("there is no motor 'left'") != std::string::npos);
  CHECK(said.find("the name is taken") != std::string::npos);
  CHECK(said.find("cannot add assembly 'robot'") != std::string::npos);
  CHECK(said.find("lfet") != std::string::npos);
  CHECK(find_assembly(*simulation->model(), "robot") == -1);
  const auto ball = [](const Simulation& s) {
    return const_cast<Simulation&>(s).frame()->state.poses[0].p;
  };
  CHECK((ball(*simulation) - ball(*undisturbed)).norm() < 1e-9);
  CHECK(simulation->status() == RunStatus::running);
}

TEST_CASE("an assembly that fails and cannot be removed stays in model and world", "[commands]") {
  auto simulation = simulate(falling_ball().build(), "toy_sticky");
  ModelBuilder builder("robot");
  const int torso = builder.box("bot.torso", Vec3(0.2, 0.2, 0.2), 1.0, Pose{});
  ControllerModel driver;
  driver.name = "bot.driver";
  driver.plugin = "probe_controller";
  driver.assembly = builder.assembly("bot", {torso}, {});
  driver.parameters["mode"] = std::string("missing-devices");
  builder.model.controllers.push_back(driver);
  simulation->send(AddAssembly{builder.build(), "late", Pose(Vec3(2, 0, 1), Quat(1, 0, 0, 0))});
  CHECK(simulation->run_until(0.01) == RunStatus::completed);
  const std::string said = messages_of(*simulation);
  CHECK(said.find("cannot add assembly 'late'") != std::string::npos);
  CHECK(said.find("lfet") != std::string::npos);
  CHECK(said.find("a sticky world lets nothing go") != std::string::npos);
  const FramePtr frame = simulation->frame();
  CHECK(frame->state.poses.size() == 2);
  CHECK(frame->model->bodies.size() == frame->state.poses.size());
  CHECK(find_body(*frame->model, "late.bot.torso") == 1);
  CHECK(frame->controller_outputs.size() == frame->model->controllers.size());
}

TEST_CASE("an added robot brings its controller", "[commands]") {
  const std::string backend = GENERATE(engines());
  auto simulation = simulate(floor_and_ball(), backend);
  simulation->run_until(0.05);
  Flywheel robot;
  robot.add_controller("drive");
  simulation->send(
      AddAssembly{robot.builder.build(), "guest", Pose(Vec3(0, 0, 3), Quat(1, 0, 0, 0))});
  simulation->run_until(0.3);
  CHECK(messages_of(*simulation).empty());
  CHECK(simulation->frame()->state.joint_velocities[0] == Approx(2.0).margin(1e-6));
}

TEST_CASE("restart equals a fresh run, bit for bit", "[commands]") {
  const std::string backend = GENERATE(engines());
  auto simulation = simulate(floor_and_ball(), backend);
  simulation->run_until(0.3);
  const std::uint64_t hash = state_hash(simulation->frame()->state);
  simulation->send(AddAssembly{crate_fragment(), "late", Pose(Vec3(0, 0, 1), Quat(1, 0, 0, 0))});
  simulation->run_until(0.7);
  simulation->send(Restart{});
  simulation->step();
  CHECK(simulation->time() == Approx(1e-3));
  simulation->run_until(0.3);
  CHECK(state_hash(simulation->frame()->state) == hash);
}

TEST_CASE("a removed observer is not called any more", "[commands]") {
  int first = 0, second = 0;
  auto simulation = simulate(falling_ball().build(), "bullet");
  Observation own = simulation->observe({}, [&](const FramePtr&) {
    if (++first == 2) own.end();  // by itself, while it is called
  });
  Observation other = simulation->observe({}, [&](const FramePtr&) { ++second; });
  for (int i = 0; i < 3; ++i) simulation->step();  // and the start
  CHECK(first == 2);
  CHECK(second == 4);
  other.end();
  other.end();
  simulation->step();
  CHECK(second == 4);
  Observation late = simulation->observe({}, [](const FramePtr&) {});
  simulation.reset();
  late.end();  // its owner is gone
}

TEST_CASE("observers see the start of every run, after a restart too", "[commands]") {
  auto simulation = simulate(floor_and_ball(), "bullet");
  std::vector<std::uint64_t> steps;
  simulation->observe({}, [&](const FramePtr& frame) { steps.push_back(frame->step); });
  simulation->step();
  simulation->step();
  simulation->send(Restart{});
  simulation->step();
  simulation->step();
  CHECK(steps == std::vector<std::uint64_t>{0, 1, 2, 0, 1, 2});
}

TEST_CASE("a run continues from a snapshot bit for bit, noise included", "[commands]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene;
  scene.add_controller("drive");
  scene.builder.model.sensors[0].noise = {{NoiseTerm::Kind::normal, 0.0, 0.1},
                                          {NoiseTerm::Kind::bias_walk, 0.01, 0.0}};
  auto simulation = simulate(scene.builder.build(), backend);
  simulation->run_until(0.2);
  const SimulationSnapshotPtr snapshot = simulation->save();
  simulation->run_until(0.4);
  const FramePtr first = simulation->frame();
  REQUIRE(simulation->restore(snapshot));
  CHECK(simulation->time() == Approx(0.2));
  simulation->run_until(0.4);
  const FramePtr second = simulation->frame();
  CHECK(state_hash(first->state) == state_hash(second->state));
  CHECK(first->readings[0].values == second->readings[0].values);
}

TEST_CASE("a restart after resuming from a file has no efforts of the snapshot", "[commands]") {
  SimulationOptions options;
  options.backend = GENERATE(engines());
  Flywheel flywheel(MotorMode::torque);
  flywheel.builder.model.motors[0].target = 0.5;
  const SceneModelPtr scene = flywheel.builder.build();
  const auto effort_at_start = [](Simulation& simulation) {
    const WorldState& state = simulation.frame()->state;
    return std::pair(state.joint_efforts.at(0), state.motor_efforts.at(0));
  };
  auto simulation = simulate(scene, options.backend);
  const auto fresh = effort_at_start(*simulation);
  simulation->run_until(0.1);
  REQUIRE(simulation->frame()->state.motor_efforts[0] == Approx(0.5));
  const TemporaryFolder folder;
  REQUIRE(write_snapshot(*simulation, folder / "wheel.snap"));
  const auto file = SnapshotFile::read(folder / "wheel.snap");
  REQUIRE(file);
  auto resumed = resume(*file, scene, options, loader());
  REQUIRE(resumed);
  CHECK(effort_at_start(*resumed->simulation).second == Approx(0.5));
  resumed->simulation->send(Pause{});
  resumed->simulation->send(Restart{});
  resumed->simulation->step();
  REQUIRE(resumed->simulation->step_count() == 0);
  CHECK(effort_at_start(*resumed->simulation) == fresh);
}

TEST_CASE("a supervisor observes and ends the run", "[commands]") {
  const std::string backend = GENERATE(engines());
  auto builder = falling_ball();
  ControllerModel supervisor;
  supervisor.name = "referee";
  supervisor.plugin = "probe_supervisor";
  supervisor.parameters["height"] = 9.0;
  builder.model.supervisors.push_back(supervisor);
  auto simulation = simulate(builder.build(), backend);
  CHECK(simulation->run_until(5.0) == RunStatus::stopped);
  // 1 m of free fall takes sqrt(2/g) = 0.4515 s.
  CHECK(simulation->time() == Approx(0.4515).margin(3e-3));
  CHECK(messages_of(*simulation).find("fell below the line") != std::string::npos);
}

TEST_CASE("a motor takes its target from a command, within its limits", "[commands]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene;
  scene.builder.model.motors[0].max_speed = 3.0;
  auto simulation = simulate(scene.builder.build(), backend);
  simulation->send(SetMotor{"bot.left", 50.0});
  simulation->run_until(0.1);
  CHECK(simulation->frame()->state.joint_velocities[0] == Approx(3.0).margin(1e-9));
}
