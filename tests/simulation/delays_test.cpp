// Speed-torque curves, delays of motors and latencies of sensors, against closed forms on a flywheel of
// 0.02 kg m^2.
#include <cmath>
#include <functional>
#include <vector>

#include "../support/temporary_folder.h"
#include "cogrsim/core/constants.h"
#include "cogrsim/simulation/snapshot_file.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

constexpr double kStall = 0.4, kNoLoad = 20.0;                  // [N m], [rad/s]
constexpr double kTau = Flywheel::kInertia * kNoLoad / kStall;  // of the run up [s]: 1

double speed_of(Simulation& s) { return s.frame()->state.joint_velocities[0]; }
double effort_of(Simulation& s) { return s.frame()->state.motor_efforts[0]; }

Flywheel with_curve(MotorMode mode, double target) {
  Flywheel scene(mode);
  Motor& motor = scene.builder.model.motors[0];
  motor.stall_effort = kStall;
  motor.no_load_speed = kNoLoad;
  motor.target = target;
  if (mode == MotorMode::servo) {
    motor.kp = 100.0;
    motor.kd = 0.0;
  }
  return scene;
}

// The wheel turns about z from the start [rad/s].
void turn(Flywheel& scene, double speed) {
  scene.builder.model.joints[0].velocity = {speed};
  scene.builder.model.bodies[0].V_WB.angular = Vec3(0.0, 0.0, speed);
}

// The curve is evaluated at the start of the step, so a step multiplies the distance to the no-load speed
// by 1 - dt / tau instead of exp(-dt / tau): an error of (dt / tau)^2 / 2 in each of t / dt steps,
// v_max (t / tau) exp(-t / tau) dt / (2 tau) in all; twice that for what an engine integrates differently.
double margin(double t, double dt) {
  return kNoLoad * (t / kTau) * std::exp(-t / kTau) * dt / kTau;
}

}  // namespace

TEST_CASE("a wheel runs up along the curve of its motor in every mode", "[motors][curve]") {
  const std::string backend = GENERATE(engines());
  const MotorMode mode =
      GENERATE(MotorMode::torque, MotorMode::velocity, MotorMode::position, MotorMode::servo);
  const double way = GENERATE(1.0, -1.0);
  CAPTURE(backend, to_string(mode), way);
  // More than the motor has, at every speed up to the end.
  Flywheel scene = with_curve(mode, way * (mode == MotorMode::velocity ? 100.0 : 1000.0));
  scene.builder.model.motors[0].max_effort = 10.0;
  auto simulation = simulate(scene.builder.build(), backend);
  for (const double t : {0.5, 1.0, 2.0}) {
    simulation->run_until(t);
    CHECK(way * speed_of(*simulation) ==
          Approx(kNoLoad * (1.0 - std::exp(-t / kTau))).margin(margin(t, simulation->dt()) + 1e-6));
  }
}

TEST_CASE("the largest effort holds below the knee of the curve", "[motors][curve]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene = with_curve(MotorMode::torque, 1.0);
  scene.builder.model.motors[0].max_effort = 0.1;
  auto simulation = simulate(scene.builder.build(), backend);
  // 0.1 = 0.4 (1 - v / 20) at 15 rad/s, reached at 3 s; from there on exponentially to 20 rad/s.
  simulation->run_until(2.9);
  CHECK(speed_of(*simulation) == Approx(0.1 / Flywheel::kInertia * 2.9).epsilon(1e-6));
  simulation->run_until(4.0);
  CHECK(speed_of(*simulation) ==
        Approx(kNoLoad - 5.0 * std::exp(-1.0 / kTau)).margin(margin(1.0, simulation->dt())));
}

TEST_CASE("braking has the whole effort, driving what the curve leaves", "[motors][curve]") {
  const std::string backend = GENERATE(engines());
  const MotorMode mode = GENERATE(MotorMode::torque, MotorMode::velocity, MotorMode::servo);
  CAPTURE(backend, to_string(mode));
  const double way = GENERATE(1.0, -1.0);
  Flywheel scene = with_curve(mode, way * -1000.0);
  scene.builder.model.motors[0].max_effort = 0.3;
  turn(scene, way * 15.0);
  auto simulation = simulate(scene.builder.build(), backend);
  simulation->step();
  simulation->step();
  // Against the motion min(0.3, 0.4 (1 + v / 20)) = 0.3.
  CHECK(effort_of(*simulation) == Approx(way * -0.3).epsilon(1e-6));
  simulation->send(SetMotor{"bot.left", way * 1000.0});
  simulation->step();
  const double v = std::abs(speed_of(*simulation));
  simulation->step();
  // With the motion 0.4 (1 - v / 20), about 0.1.
  CHECK(way * effort_of(*simulation) == Approx(kStall * (1.0 - v / kNoLoad)).epsilon(0.02));
}

