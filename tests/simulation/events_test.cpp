// The event system: doors, regions, rules, objects that are added and removed during a run.
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

SceneModelPtr ball_fragment(double radius = 0.1) {
  ModelBuilder builder("ball");
  builder.sphere("ball", radius, 1.0, Pose(Vec3(0, 0, radius), Quat(1, 0, 0, 0)));
  return builder.build();
}

Pose at(double x, double y, double z) { return Pose(Vec3(x, y, z), Quat(1, 0, 0, 0)); }

/// A floor, a crate "crate" on it, a door "door" that slides 1 m along x at 1 m/s, a ball that flies
/// along y at 1 m/s without gravity through the region "goal", which is 0.4 m wide and begins after
/// 0.8 m; and a template "Ball".
struct Yard {
  ModelBuilder builder{"yard"};
  int door = -1;
  explicit Yard(bool gravity = false) {
    if (!gravity) builder.model.physics.gravity = Vec3::Zero();
    builder.plane("floor");
    builder.box("crate", Vec3(0.2, 0.2, 0.2), 1.0, at(5, 5, 0.1));
    const int leaf = builder.box("leaf", Vec3(1, 0.1, 1), 2.0, at(0, 4, 1));
    const int slider = builder.joint("slide", JointType::slider, kWorld, leaf,
                                     Pose(Vec3(0, 4, 1), z_to(Vec3(1, 0, 0))));
    const int motor = builder.motor("drive", slider, MotorMode::position);
    builder.model.motors[0].max_speed = 1.0;
    builder.model.motors[0].max_effort = 500.0;
    const int ball = builder.sphere("ball", 0.1, 1.0, at(0, 0, 1));
    builder.model.bodies[ball].V_WB.linear = Vec3(0, 1, 0);
    DoorModel made;
    made.name = "door";
    made.motor = motor;
    builder.model.doors.push_back(made);
    RegionModel region;
    region.name = "goal";
    region.size = Vec3(0.4, 0.4, 0.4);
    region.X_BR = at(0, 1, 1);
    builder.model.regions.push_back(region);
    builder.model.templates.push_back({"Ball", ball_fragment(), {}});
  }
  RuleModel& rule(const std::string& name, std::vector<Action> actions) {
    RuleModel made;
    made.name = name;
    made.actions = std::move(actions);
    builder.model.rules.push_back(std::move(made));
    return builder.model.rules.back();
  }
  RuleModel& on(const std::string& name, const std::string& kind, const std::string& source,
                std::vector<Action> actions) {
    RuleModel& made = rule(name, std::move(actions));
    made.kind = kind;
    made.source = source;
    return made;
  }
};

/// "0.800 enter goal ball" of every event of a run.
struct Diary {
  std::vector<Event> events;
  std::vector<double> times;  // of the frames they are in
  explicit Diary(Simulation& simulation) {
    simulation.observe({}, [this](const FramePtr& frame) {
      for (const Event& event : frame->events) {
        events.push_back(event);
        times.push_back(frame->time);
      }
    });
  }
  double time_of(const std::string& kind, const std::string& source = "") const {
    for (const Event& e : events)
      if (e.kind == kind && (source.empty() || e.source == source)) return e.time;
    return -1.0;
  }
  int count(const std::string& kind) const {
    return static_cast<int>(std::count_if(events.begin(), events.end(),
                                          [&](const Event& e) { return e.kind == kind; }));
  }
};

}  // namespace

TEST_CASE("a door opens on an event and reports its arrival", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  yard.on("open it", "enter", "goal", {MoveDoor{"door", true}}).subject = "ball";
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  simulation->run_until(3.0);
  CHECK(messages_of(*simulation).empty());
  // The ball reaches the region's border at 0.8 m and leaves it at 1.2 m; a step is 1 ms.
  CHECK(diary.time_of("enter") == Approx(0.8).margin(2.1e-3));
  CHECK(diary.time_of("leave") == Approx(1.2).margin(2.1e-3));
  CHECK(diary.time_of("opening") == Approx(diary.time_of("enter")).margin(1.1e-3));
  // 1 m at no more than 1 m/s, so 0.98 s to the tolerance of the open position; a position drive
  // with a time constant of 50 ms needs a few of these to settle.
  CHECK(diary.time_of("opened") >= diary.time_of("opening") + 0.98);
  CHECK(diary.time_of("opened") <= diary.time_of("opening") + 1.5);
  const double q = simulation->frame()->state.joint_positions[0];
  CHECK(q == Approx(1.0).margin(0.02));
  CHECK(diary.events.size() == 4);
  // Commanded to its position: no event.
  simulation->send(MoveDoor{"door", true});
  simulation->run_until(3.1);
  CHECK(diary.events.size() == 4);
}

