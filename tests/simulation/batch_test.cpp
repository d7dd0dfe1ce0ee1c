// Many worlds at once give the results of single worlds, with any number of threads.
#include <atomic>
#include <cmath>
#include <new>
#include <thread>

#include "cogrsim/simulation/batch.h"
#include "cogrsim/simulation/simulation.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

/// A driven pendulum that hits a ball on a floor, with noisy sensors: contacts, joints,
/// motors and random streams in one scene. `load`: mass of the bob [kg].
SceneModelPtr knocker(double load = 0.5) {
  ModelBuilder b("knocker");
  b.plane("floor");
  const int ball = b.sphere("ball", 0.05, 0.2, Pose(Vec3(0.2, 0, 0.05), Quat(1, 0, 0, 0)));
  static_cast<void>(ball);
  const int bob = b.sphere("arm.bob", 0.05, load, Pose(Vec3(-0.1, 0, 0.06), Quat(1, 0, 0, 0)));
  const int slide =
      b.joint("arm.slide", JointType::slider, kWorld, bob,
              Pose(Vec3(-0.1, 0, 0.06), Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitX())));
  const int arm = b.assembly("arm", {bob}, {slide});
  b.motor("arm.push", slide, MotorMode::velocity);
  b.model.motors[0].assembly = arm;
  SensorModel imu;
  imu.name = "arm.imu";
  imu.type = "imu";
  imu.body = bob;
  imu.assembly = arm;
  imu.rate = 200.0;
  imu.noise.push_back({NoiseTerm::Kind::normal, 0.0, 0.1, 0});
  b.model.sensors.push_back(imu);
  return b.build();
}

BatchOptions knocker_options(const std::string& backend, int threads) {
  BatchOptions options;
  options.backend = backend;
  options.threads = threads;
  options.actions = {"arm.push"};
  options.observations = {"ball.x", "arm.slide.position", "arm.imu[0]"};
  return options;
}

std::unique_ptr<Batch> made(tl::expected<std::unique_ptr<Batch>, std::vector<Diagnostic>> batch) {
  if (!batch) {
    for (const Diagnostic& d : batch.error()) UNSCOPED_INFO(d.code << " " << d.message);
  }
  REQUIRE(batch);
  return std::move(*batch);
}

std::string said(const std::vector<Diagnostic>& found) {
  std::string out;
  for (const Diagnostic& d : found) {
    out += d.message + "\n" + d.help + "\n";
    for (const DiagnosticNote& note : d.notes) out += note.message + "\n";
  }
  return out;
}

/// The commands of world `i` in the k-th call.
double target(int i, int k) { return 0.3 + 0.1 * std::sin(i + 0.7 * k); }

std::vector<std::uint64_t> hashes(Batch& batch) {
  std::vector<std::uint64_t> out;
  for (int i = 0; i < batch.size(); ++i) out.push_back(state_hash(batch.world(i).frame()->state));
  return out;
}

}  // namespace

TEST_CASE("worlds of a batch are single simulations bit for bit on any number of threads",
          "[batch]") {
  const std::string backend = GENERATE(engines());
  const int threads = GENERATE(1, 3, 4);
  constexpr int kWorlds = 8, kCalls = 40, kSteps = 25;
  std::vector<SceneModelPtr> scenes;
  for (int i = 0; i < kWorlds; ++i) scenes.push_back(knocker(0.5 + 0.1 * i));
  BatchOptions options = knocker_options(backend, threads);
  for (int i = 0; i < kWorlds; ++i) options.seeds.push_back(static_cast<std::uint64_t>(100 + i));
  const auto batch = made(Batch::create(scenes, options, loader()));
  CHECK(batch->threads() == threads);
  for (int k = 0; k < kCalls; ++k) {
    for (int i = 0; i < kWorlds; ++i) batch->actions()(i, 0) = target(i, k);
    batch->step(kSteps);
  }
  for (int i = 0; i < kWorlds; ++i) {
    SimulationOptions alone;
    alone.seed = options.seeds[i];
    const auto single = simulate(scenes[i], backend, alone);
    for (int k = 0; k < kCalls; ++k) {
      single->send(SetMotor{"arm.push", target(i, k)});
      for (int n = 0; n < kSteps; ++n) single->step();
    }
    const FramePtr frame = single->frame();
    CAPTURE(backend, i);
    CHECK(state_hash(batch->world(i).frame()->state) == state_hash(frame->state));
    CHECK(batch->observations()(i, 2) == frame->readings[0].values[0]);
    CHECK(batch->steps_made()[i] == kSteps);
  }
  // The ball was hit, and the worlds are independent.
  CHECK(batch->observations()(0, 0) > 0.25);
  const auto all = hashes(*batch);
  CHECK(all[0] != all[1]);
}