TEST_CASE("a motor beyond its no-load speed has no effort but to brake", "[motors][curve]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene = with_curve(MotorMode::torque, 0.3);
  turn(scene, 30.0);
  auto simulation = simulate(scene.builder.build(), backend);
  simulation->run_until(0.5);
  // The engine's own losses of a free wheel, not those of a motor: that would be 7.5 rad/s.
  CHECK(speed_of(*simulation) == Approx(30.0).epsilon(1e-3));
}

TEST_CASE("a velocity motor lifts its load at the speed that the curve leaves", "[motors][curve]") {
  const std::string backend = GENERATE(engines());
  // A slider of 2 kg against gravity: 19.62 N of 30 N leave 0.346 of 1 m/s.
  ModelBuilder builder("hoist");
  const int load = builder.body("bot.load", 2.0, Vec3(0.1, 0.1, 0.1).asDiagonal(), Pose{});
  const int joint = builder.joint("bot.rail", JointType::slider, kWorld, load, Pose{});  // along z
  builder.assembly("bot", {load}, {joint});
  builder.motor("bot.lift", joint, MotorMode::velocity);
  Motor& motor = builder.model.motors[0];
  motor.stall_effort = 30.0;
  motor.no_load_speed = 1.0;
  motor.target = 0.9;
  auto simulation = simulate(builder.build(), backend);
  simulation->run_until(1.0);
  const FramePtr frame = simulation->frame();
  CHECK(frame->state.twists[0].linear.z() == Approx(1.0 - 2.0 * 9.81 / 30.0).margin(0.01));
  CHECK(std::abs(frame->state.motor_efforts[0]) == Approx(2.0 * 9.81).epsilon(0.02));
}

TEST_CASE("a delayed target acts after its delay and not a step before", "[motors][delay]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene(MotorMode::torque);
  scene.builder.model.motors[0].delay = 0.05;
  scene.builder.model.motors[0].target = 0.0;
  auto simulation = simulate(scene.builder.build(), backend);
  const double dt = simulation->dt();
  simulation->run_until(0.1);
  simulation->send(SetMotor{"bot.left", 0.2});
  const auto steps = static_cast<int>(std::lround(0.05 / dt));
  for (int i = 0; i < steps; ++i) simulation->step();
  CHECK(std::abs(speed_of(*simulation)) < 1e-9);
  CHECK(simulation->frame()->motor_targets[0] == 0.0);
  simulation->step();
  CHECK(simulation->frame()->motor_targets[0] == 0.2);
  CHECK(speed_of(*simulation) == Approx(0.2 / Flywheel::kInertia * dt).epsilon(1e-6));
  simulation->run_until(0.4);
  CHECK(speed_of(*simulation) == Approx(0.2 / Flywheel::kInertia * 0.25).epsilon(1e-6));
}

TEST_CASE("every target of a series acts, each after the delay", "[motors][delay]") {
  Flywheel scene(MotorMode::velocity);
  scene.builder.model.motors[0].delay = 0.0105;  // between two steps: at the next boundary
  auto simulation = simulate(scene.builder.build(), all_engines().front());
  REQUIRE(simulation->dt() == Approx(1e-3));
  std::vector<double> acted;
  for (int i = 0; i < 40; ++i) {
    if (i < 20) simulation->send(SetMotor{"bot.left", 0.1 * (i + 1)});
    simulation->step();
    acted.push_back(simulation->frame()->motor_targets[0]);
  }
  for (int i = 0; i < 40; ++i)
    CHECK(acted[static_cast<std::size_t>(i)] ==
          Approx(i < 11 ? 0.0 : 0.1 * std::min(i - 10, 20)).margin(1e-12));
}