TEST_CASE("a door that is held back does not arrive", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  yard.builder.box("wall", Vec3(0.1, 1, 1), 0.0, at(1.05, 4, 1));  // 0.5 m from the leaf's edge
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  simulation->send(MoveDoor{"door", true});
  simulation->run_until(3.0);
  CHECK(diary.count("opening") == 1);
  CHECK(diary.count("opened") == 0);
}

TEST_CASE("a body in a region at the start does not enter it", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  yard.builder.model.regions[0].X_BR = at(0, 0, 1);
  yard.builder.model.regions[0].who = {"ball"};
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  simulation->run_until(0.5);
  CHECK(diary.count("enter") == 0);
  CHECK(diary.time_of("leave") == Approx(0.2).margin(2.1e-3));
}

TEST_CASE("a period far below the step means every step, at once", "[events]") {
  // Counted one by one, the periods of a step would take years.
  const double period = GENERATE(1e-300, 1e-18, 1e-14, 1e-9);
  Yard yard;
  yard.rule("tick", {MoveDoor{"door", true}}).every = period;
  yard.builder.model.rules.back().limit = 5;
  auto simulation = simulate(yard.builder.build(), "bullet");
  for (int i = 0; i < 4; ++i) simulation->step();
  CHECK(messages_of(*simulation).find("has fired 5 times") == std::string::npos);
  for (int i = 0; i < 4; ++i) simulation->step();
  CHECK(messages_of(*simulation).find("has fired 5 times") != std::string::npos);
}

TEST_CASE("copies of a template are added with clearance and removed after their lifetime",
          "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard(true);
  yard.builder.model.bodies[3].V_WB = {};
  Spawn spawn;
  spawn.of = "Ball";
  spawn.candidate_poses = {at(5, 5, 0), at(-3, -3, 0), at(-3, 3, 0)};  // the crate is at the first position
  spawn.clearance = 0.05;
  spawn.lifetime = 0.5;
  RuleModel& rule = yard.rule("scatter", {spawn});
  rule.every = 0.1;
  rule.limit = 3;
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  simulation->run_until(0.45);
  // Two fit, the third has no space while they exist.
  CHECK(diary.count("added") == 2);
  CHECK(diary.count("refused") == 1);
  CHECK(messages_of(*simulation).find("none of its 3 poses is free") != std::string::npos);
  CHECK(diary.events[0].source == "Ball_1");
  CHECK(diary.events[0].subject == "Ball");
  const int ball = find_body(*simulation->model(), "Ball_2.ball");
  REQUIRE(ball >= 0);
  // It stays on the floor: it was placed there, not ejected from it.
  CHECK(simulation->frame()->state.poses[ball].p.z() == Approx(0.1).margin(1e-3));
  simulation->run_until(1.0);
  CHECK(diary.count("removed") == 2);
  CHECK(diary.time_of("removed") == Approx(0.6).margin(2.1e-3));
  CHECK(find_assembly(*simulation->model(), "Ball_1") == -1);
}

TEST_CASE("a removed assembly holds no sensor models and no parameters", "[events]") {
  // A laser scanner with 20000 rays is added and removed. Its sensor model holds each ray and its
  // hit, its channels have names, and its last reading has 20000 values of 8 bytes: more than 160
  // kB each. Only its entries in the model and in frames remain: less than 16 kB, as names and
  // numbers are some 100 bytes each. (Under a sanitizer malloc keeps no such account, and all
  // figures are 0.)
  SensorModel scan;
  scan.name = "scan";
  scan.type = "lidar";
  scan.rate = 100.0;
  scan.parameters = {{"rays", std::int64_t{20000}}};
  Yard yard(true);
  SceneModel copy = *ball_fragment();
  scan.body = 0;
  copy.sensors = {scan};
  yard.builder.model.templates.push_back(
      {"Scanner", std::make_shared<const SceneModel>(std::move(copy)), {}});
  auto simulation = simulate(yard.builder.build(), "bullet");
  const auto come_and_go = [&](int number) {
    Spawn spawn;
    spawn.of = "Scanner";
    spawn.name = "scanner_" + std::to_string(number);
    spawn.pose = at(-5, -5, 0);
    simulation->send(spawn);
    simulation->run_until(simulation->time() + 0.02);
    REQUIRE(find_assembly(*simulation->model(), spawn.name) >= 0);
    simulation->send(Remove{spawn.name});
    simulation->run_until(simulation->time() + 0.02);
    REQUIRE(find_assembly(*simulation->model(), spawn.name) == -1);
  };
  const auto held = [] {
    const struct mallinfo2 info = ::mallinfo2();
    return static_cast<double>(info.uordblks + info.hblkhd);
  };
  come_and_go(0);
  const double before = held();
  constexpr int kGuests = 8;
  for (int i = 1; i <= kGuests; ++i) come_and_go(i);
  CHECK(held() - before < kGuests * 16e3);
  for (const SensorModel& sensor : simulation->model()->sensors) {
    CHECK(sensor.removed);
    CHECK(sensor.parameters.empty());
  }
}