TEST_CASE("worlds that share a scene differ by their seeds alone", "[batch]") {
  const std::string backend = GENERATE(engines());
  BatchOptions options = knocker_options(backend, 2);
  options.seeds = {7, 8, 7};
  const auto batch = made(Batch::create(knocker(), 3, options, loader()));
  batch->step(100);
  const auto seen = batch->observations();
  CHECK(seen(0, 2) == seen(2, 2));
  CHECK(seen(0, 2) != seen(1, 2));  // the imu's noise
  CHECK(seen(0, 1) == seen(1, 1));  // which nothing acts upon
  // Without seeds: those that follow the scene's.
  options.seeds.clear();
  const auto other = made(Batch::create(knocker(), 2, options, loader()));
  CHECK(other->seed(1) == other->seed(0) + 1);
}

TEST_CASE("a world of a batch that is reset equals a new simulation of that seed", "[batch]") {
  const std::string backend = GENERATE(engines());
  const auto scene = knocker();
  const auto batch = made(Batch::create(scene, 3, knocker_options(backend, 2), loader()));
  batch->actions().setConstant(0.5);
  batch->step(700);
  const double far = batch->observations()(0, 0);
  CHECK(far > 0.25);
  REQUIRE(batch->reset(1, 4711));
  REQUIRE(batch->reset(2));
  CHECK(batch->seed(1) == 4711);
  CHECK(batch->seed(2) == episode_seed(scene->physics.seed + 2, 1));
  CHECK(batch->episode(2) == 1);
  CHECK(batch->world(1).time() == 0.0);
  // At the start the imu has not read anything.
  CHECK(batch->observations()(1, 0) == Approx(0.2).margin(1e-12));
  CHECK(std::isnan(batch->observations()(1, 2)));
  batch->step(300);
  CHECK(batch->observations()(0, 0) != far);  // the one that was not reset continues
  for (const int i : {1, 2}) {
    SimulationOptions alone;
    alone.seed = batch->seed(i);
    const auto single = simulate(scene, backend, alone);
    single->send(SetMotor{"arm.push", 0.5});
    single->run_until(0.3);
    const FramePtr frame = single->frame();
    CHECK(state_hash(batch->world(i).frame()->state) == state_hash(frame->state));
    CHECK(batch->observations()(i, 2) == frame->readings[0].values[0]);
  }
  batch->reset_all();
  CHECK(batch->episode(0) == 1);
  CHECK(batch->episode(2) == 2);
  CHECK(batch->observations()(0, 0) == Approx(0.2).margin(1e-12));
}

