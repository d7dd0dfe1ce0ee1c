// Time, rates, pause, speed: wall-clock time never changes a result.
#include <cmath>

#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

TEST_CASE("a controller ticks k times in k periods, whatever the step", "[clock]") {
  const std::string backend = GENERATE(engines());
  const double rate = GENERATE(50.0, 30.0, 7.0, 400.0);
  const double dt = GENERATE(1e-3, 7e-3);
  Flywheel scene;
  scene.add_controller("count", rate);
  scene.builder.model.motors[0].max_speed = 1e9;
  scene.builder.model.physics.step = dt;
  auto simulation = simulate(scene.builder.build(), backend);
  const int steps = static_cast<int>(std::lround(4.2 / dt));
  for (int i = 0; i < steps; ++i) simulation->step();
  // The controller writes its tick count into the motor; ticks fall due at k / rate up to the
  // start of the last step, but not more than one a step.
  const double last_start = (steps - 1) * dt;
  const double expected = 1.0 / rate < dt ? steps : std::floor(last_start * rate + 1e-6) + 1.0;
  const FramePtr frame = simulation->frame();
  CHECK(frame->state.joint_velocities[0] == Approx(expected).margin(1e-6));
}

TEST_CASE("time does not drift over a hundred thousand steps", "[clock]") {
  auto builder = falling_ball();
  builder.model.physics.gravity = Vec3::Zero();
  auto simulation = simulate(builder.build(), "bullet");
  simulation->run_until(100.0);
  CHECK(simulation->step_count() == 100000);
  CHECK(simulation->time() == 100000 * 1e-3);
}

TEST_CASE("chopped runs, other speeds and observers give bit-identical states", "[clock]") {
  const std::string backend = GENERATE(engines());
  const auto scene = [] {
    auto builder = falling_ball();
    builder.plane("floor");
    builder.model.bodies[0].X_WB.p.z() = 0.15;
    return builder.build();
  }();
  auto straight = simulate(scene, backend);
  CHECK(straight->run_until(0.5) == RunStatus::completed);
  const std::uint64_t hash = state_hash(straight->frame()->state);

  auto chopped = simulate(scene, backend);
  for (int i = 1; i <= 50; ++i) chopped->run_until(0.01 * i);
  CHECK(state_hash(chopped->frame()->state) == hash);

  SimulationOptions paced;
  paced.speed = 10.0;
  auto slow = simulate(scene, backend, paced);
  int frames = 0;
  slow->observe({true, true, true}, [&frames](const FramePtr&) { ++frames; });
  slow->run_until(0.5);
  CHECK(state_hash(slow->frame()->state) == hash);
  CHECK(frames == 501);  // the start and every step
}

TEST_CASE("a pause stops the time, single steps advance it, resume continues", "[clock]") {
  auto simulation = simulate(falling_ball().build(), "cogrsim");
  simulation->send(Pause{});
  CHECK(simulation->run_until(1.0) == RunStatus::running);
  CHECK(simulation->step_count() == 0);
  simulation->send(StepOnce{});
  simulation->send(StepOnce{});
  simulation->run_until(1.0);
  CHECK(simulation->step_count() == 2);
  CHECK(simulation->paused());
  simulation->send(Resume{});
  CHECK(simulation->run_until(0.01) == RunStatus::completed);
  CHECK(simulation->step_count() == 10);
}

TEST_CASE("a changed step keeps the time continuous", "[clock]") {
  auto simulation = simulate(falling_ball().build(), "cogrsim");
  simulation->run_until(0.1);
  simulation->send(SetStep{5e-4});
  simulation->run_until(0.2);
  CHECK(simulation->time() == Approx(0.2).margin(1e-12));
  CHECK(simulation->step_count() == 300);
  simulation->send(SetStep{-1.0});
  simulation->step();
  CHECK(messages_of(*simulation).find("the step must be at least 1e-9 s") != std::string::npos);
  CHECK(simulation->dt() == 5e-4);
}

TEST_CASE("stop ends the run at the next boundary", "[clock]") {
  auto simulation = simulate(falling_ball().build(), "bullet");
  simulation->observe({}, [&](const FramePtr& frame) {
    if (frame->step == 7) simulation->stop();
  });
  CHECK(simulation->run_until(1.0) == RunStatus::stopped);
  CHECK(simulation->step_count() == 7);
}

TEST_CASE("unusable options are refused", "[clock]") {
  SimulationOptions options;
  options.step = -1.0;
  CHECK_FALSE(Simulation::create(falling_ball().build(), options, loader()));
  options.step = 0.0;
  options.speed = 0.0;
  CHECK_FALSE(Simulation::create(falling_ball().build(), options, loader()));
}