TEST_CASE("a spawn into something is refused", "[events]") {
  Yard yard;
  auto simulation = simulate(yard.builder.build(), "bullet");
  const auto try_at = [&](const Pose& pose, double clearance) {
    const auto said = run_messages(*simulation).size();
    Spawn spawn;
    spawn.of = "Ball";
    spawn.pose = pose;
    spawn.clearance = clearance;
    simulation->send(spawn);
    simulation->step();
    return run_messages(*simulation).size() == said;
  };
  // The crate extends from x = 4.9 to 5.1; the ball's radius is 0.1.
  CHECK_FALSE(try_at(at(5.19, 5, 0), 0.0));
  CHECK(try_at(at(5.21, 5, 0), 0.0));
  CHECK_FALSE(try_at(at(4.76, 5, 0), 0.05));
  CHECK(try_at(at(4.74, 5, 0), 0.05));
  // The floor may touch it and carry it, but it may not lie below the floor.
  CHECK_FALSE(try_at(at(8, 8, -0.01), 0.0));
  CHECK(try_at(at(8, 8, 0), 1.0));
}

TEST_CASE("bodies and assemblies are removed by name", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  yard.rule("away", {Remove{"ball"}}).time = 1.0;
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  simulation->run_until(1.5);
  CHECK(diary.time_of("removed") == Approx(1.0).margin(1e-9));
  // It was in the region, and has left it.
  CHECK(diary.time_of("leave") == Approx(1.001).margin(1e-9));
  CHECK(find_body(*simulation->model(), "ball") == -1);
  CHECK(messages_of(*simulation).empty());
}

TEST_CASE("conditions fire when they become true and filter events", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  yard.rule("halfway", {Raise{"half", ""}}).when = "ball.y gt 0.5 m";
  RuleModel& filtered = yard.rule("tick", {Raise{"tick", ""}});
  filtered.every = 0.1;
  filtered.when = "ball.y lt 0.35 m";
  RuleModel& late = yard.on("late", "raised", "half", {Raise{"late", "said"}});
  late.after = 0.25;
  RuleModel& start = yard.rule("start", {Raise{"start", ""}});
  start.time = 0.0;
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  simulation->run_until(1.0);
  // Detected in the frame after it becomes true, 1 ms; carried out at that boundary.
  CHECK(diary.time_of("raised", "half") == Approx(0.5).margin(2.1e-3));
  CHECK(diary.time_of("raised", "late") ==
        Approx(diary.time_of("raised", "half") + 0.251).margin(1.1e-3));
  CHECK(diary.time_of("raised", "start") == 0.0);
  CHECK(diary.count("raised") == 3 + 3);  // ticks at 0.1, 0.2 and 0.3
}

TEST_CASE("rules that set each other off are stopped and named", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  yard.on("first", "raised", "a", {Raise{"b", ""}});
  yard.on("second", "raised", "b", {Raise{"a", ""}, Raise{"a", ""}});
  yard.rule("begin", {Raise{"a", ""}}).time = 0.1;
  for (RuleModel& rule : yard.builder.model.rules) rule.limit = 100000000;
  auto simulation = simulate(yard.builder.build(), backend);
  std::size_t most = 0;
  simulation->observe({}, [&](const FramePtr& f) { most = std::max(most, f->events.size()); });
  CHECK(simulation->run_until(1.0) == RunStatus::completed);
  const std::string said = messages_of(*simulation);
  CHECK(said.find("rule 'first' triggers itself repeatedly: 'first' -> 'second' -> 'first'") !=
        std::string::npos);
  CHECK(most <= 1000);
  CHECK(run_messages(*simulation).size() < 5);
}