TEST_CASE("episodes of a batch end by condition and by time and restart", "[batch]") {
  const std::string backend = GENERATE(engines());
  BatchOptions options = knocker_options(backend, 2);
  options.done = "arm.slide.position gt 0.1";
  options.duration = 0.4;
  options.auto_reset = GENERATE(true, false);
  const auto batch = made(Batch::create(knocker(), 2, options, loader()));
  CHECK(std::isnan(batch->final_observations()(0, 0)));
  CHECK(batch->end_message(0).empty());
  batch->actions()(0, 0) = 0.5;  // 0.1 m in 0.2 s and what it takes to get going
  batch->actions()(1, 0) = 0.1;  // not in 0.4 s
  batch->step(300);
  REQUIRE(batch->ends()[0] == EpisodeEnd::done);
  CHECK(batch->ends()[1] == EpisodeEnd::none);
  CHECK(batch->end_message(0) == "arm.slide.position gt 0.1");
  // The speed source is at 0.5 m/s after one step, so the limit is passed 0.5 mm late at most.
  CHECK(batch->final_observations()(0, 1) > 0.1);
  CHECK(batch->final_observations()(0, 1) < 0.1006);
  const auto steps = batch->steps_made();
  CHECK(steps[0] < 210);
  CHECK(steps[1] == 300);
  if (options.auto_reset) {
    CHECK(batch->world(0).time() == 0.0);
    CHECK(batch->observations()(0, 1) == Approx(0.0).margin(1e-12));
    CHECK(batch->episode(0) == 1);
  } else {
    CHECK(batch->observations()(0, 1) == batch->final_observations()(0, 1));
  }
  batch->run_until(0.5);
  CHECK(batch->ends()[0] == EpisodeEnd::done);  // again, or still
  CHECK(batch->steps_made()[0] == (options.auto_reset ? steps[0] : 0));
  CHECK(batch->ends()[1] == EpisodeEnd::time);
  CHECK(batch->steps_made()[1] == 100);
  CHECK(batch->episode(0) == (options.auto_reset ? 2u : 0u));
  batch->step(10);
  CHECK(batch->steps_made()[1] == (options.auto_reset ? 10 : 0));
  CHECK(batch->ends()[1] == (options.auto_reset ? EpisodeEnd::none : EpisodeEnd::time));
}

TEST_CASE("a world of a batch that diverges does not stop the others", "[batch]") {
  const std::string backend = GENERATE(engines());
  auto diverging = falling_ball();
  diverging.model.bodies[0].V_WB.linear = Vec3(2e10, 0, 0);
  BatchOptions options;
  options.backend = backend;
  options.threads = 2;
  options.observations = {"ball.z"};
  const auto batch = made(Batch::create(
      {falling_ball().build(), diverging.build(), falling_ball().build()}, options, loader()));
  batch->step(200);
  CHECK(batch->ends()[0] == EpisodeEnd::none);
  CHECK(batch->ends()[1] == EpisodeEnd::diverged);
  CHECK(batch->end_message(1).find("'ball'") != std::string::npos);
  CHECK(batch->world(2).time() == Approx(0.2));
  // g t^2 / 2 = 0.196 m, and at most g t dt / 2 = 1 mm from it; see conformance.
  CHECK(batch->observations()(2, 0) == Approx(10.0 - 0.1962).margin(1.1e-3));
  batch->step(1);
  CHECK(batch->ends()[1] == EpisodeEnd::diverged);
  // With a stable scene it continues.
  REQUIRE(batch->reset(1, falling_ball().build()));
  batch->step(200);
  CHECK(batch->ends()[1] == EpisodeEnd::none);
  CHECK(batch->observations()(1, 0) == Approx(10.0 - 0.1962).margin(1.1e-3));
}

TEST_CASE("controllers in a batch run and fault each in its own world", "[batch]") {
  const std::string backend = GENERATE(engines());
  Flywheel good, bad;
  good.add_controller("drive", 100.0);
  bad.add_controller("throw-in-update", 100.0, FaultPolicy::end_run);
  BatchOptions options;
  options.backend = backend;
  options.threads = 2;
  options.observations = {"bot.axle.velocity"};
  std::vector<SceneModelPtr> scenes(6, good.builder.build());
  scenes[3] = bad.builder.build();
  const auto batch = made(Batch::create(scenes, options, loader()));
  batch->step(200);
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    CHECK((batch->ends()[i] == EpisodeEnd::fault) == (i == 3));
  }
  CHECK(batch->end_message(3).find("cell 9 of 8") != std::string::npos);
  CHECK(batch->observations()(0, 0) != 0.0);
  CHECK(batch->observations()(0, 0) == batch->observations()(5, 0));
}