TEST_CASE("a reading is delivered after its latency with the time it was measured at",
          "[sensors][delay]") {
  const std::string backend = GENERATE(engines());
  const double rate = GENERATE(0.0, 100.0);
  CAPTURE(backend, rate);
  // At 2 rad/s the encoder counts the angle of the time of the measurement.
  Flywheel scene;
  scene.builder.model.motors[0].target = 2.0;
  SensorModel& encoder = scene.builder.model.sensors[0];
  encoder.latency = 0.025;
  encoder.rate = rate;
  auto simulation = simulate(scene.builder.build(), backend);
  simulation->step();
  CHECK(simulation->reading(0).sequence == 1);  // the first at once
  CHECK(simulation->reading(0).time == 0.0);
  const double dt = simulation->dt();
  std::vector<double> angles;
  angles.push_back(0.0);
  angles.push_back(simulation->frame()->state.joint_positions[0]);
  while (simulation->time() < 0.3 - 0.5 * dt) {
    const double now = simulation->time();  // of the readings in the next step
    simulation->step();
    angles.push_back(simulation->frame()->state.joint_positions[0]);
    const Reading& reading = simulation->reading(0);
    const double age = now - reading.time;
    const double period = rate > 0.0 ? 1.0 / rate : dt;
    if (now < 0.025 + period - 0.5 * dt) continue;
    CHECK(age >= 0.025 - 1e-9);
    CHECK(age < 0.025 + period - 0.5 * dt);
    // Four-fold evaluation of 1024 lines in a turn.
    const auto then = static_cast<std::size_t>(std::lround(reading.time / dt));
    REQUIRE(reading.values.size() >= 1);
    CHECK(reading.values[0] == Approx(angles[then]).margin(2.0 * M_PI / 1024.0));
  }
  CHECK(simulation->reading(0).sequence ==
        static_cast<std::uint64_t>(std::lround((0.3 - dt - 0.025) * (rate > 0.0 ? rate : 1.0 / dt) -
                                               (rate > 0.0 ? 0.45 : 0.0))) +
            1);
}

TEST_CASE("a latency changes no noise: the same readings come later", "[sensors][delay]") {
  const std::string backend = all_engines().front();
  std::vector<std::vector<double>> readings[2];
  for (const double latency : {0.0, 0.02}) {
    Flywheel scene;
    scene.builder.model.motors[0].target = 2.0;
    scene.builder.model.sensors[0].latency = latency;
    scene.builder.model.sensors[0].noise = {{NoiseTerm::Kind::normal, 0.0, 0.1},
                                            {NoiseTerm::Kind::bias_walk, 0.01, 0.0}};
    auto simulation = simulate(scene.builder.build(), backend);
    for (int i = 0; i < 100; ++i) {
      simulation->step();
      readings[latency > 0.0].push_back(simulation->reading(0).values);
    }
  }
  for (std::size_t i = 20; i < 100; ++i) CHECK(readings[1][i] == readings[0][i - 20]);
  CHECK(readings[1][19] == readings[0][0]);
}

TEST_CASE("a sensor that is switched off loses what was in flight", "[sensors][delay]") {
  Flywheel scene;
  scene.builder.model.sensors[0].latency = 0.02;
  auto simulation = simulate(scene.builder.build(), all_engines().front());
  simulation->run_until(0.1);
  CHECK(simulation->reading(0).valid);
  simulation->send(EnableSensor{"bot.encoder", false});
  simulation->run_until(0.2);
  CHECK_FALSE(simulation->reading(0).valid);
  const std::uint64_t before = simulation->reading(0).sequence;
  simulation->send(EnableSensor{"bot.encoder", true});
  simulation->run_until(0.219);
  CHECK(simulation->reading(0).sequence == before);
  simulation->run_until(0.222);
  CHECK(simulation->reading(0).sequence > before);
  CHECK(simulation->reading(0).time >= 0.2 - 1e-9);
}

namespace {

Flywheel delayed() {
  Flywheel scene = with_curve(MotorMode::velocity, 3.0);
  scene.builder.model.motors[0].delay = 0.03;
  scene.builder.model.motors[0].target_signal = "3 rad/s * sin(20 rad/s * time)";
  scene.builder.model.motors[0].target.reset();
  scene.builder.model.sensors[0].latency = 0.04;
  scene.builder.model.sensors[0].noise = {{NoiseTerm::Kind::normal, 0.0, 0.1},
                                          {NoiseTerm::Kind::bias_walk, 0.01, 0.0}};
  return scene;
}

void check_same(const FramePtr& a, const FramePtr& b) {
  CHECK(state_hash(a->state) == state_hash(b->state));
  CHECK(a->motor_targets == b->motor_targets);
  CHECK(a->readings[0].values == b->readings[0].values);
  CHECK(a->readings[0].time == b->readings[0].time);
  CHECK(a->readings[0].sequence == b->readings[0].sequence);
}

}  // namespace