TEST_CASE("a cycle of rules through the world is ended by the limit", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  yard.on("shut", "opened", "door", {MoveDoor{"door", false}}).limit = 2;
  yard.on("unshut", "closed", "door", {MoveDoor{"door", true}}).limit = 2;
  yard.rule("begin", {MoveDoor{"door", true}}).time = 0.0;
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  simulation->run_until(8.0);
  CHECK(diary.count("opened") == 3);
  CHECK(diary.count("closed") == 2);
  CHECK(messages_of(*simulation).find("rule 'shut' has fired 2 times") != std::string::npos);
  CHECK(run_messages(*simulation).size() == 1);
}

TEST_CASE("a rule may end the run, and the events of that step are reported", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  yard.on("done", "enter", "goal", {Raise{"success", ""}, EndRun{"in the goal"}});
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  CHECK(simulation->run_until(3.0) == RunStatus::stopped);
  CHECK(simulation->time() < 0.81);
  CHECK(diary.count("raised") == 1);
  CHECK(diary.count("ended") == 1);
}

namespace {

/// Every kind of stored event state: delays, periods, lifetimes, draws, doors, regions.
SceneModelPtr busy_scene() {
  Yard yard(true);
  yard.builder.model.bodies[3].V_WB.linear = Vec3(0, 1, 5);
  Spawn spawn;
  spawn.of = "Ball";
  for (int i = 0; i < 20; ++i) spawn.candidate_poses.push_back(at(-4 + 0.5 * i, -3, 0.05 * i));
  spawn.lifetime = 0.37;
  spawn.clearance = 0.02;
  yard.rule("scatter", {spawn}).every = 0.05;
  RuleModel& late = yard.on("late", "added", "", {MoveDoor{"door", true}});
  late.after = 0.3;
  late.limit = 1;
  yard.on("shut", "opened", "door", {MoveDoor{"door", false}});
  return yard.builder.build();
}

}  // namespace

TEST_CASE("events are the same however a run is divided", "[events]") {
  const std::string backend = GENERATE(engines());
  const SceneModelPtr scene = busy_scene();
  const auto whole = simulate(scene, backend);
  Diary expected(*whole);
  whole->run_until(2.0);
  const std::uint64_t hash = state_hash(whole->frame()->state);
  REQUIRE(expected.count("added") > 20);
  REQUIRE(expected.count("removed") > 20);
  REQUIRE(expected.count("opened") == 1);

  SECTION("twice") {
    const auto again = simulate(scene, backend);
    again->run_until(2.0);
    CHECK(state_hash(again->frame()->state) == hash);
  }
  SECTION("in pieces") {
    const auto pieces = simulate(scene, backend);
    for (double t = 0.013; t < 2.0; t += 0.119) pieces->run_until(t);
    pieces->run_until(2.0);
    CHECK(state_hash(pieces->frame()->state) == hash);
  }
  SECTION("from a snapshot") {
    const auto again = simulate(scene, backend);
    again->run_until(0.711);
    const SimulationSnapshotPtr saved = again->save();
    again->run_until(1.3);
    REQUIRE(again->restore(saved));
    again->run_until(2.0);
    CHECK(state_hash(again->frame()->state) == hash);
  }
  SECTION("after a restart") {
    const auto again = simulate(scene, backend);
    Diary diary(*again);
    again->run_until(1.1);
    again->send(Restart{});
    again->step();
    again->run_until(2.0);
    CHECK(state_hash(again->frame()->state) == hash);
  }
  SECTION("another seed draws other positions") {
    SimulationOptions options;
    options.seed = 77;
    const auto other = simulate(scene, backend, options);
    other->run_until(2.0);
    CHECK(state_hash(other->frame()->state) != hash);
  }
}

namespace {

SceneModelPtr flooded(int count) {
  Yard yard;
  ControllerModel flood;
  flood.name = "flood";
  flood.plugin = "flood";
  flood.parameters["count"] = std::int64_t{count};
  yard.builder.model.supervisors.push_back(flood);
  return yard.builder.build();
}

}  // namespace