TEST_CASE("a target that is not a number leaves the motor unchanged and is reported", "[batch]") {
  const std::string backend = GENERATE(engines());
  const auto batch = made(Batch::create(knocker(), 2, knocker_options(backend, 1), loader()));
  batch->actions().setConstant(0.2);
  batch->step(10);
  batch->actions()(1, 0) = std::nan("");
  batch->step(10);
  CHECK(batch->observations()(0, 1) == batch->observations()(1, 1));
  CHECK(messages_of(batch->world(0)).empty());
  CHECK(messages_of(batch->world(1)).find("'arm.push': the target is not a finite number") !=
        std::string::npos);
}

TEST_CASE("an invalid batch is refused with the available names", "[batch]") {
  const auto refused = [](BatchOptions options, std::vector<SceneModelPtr> scenes) {
    auto batch = Batch::create(scenes, options, loader());
    REQUIRE_FALSE(batch);
    return said(batch.error());
  };
  const BatchOptions good = knocker_options("bullet", 2);
  const auto scene = knocker();
  CHECK(said(Batch::create({scene}, good, nullptr).error()).find("loader") != std::string::npos);
  BatchOptions o = good;
  o.actions = {"arm.psuh"};
  CHECK(refused(o, {scene}).find("did you mean 'arm.push'?") != std::string::npos);
  o = good;
  o.observations = {"ball.x", "bal.x"};
  CHECK(refused(o, {scene, scene}).find("'bal'") != std::string::npos);
  o = good;
  o.done = "ball.x gt";
  CHECK_FALSE(refused(o, {scene}).empty());
  o = good;
  o.seeds = {1, 2, 3};
  CHECK(refused(o, {scene, scene}).find("3 seeds for 2 worlds") != std::string::npos);
  o = good;
  o.duration = 0.0;
  CHECK(refused(o, {scene}).find("duration") != std::string::npos);
  o = good;
  o.threads = -1;
  CHECK(refused(o, {scene}).find("threads") != std::string::npos);
  o = good;
  o.backend = "bulet";
  CHECK(refused(o, {scene}).find("bullet") != std::string::npos);
  CHECK(refused(good, {}).find("at least one world") != std::string::npos);
  CHECK(refused(good, {scene, nullptr}).find("has no scene") != std::string::npos);
  // If one of several scenes lacks the motor, its number is reported.
  CHECK(refused(good, {scene, falling_ball().build()}).find("world 1") != std::string::npos);
  const auto none = Batch::create(scene, 0, good, loader());
  REQUIRE_FALSE(none);
  CHECK(said(none.error()).find("at least one world is needed, not 0") != std::string::npos);

  const auto batch = made(Batch::create(scene, 2, good, loader()));
  CHECK_FALSE(batch->reset(2));
  CHECK_FALSE(batch->reset(-1));
  CHECK_FALSE(batch->reset(0, SceneModelPtr()));
  CHECK_FALSE(batch->reset(0, falling_ball().build()));  // lacks the motor; the world stays
  batch->step(3);
  CHECK(batch->world(0).step_count() == 3);
}

TEST_CASE("a batch rewards with a signal at the end of each call, also of an ended episode",
          "[batch]") {
  BatchOptions options = knocker_options(GENERATE(engines()), 2);
  options.reward = "2 * ball.x";
  options.duration = 0.03;
  options.auto_reset = true;
  const auto batch = made(Batch::create(knocker(), 3, options, loader()));
  CHECK(batch->rewards() == std::vector<double>(3, 0.0));
  batch->actions().setConstant(1.0);
  batch->step(20);
  for (int i = 0; i < 3; ++i) {
    CHECK(batch->rewards()[i] == 2.0 * batch->observations()(i, 0));
  }
  batch->step(20);  // the episode ends after 30 steps, and the next one has begun
  for (int i = 0; i < 3; ++i) {
    REQUIRE(batch->ends()[i] == EpisodeEnd::time);
    CHECK(batch->rewards()[i] == 2.0 * batch->final_observations()(i, 0));
  }
  options.reward = "bal.x";
  const auto refused = Batch::create(knocker(), 1, options, loader());
  REQUIRE_FALSE(refused);
  CHECK(said(refused.error()).find("ball") != std::string::npos);
}