TEST_CASE("what is under way is part of a snapshot, in memory and in a file", "[delay]") {
  const std::string backend = GENERATE(engines());
  CAPTURE(backend);
  const TemporaryFolder folder;
  const SceneModelPtr model = delayed().builder.build();
  auto simulation = simulate(model, backend);
  simulation->run_until(0.2);
  const SimulationSnapshotPtr snapshot = simulation->save();
  REQUIRE(write_snapshot(*simulation, folder / "wheel.snap"));
  simulation->run_until(0.22);  // less than either delay
  const FramePtr soon = simulation->frame();
  simulation->run_until(0.4);
  const FramePtr late = simulation->frame();
  CHECK(soon->readings[0].time < 0.2);
  REQUIRE(simulation->restore(snapshot));
  simulation->run_until(0.22);
  check_same(soon, simulation->frame());
  simulation->run_until(0.4);
  check_same(late, simulation->frame());

  const auto file = SnapshotFile::read(folder / "wheel.snap");
  REQUIRE(file);
  SimulationOptions options;
  options.backend = backend;
  const auto resumed = resume(*file, model, options, loader());
  if (!resumed) FAIL(resumed.error().front().message);
  CHECK(resumed->notes.empty());
  resumed->simulation->run_until(0.22);
  const FramePtr again = resumed->simulation->frame();
  // An engine may keep more than a file has, so the devices are compared, not the hash.
  CHECK(again->motor_targets == soon->motor_targets);
  CHECK(again->readings[0].values == soon->readings[0].values);
  CHECK(again->readings[0].time == soon->readings[0].time);
}

TEST_CASE("a restart forgets what was under way", "[delay]") {
  Flywheel scene = delayed();
  auto simulation = simulate(scene.builder.build(), all_engines().front());
  simulation->run_until(0.1);
  const FramePtr first = simulation->frame();
  simulation->send(Restart{});
  simulation->step();
  simulation->run_until(0.1);
  check_same(first, simulation->frame());
}

TEST_CASE("delays, latencies and curves are drawn for each run", "[randomize][delay]") {
  Flywheel scene = delayed();
  for (const char* what : {"bot.left.delay", "bot.encoder.latency", "bot.left.stall-effort",
                           "bot.left.no-load-speed"}) {
    RandomizeModel randomize;
    randomize.what = what;
    randomize.quantities = {what};
    randomize.numbers = {0.5, 1.5};
    scene.builder.model.randomize.push_back(randomize);
  }
  std::vector<double> delays;
  const SceneModelPtr model = scene.builder.build();
  for (const std::uint64_t seed : {1u, 2u, 1u}) {
    SimulationOptions options;
    options.seed = seed;
    const SceneModelPtr drawn = simulate(model, all_engines().front(), options)->model();
    const Motor& motor = drawn->motors[0];
    delays.push_back(motor.delay);
    CHECK((motor.delay >= 0.015 && motor.delay <= 0.045 && motor.delay != 0.03));
    CHECK((drawn->sensors[0].latency >= 0.02 && drawn->sensors[0].latency <= 0.06));
    CHECK(drawn->sensors[0].latency != 0.04);
    CHECK((motor.stall_effort != kStall && motor.no_load_speed != kNoLoad));
  }
  CHECK(delays[0] != delays[1]);
  CHECK(delays[0] == delays[2]);
}

TEST_CASE("delays that memory is not kept for are refused", "[delay]") {
  const auto refused = [](const std::function<void(SceneModel&)>& change) {
    Flywheel scene = delayed();
    change(scene.builder.model);
    return refusal(scene.builder.build(), all_engines().front());
  };
  CHECK_THAT(refused([](SceneModel& m) { m.motors[0].delay = -0.01; }),
             Catch::Contains("motor 'bot.left' has a delay of -0.01 s"));
  CHECK_THAT(refused([](SceneModel& m) { m.motors[0].delay = kNaN; }), Catch::Contains("delay"));
  CHECK_THAT(refused([](SceneModel& m) { m.sensors[0].latency = 11.0; }),
             Catch::Contains("sensor 'bot.encoder' has a latency of 11 s"));
  CHECK_THAT(refused([](SceneModel& m) {
               m.motors[0].delay = 1.0;
               m.physics.step = 1e-6;
             }),
             Catch::Contains("1000000 of its targets") && Catch::Contains("100000"));
  CHECK_THAT(refused([](SceneModel& m) {
               m.sensors[0].latency = 10.0;
               m.physics.step = 1e-6;
             }),
             Catch::Contains("readings"));
  Flywheel scene = delayed();
  auto simulation = simulate(scene.builder.build(), all_engines().front());
  const double dt = simulation->dt();
  simulation->send(SetStep{1e-9});
  simulation->step();
  CHECK(simulation->dt() == dt);
  REQUIRE_FALSE(simulation->messages().empty());
  CHECK_THAT(simulation->messages().back().message, Catch::Contains("delay"));
}