TEST_CASE("a million spawns are refused at a limit and the run continues", "[events]") {
  const std::string backend = GENERATE(engines());
  auto simulation = simulate(flooded(1000000), backend);
  Diary diary(*simulation);
  CHECK(simulation->run_until(4e-3) == RunStatus::completed);
  // A hundred are added per step; the first exist from the second step on.
  CHECK(diary.count("added") == 300);
  CHECK(diary.count("refused") == 2);
  const std::string said = messages_of(*simulation);
  CHECK(said.find("sent more than 10000 commands in one step") != std::string::npos);
  CHECK(said.find("100 assemblies were already added in this step") != std::string::npos);
  CHECK(run_messages(*simulation).size() == 2);
  CHECK(simulation->model()->supervisors[0].outputs[0].name == "sent");
  CHECK(simulation->frame()->supervisor_outputs[0][0] == 4e6);
}

TEST_CASE("the number of bodies added during a run is limited", "[events]") {
  auto simulation = simulate(flooded(100), "cogrsim");
  Diary diary(*simulation);
  CHECK(simulation->run_until(0.024) == RunStatus::completed);
  CHECK(diary.count("added") == 2000);
  CHECK(diary.count("refused") == 1);
  CHECK(messages_of(*simulation)
            .find("2000 bodies that were added during the run exist, at most 2000 are allowed") !=
        std::string::npos);
}

TEST_CASE("commands of a supervisor are part of a snapshot", "[events]") {
  const std::string backend = GENERATE(engines());
  auto whole = simulate(flooded(2), backend);
  whole->run_until(0.03);
  auto cut = simulate(flooded(2), backend);
  cut->run_until(0.011);
  const SimulationSnapshotPtr saved = cut->save();
  cut->run_until(0.019);
  REQUIRE(cut->restore(saved));
  cut->run_until(0.03);
  CHECK(find_assembly(*cut->model(), "Ball_58") >= 0);
  CHECK(state_hash(cut->frame()->state) == state_hash(whole->frame()->state));
}

TEST_CASE("a supervisor sees every event regardless of other observers", "[events]") {
  const std::string backend = GENERATE(engines());
  // Rarely, so that most events fall between two of its updates.
  const double rate = GENERATE(0.0, 10.0);
  const auto seen = [&](bool watched) {
    Yard yard;
    ControllerModel counter;
    counter.name = "counter";
    counter.plugin = "probe_supervisor";
    counter.parameters["height"] = -9.0;
    counter.rate = rate;
    yard.builder.model.supervisors.push_back(counter);
    auto simulation = simulate(yard.builder.build(), backend);
    std::size_t events_seen = 0;
    if (watched) {
      simulation->observe({}, [&](const FramePtr& frame) { events_seen += frame->events.size(); });
    }
    simulation->send(MoveDoor{"door", true});
    simulation->run_until(2.2);
    if (watched) CHECK(events_seen == 4);  // opening, opened, enter, leave
    return simulation->frame()->supervisor_outputs[0][0];
  };
  CHECK(seen(false) == 4.0);
  CHECK(seen(true) == 4.0);
}

TEST_CASE("a door that was driven elsewhere still obeys", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  simulation->send(SetMotor{"drive", 0.5});
  simulation->run_until(1.5);
  simulation->send(MoveDoor{"door", false});
  simulation->run_until(3.0);
  CHECK(diary.count("closing") == 1);
  CHECK(diary.count("closed") == 1);
}

TEST_CASE("a removed body is detached from the body it was attached to", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  Attach hold;
  hold.name = "hold";
  hold.parent = "crate";
  hold.child = "ball";
  simulation->send(hold);
  simulation->run_until(0.1);
  simulation->send(Remove{"crate"});
  simulation->run_until(0.2);
  CHECK(diary.count("attached") == 1);
  CHECK(diary.count("detached") == 1);
}