TEST_CASE("worlds and spawns share the meshes and heights of their scene", "[batch]") {
  const std::string backend = GENERATE(engines());
  TriangleMesh wedge;
  wedge.name = "wedge";
  wedge.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  wedge.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  ModelBuilder part("part");
  part.mesh("part", wedge, true, 1.0, {});
  ModelBuilder yard("yard");
  wedge.name = "rock";
  yard.mesh("rock", wedge, true, 1.0, Pose(Vec3(0, 0, 9), Quat(1, 0, 0, 0)));
  const SceneModelPtr fragment = part.build();
  yard.model.templates.push_back({"Part", fragment, {}});
  HeightGrid hill;
  hill.columns = hill.rows = 2;
  hill.heights = {0.0, 0.0, 0.0, 0.1};
  yard.heightmap("hill", hill, Pose(Vec3(30, 0, -9), Quat(1, 0, 0, 0)));
  const SceneModelPtr scene = yard.build();
  BatchOptions options;
  options.backend = backend;
  const auto batch = made(Batch::create(scene, 2, options, loader()));
  for (int i = 0; i < 2; ++i) {
    Spawn spawn;
    spawn.of = "Part";
    for (const double x : {5.0, 9.0}) {
      spawn.name = x < 6.0 ? "first" : "second";
      spawn.pose = Pose(Vec3(x, 0, 5), Quat(1, 0, 0, 0));
      batch->world(i).send(spawn);
    }
  }
  batch->step(2);
  std::vector<MeshPtr> meshes = scene->meshes;
  meshes.push_back(fragment->meshes[0]);
  for (int i = 0; i < 2; ++i) {
    const SceneModel& model = *batch->world(i).model();
    CAPTURE(backend, i);
    REQUIRE(find_body(model, "second.part") >= 0);
    CHECK(model.meshes == meshes);  // the same objects
    CHECK(model.heightmaps == scene->heightmaps);
  }
}

TEST_CASE("a batch writes its observations into a table of the caller", "[batch]") {
  const auto scene = knocker();
  const BatchOptions options = knocker_options("cogrsim", 2);
  const auto own = made(Batch::create(scene, 4, options, loader()));
  const auto other = made(Batch::create(scene, 4, options, loader()));
  Batch::RowMajor table = Batch::RowMajor::Zero(4, 3);
  other->observe_into(table.data());
  CHECK(table(0, 0) == own->observations()(0, 0));  // the current values, at once
  for (const auto& batch : {own.get(), other.get()}) batch->step(30);
  CHECK(table == own->observations());
  CHECK(other->observations().data() == table.data());
  other->observe_into(nullptr);
  CHECK(other->observations() == table);
  const Batch::RowMajor before = table;
  for (const auto& batch : {own.get(), other.get()}) batch->step(30);
  CHECK(table == before);
  CHECK(other->observations() == own->observations());
}

TEST_CASE("a restart takes another seed", "[batch]") {
  const std::string backend = GENERATE(engines());
  const auto scene = knocker();
  const auto reading_after = [&](Simulation& run) {
    run.run_until(0.1);
    return run.frame()->readings[0].values[0];
  };
  SimulationOptions options;
  options.seed = 5;
  const double at_5 = reading_after(*simulate(scene, backend, options));
  options.seed = 6;
  const auto run = simulate(scene, backend, options);
  const double at_6 = reading_after(*run);
  CHECK(at_5 != at_6);
  run->send(Restart{5});
  run->step();
  CHECK(reading_after(*run) == at_5);
  run->send(Restart{});  // stays with it
  run->step();
  CHECK(reading_after(*run) == at_5);
}
