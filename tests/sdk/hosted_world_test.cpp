// The rules that HostedWorld keeps for every engine, on an engine that does the least that it may: it moves
// bodies along their twists, and says what it was asked.
#include "cogrsim/physics/hosted_world.h"

#include <catch2/catch.hpp>

#include <limits>

#include "cogrsim/model/builder.h"

namespace cogrsim {
namespace {

using Catch::Matchers::Contains;

constexpr double kEffort = 7.0;  // [N m] of each joint, in each step

class FakeWorld final : public HostedWorld {
 public:
  explicit FakeWorld(const SceneModelPtr& model) { REQUIRE(start(model)); }

  int builds = 0;
  bool builds_fail = false;
  std::vector<std::pair<int, int>> touching = {{0, 1}};
  double spin_bound = std::numeric_limits<double>::infinity();

 private:
  struct Memory final : HostedMemory {
    WorldState now;
    bool stepped = false;
  };

  const char* engine_name() const override { return "fake"; }
  Result<> check(const SceneModel& model) const override {
    for (const Body& body : model.bodies)
      if (body.name == "unwanted") return fail("the fake takes no unwanted body");
    return {};
  }
  Result<> build(const SceneModelPtr& model, const WorldState& begin) override {
    if (builds_fail) return fail("the fake cannot build");
    ++builds;
    take(model, begin, false);
    return {};
  }
  StepResult advance(double dt, const std::vector<Drive>&, const std::vector<double>&) override {
    for (std::size_t b = 0; b < scene_->bodies.size(); ++b) {
      const Body& body = scene_->bodies[b];
      if (body.kind == BodyKind::kinematic) now_.twists[b] = twists()[b];
      if (!body.removed && now_.twists[b].linear.norm() > 1e3)
        return diverged(static_cast<int>(b), "1 km/s");
    }
    for (std::size_t b = 0; b < scene_->bodies.size(); ++b)
      now_.poses[b] = moved(now_.poses[b], now_.twists[b], dt);
    stepped_ = true;
    return {};
  }
  Pose pose(int body) const override { return now_.poses[static_cast<std::size_t>(body)]; }
  Twist twist(int body) const override {
    const auto b = static_cast<std::size_t>(body);
    return scene_->bodies[b].kind == BodyKind::kinematic ? twists()[b] : now_.twists[b];
  }
  Result<> write(const WorldState& state) override {
    take(scene_, state, false);
    return {};
  }
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const override {
    if (stepped_) std::fill(joints.begin(), joints.end(), kEffort);
    for (double& effort : motors) effort = kEffort;
  }
  void read_contacts(std::vector<Contact>& out) const override {
    for (const auto& [a, b] : touching)
      if (stepped_) out.push_back({a, b, a, b, Vec3::Zero(), Vec3(0, 0, 1), 0.0, Vec3(0, 0, 5)});
  }
  void read_reactions(std::vector<Wrench>&) const override {}
  double fastest_spin() const override { return spin_bound; }
  MemoryPtr save_memory() const override {
    auto out = std::make_shared<Memory>();
    out->now = now_;
    out->stepped = stepped_;
    return out;
  }
  Result<> restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                          const WorldState&) override {
    const auto& saved = static_cast<const Memory&>(*memory);
    take(model, saved.now, saved.stepped);
    return {};
  }

  void take(const SceneModelPtr& model, const WorldState& state, bool stepped) {
    scene_ = model;
    now_ = state;
    stepped_ = stepped;
  }