TEST_CASE("the reach of an attachment is between surfaces", "[events]") {
  TriangleMesh corner;
  corner.name = "corner";
  corner.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  corner.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const Quat lying = z_to(Vec3(1, 0, 0));
  const Quat turned(Eigen::AngleAxisd(0.25 * 3.14159265358979323846, Vec3::UnitZ()));
  const struct {
    const char* what;
    std::function<void(ModelBuilder&)> make;
    double distance;  // [m], by hand
  } cases[] = {
      {"corner of a box, ball",
       [](ModelBuilder& b) {
         b.box("a", Vec3(0.2, 0.2, 0.2), 1, at(0, 0, 0));
         b.sphere("b", 0.1, 1, at(0.4, 0.4, 0.4));
       },
       0.3 * std::sqrt(3.0) - 0.1},
      {"two balls",
       [](ModelBuilder& b) {
         b.sphere("a", 0.2, 1, at(0, 0, 0));
         b.sphere("b", 0.1, 1, at(0.6, 0, 0.8));
       },
       0.7},
      {"crossing capsules",
       [&](ModelBuilder& b) {
         b.capsule("a", 0.1, 1, 1, at(0, 0, 0));
         b.capsule("b", 0.1, 1, 1, Pose(Vec3(0, 0.5, 0), lying));
       },
       0.3},
      {"cylinder, edge of a box",
       [&](ModelBuilder& b) {
         b.cylinder("a", 0.2, 0.4, 1, at(0, 0, 0));
         b.box("b", Vec3(0.2, 0.2, 0.2), 1, Pose(Vec3(1, 0, 0), turned));
       },
       0.8 - 0.1 * std::sqrt(2.0)},
      {"crossing cylinders",
       [&](ModelBuilder& b) {
         b.cylinder("a", 0.2, 1, 1, at(0, 0, 0));
         b.cylinder("b", 0.2, 1, 1, Pose(Vec3(0, 1, 0), lying));
       },
       0.6},
      {"floor, lying capsule",
       [&](ModelBuilder& b) {
         b.plane("a");
         b.capsule("b", 0.2, 1, 1, Pose(Vec3(0, 0, 1), lying));
       },
       0.8},
      {"face of a hull, ball",
       [&](ModelBuilder& b) {
         b.mesh("a", corner, true, 1, at(0, 0, 0));
         b.sphere("b", 0.1, 1, at(1, 1, 1));
       },
       2.0 / std::sqrt(3.0) - 0.1},
      {"face of a mesh, ball",
       [&](ModelBuilder& b) {
         b.mesh("a", corner, false, 0, at(0, 0, 0));
         b.sphere("b", 0.1, 1, at(1, 1, 1));
       },
       2.0 / std::sqrt(3.0) - 0.1},
  };
  for (const auto& one : cases) {
    INFO(one.what);
    // Distances are good to 1e-9 m.
    for (const double more : {-1e-8, 1e-8}) {
      ModelBuilder builder("pair");
      builder.model.physics.gravity = Vec3::Zero();
      one.make(builder);
      auto simulation = simulate(builder.build(), "bullet");
      Attach attach;
      attach.name = "grip";
      attach.parent = "a";
      attach.child = "b";
      attach.reach = one.distance + more;
      simulation->send(attach);
      simulation->step();
      INFO("reach " << attach.reach << ": " << messages_of(*simulation));
      CHECK((find_joint(*simulation->model(), "grip") >= 0) == (more > 0));
    }
  }
}

TEST_CASE("bodies are attached at their poses and detached again", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard(true);
  yard.builder.model.bodies[3].V_WB = {};
  yard.builder.model.bodies[3].X_WB = at(5, 5, 0.31);  // 1 cm above the crate
  auto simulation = simulate(yard.builder.build(), backend);
  Diary diary(*simulation);
  simulation->send(SetStatic{"crate", true});
  Attach attach;
  attach.name = "grip";
  attach.parent = "crate";
  attach.child = "ball";
  attach.reach = 0.005;
  simulation->send(attach);
  simulation->step();
  // The surfaces are 1 cm apart, the reach is half of that.
  CHECK(messages_of(*simulation).find("the reach is") != std::string::npos);
  attach.reach = 0.02;
  simulation->send(attach);
  simulation->run_until(0.5);
  const auto height = [&] { return simulation->frame()->state.poses[3].p.z(); };
  CHECK(height() == Approx(0.31).margin(1e-3));  // fell for a step, 1e-5 m, and was then held
  CHECK(diary.time_of("attached", "grip") == Approx(1e-3));
  CHECK(diary.count("made-static") == 1);
  simulation->send(Detach{"grip"});
  simulation->run_until(1.0);
  CHECK(diary.count("detached") == 1);
  CHECK(height() < 0.305);  // lies on the crate or beside it
  simulation->send(SetStatic{"crate", false});
  simulation->run_until(1.1);
  CHECK(diary.count("made-dynamic") == 1);
}

TEST_CASE("limits change during a run", "[events]") {
  const std::string backend = GENERATE(engines());
  Yard yard;
  auto simulation = simulate(yard.builder.build(), backend);
  simulation->send(SetJointLimits{"slide", 0, std::nullopt, 0.3});
  simulation->send(MoveDoor{"door", true});
  simulation->run_until(3.0);
  CHECK(simulation->frame()->state.joint_positions[0] == Approx(0.3).margin(0.01));
}