  SceneModelPtr scene_;
  WorldState now_;
  bool stepped_ = false;
};

/// A free ball, a ball on a hinge and a kinematic one.
SceneModelPtr scene() {
  ModelBuilder builder("fakes");
  const int free = builder.sphere("free", 0.1, 1.0, Pose());
  builder.model.bodies[free].V_WB.linear = Vec3(1, 0, 0);
  const int hung = builder.sphere("hung", 0.1, 1.0, Pose(Vec3(0, 0, 5), Quat::Identity()));
  builder.joint("pin", JointType::hinge, kWorld, hung, Pose(Vec3(0, 0, 5), Quat::Identity()));
  const int lift = builder.sphere("lift", 0.1, 1.0, Pose(Vec3(0, 9, 0), Quat::Identity()));
  builder.model.bodies[lift].kind = BodyKind::kinematic;
  return builder.build();
}

WorldState state_of(const World& world) {
  WorldState out;
  world.get_state(out);
  return out;
}

std::size_t contacts_of(const World& world) {
  std::vector<Contact> out;
  world.get_contacts(out);
  return out.size();
}

SceneModelPtr without_body(const SceneModelPtr& model, int body) {
  auto next = std::make_shared<SceneModel>(*model);
  next->bodies[body].removed = true;
  return next;
}

}  // namespace

TEST_CASE("a host keeps the last values of what is removed", "[hosted-world]") {
  FakeWorld world(scene());
  REQUIRE(world.step(0.5, {}).status == StepStatus::ok);
  CHECK(state_of(world).poses[0].p.x() == 0.5);
  REQUIRE(world.remove(without_body(world.model(), 0)));
  CHECK(world.builds == 2);
  world.step(0.5, {});
  CHECK(state_of(world).poses[0].p.x() == 0.5);
  CHECK(state_of(world).twists[0].linear.x() == 1.0);
  CHECK(world.time() == 1.0);
  REQUIRE(world.reset());
  CHECK_FALSE(world.model()->bodies[0].removed);
  CHECK(world.time() == 0.0);
  CHECK(state_of(world).poses[0].p.x() == 0.0);
}

TEST_CASE("a host holds reports until the engine has a step to report", "[hosted-world]") {
  FakeWorld world(scene());
  CHECK(contacts_of(world) == 0);
  world.step(0.1, {});
  CHECK(contacts_of(world) == 1);
  CHECK(state_of(world).joint_efforts.at(0) == kEffort);
  // A change of the scene keeps those of the last step, though the engine was built again.
  REQUIRE(world.remove(without_body(world.model(), 0)));
  CHECK(state_of(world).joint_efforts.at(0) == kEffort);
  // A state that was set has had no step.
  REQUIRE(world.set_state(state_of(world)));
  CHECK(contacts_of(world) == 0);
  CHECK(state_of(world).joint_efforts.at(0) == 0.0);
}

TEST_CASE("a host moves kinematic bodies by the twist that they were given", "[hosted-world]") {
  FakeWorld world(scene());
  auto& drive = static_cast<KinematicDrive&>(world);
  CHECK_FALSE(drive.set_kinematic_twist(0, {}));
  CHECK_FALSE(drive.set_kinematic_twist(3, {}));
  Twist up;
  up.linear = Vec3(0, 0, 2);
  world.step(0.1, {});
  REQUIRE(drive.set_kinematic_twist(2, up));
  CHECK(contacts_of(world) == 1);  // of the step before
  CHECK(state_of(world).twists[2].linear.z() == 2.0);
  world.step(0.5, {});
  CHECK(state_of(world).poses[2].p.z() == 1.0);
  up.linear.x() = std::numeric_limits<double>::infinity();
  CHECK_FALSE(drive.set_kinematic_twist(2, up));
}

TEST_CASE("a host orders the bodies of contacts, then the contacts", "[hosted-world]") {
  FakeWorld world(scene());
  world.touching = {{2, 1}, {1, 0}, {0, 2}};
  world.step(0.1, {});
  std::vector<Contact> found;
  world.get_contacts(found);
  REQUIRE(found.size() == 3);
  const std::vector<std::pair<int, int>> order = {{0, 1}, {0, 2}, {1, 2}};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(std::pair(found[i].body_a, found[i].body_b) == order[i]);
    CHECK(std::pair(found[i].shape_a, found[i].shape_b) == order[i]);
    // From a to b, and on b: turned round where the engine had the bodies the other way round.
    const double sign = i == 1 ? 1.0 : -1.0;
    CHECK(found[i].normal.z() == sign);
    CHECK(found[i].force.z() == 5.0 * sign);
  }
}

TEST_CASE("a host counts the turns of joints of which an engine has no coordinates",
          "[hosted-world]") {
  FakeWorld world(scene());
  WorldState turning = state_of(world);
  turning.joint_velocities[0] = 10.0;
  REQUIRE(world.set_state(turning));
  SnapshotPtr saved;
  // An engine that gives a bound is asked less often, and nobody asks for the state meanwhile.
  world.spin_bound = GENERATE(10.0, std::numeric_limits<double>::infinity());
  for (int i = 0; i < 70; ++i) {
    world.step(0.02, {});
    if (i == 49) saved = world.save();
  }
  CHECK(state_of(world).joint_positions[0] == Approx(14.0));
  CHECK(state_of(world).joint_velocities[0] == Approx(10.0));
  REQUIRE(world.restore(saved));
  CHECK(state_of(world).joint_positions[0] == Approx(10.0));
  world.step(0.02, {});
  CHECK(state_of(world).joint_positions[0] == Approx(10.2));
  auto grown = std::make_shared<SceneModel>(*world.model());
  grown->bodies.push_back(grown->bodies[0]);
  grown->bodies.back().name = "more";
  REQUIRE(world.add(grown));
  CHECK(state_of(world).joint_positions[0] == Approx(10.2));
}

TEST_CASE("after an error of a host nothing has changed", "[hosted-world]") {
  FakeWorld world(scene());
  world.step(0.1, {});
  const SceneModelPtr before = world.model();
  CHECK_FALSE(world.add(nullptr));
  auto unwanted = std::make_shared<SceneModel>(*before);
  unwanted->bodies.push_back(unwanted->bodies[0]);
  unwanted->bodies.back().name = "unwanted";
  CHECK(world.add(unwanted).error().message == "the fake takes no unwanted body");
  world.builds_fail = true;
  CHECK(world.remove(without_body(before, 0)).error().message == "the fake cannot build");
  CHECK(world.model() == before);
  CHECK(contacts_of(world) == 1);
  CHECK(world.time() == 0.1);
  WorldState wrong = state_of(world);
  wrong.poses[1].p.x() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(world.set_state(wrong).error().message, Contains("'hung'"));
}

TEST_CASE("a host names who diverged in which engine, and takes no time for it", "[hosted-world]") {
  FakeWorld world(scene());
  WorldState fast = state_of(world);
  fast.twists[0].linear = Vec3(2e3, 0, 0);
  REQUIRE(world.set_state(fast));
  const StepResult result = world.step(0.1, {});
  CHECK(result.status == StepStatus::diverged);
  CHECK(result.body == 0);
  CHECK(result.message == "body 'free' left all bounds (1 km/s) in fake");
  CHECK(world.time() == 0.0);
  CHECK(contacts_of(world) == 0);
}

TEST_CASE("a host restores what it saved, and no other scene's", "[hosted-world]") {
  FakeWorld world(scene());
  world.step(0.1, {});
  const SnapshotPtr saved = world.save();
  world.step(0.1, {});
  REQUIRE(world.remove(without_body(world.model(), 0)));
  REQUIRE(world.restore(saved));
  CHECK_FALSE(world.model()->bodies[0].removed);
  CHECK(world.time() == 0.1);
  CHECK(state_of(world).poses[0].p.x() == 0.1);
  CHECK(contacts_of(world) == 1);
  FakeWorld twin(scene());
  CHECK(twin.restore(saved));
  ModelBuilder builder("other");
  builder.sphere("ball", 0.1, 1.0, Pose());
  FakeWorld other(builder.build());
  CHECK_THAT(other.restore(saved).error().message, Contains("another scene"));
  CHECK_THAT(world.restore(nullptr).error().message, Contains("not made by the fake"));
}

}  // namespace cogrsim
