// What EngineWorld does for an engine that is one object per scene, on one that moves bodies along their twists
// and fails as it is told.
#include "cogrsim/physics/engine_world.h"

#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"

namespace cogrsim {
namespace {

using Catch::Matchers::Contains;

/// What the engine does in its next step, and what has become of engines.
struct Orders {
  enum class Step { moves, throws, refuses, runs_away, breaks } step = Step::moves;
  bool make_fails = false;
  int made = 0, undone = 0, taken_over = 0;
};
Orders orders;

class FakeEngine final : public SceneEngine {
 public:
  static constexpr const char *kName = "fake", *kTitle = "Fake";
  static constexpr bool kLacksCouplings = false;
  static const ParameterTable& options() {
    static const ParameterTable table = {parameter("pace", 1.0, "times as fast").range(0.0, 10.0)};
    return table;
  }
  static Result<std::unique_ptr<FakeEngine>> make(const SceneModelPtr& model,
                                                  const Parameters& options,
                                                  const WorldState& begin, const FakeEngine* old) {
    if (orders.make_fails) throw std::runtime_error("no room");
    ++orders.made;
    auto out = std::make_unique<FakeEngine>();
    out->scene_ = model;
    out->now_ = begin;
    out->pace_ = value_of<double>(options, "pace");
    out->follows_ = old != nullptr;
    return out;
  }
  void take_over(FakeEngine&, const WorldState&, const SceneChange&) {
    CHECK(follows_);
    ++orders.taken_over;
  }
  void step(const StepInput& input) {
    before_ = now_;
    for (std::size_t b = 0; b < now_.poses.size(); ++b)
      now_.poses[b] = moved(now_.poses[b], now_.twists[b], pace_ * input.dt);
    if (orders.step == Orders::Step::runs_away) now_.poses[0].p.x() = 1e9;
    if (orders.step == Orders::Step::throws) throw std::runtime_error("singular");
    if (orders.step == Orders::Step::breaks) throw std::runtime_error("broken");
    if (orders.step == Orders::Step::refuses) throw StepRefused("too much", 1);
  }
  int find_lost() const {
    for (std::size_t b = 0; b < now_.poses.size(); ++b)
      if (!kBounds.hold(now_.poses[b].p.squaredNorm(), 0.0, 0.0)) return static_cast<int>(b);
    return -1;
  }
  bool undo() {
    ++orders.undone;
    now_ = before_;
    return orders.step != Orders::Step::breaks;
  }
  Pose pose(int body) const { return now_.poses[static_cast<std::size_t>(body)]; }
  Twist twist(int body) const { return now_.twists[static_cast<std::size_t>(body)]; }
  void write(const WorldState& state) { now_ = state; }
  void read_efforts(std::vector<double>&, std::vector<double>&) const {}
  void read_contacts(std::vector<Contact>&) const {}
  void read_reactions(std::vector<Wrench>&) const {}
  std::shared_ptr<const HostedMemory> save() const {
    auto out = std::make_shared<Memory>();
    out->now = now_;
    return out;
  }
  void restore(const HostedMemory& memory) { now_ = static_cast<const Memory&>(memory).now; }

 private:
  struct Memory final : HostedMemory {
    WorldState now;
  };
  SceneModelPtr scene_;
  WorldState now_, before_;
  double pace_ = 1.0;
  bool follows_ = false;
};

SceneModelPtr scene(double pace = 1.0) {
  ModelBuilder builder("fakes");
  for (const char* name : {"one", "two"}) {
    const int body = builder.sphere(name, 0.1, 1.0, Pose());
    builder.model.bodies[body].V_WB.linear = Vec3(1, 0, 0);
  }
  builder.model.physics.engine_options["fake"]["pace"] = pace;
  return builder.build();
}

double x_of(const World& world) {
  WorldState state;
  world.get_state(state);
  return state.poses[0].p.x();
}

struct Fixture {
  Fixture() {
    orders = {};
    REQUIRE(world.start(scene()));
  }
  EngineWorld<FakeEngine> world;
};

}  // namespace

TEST_CASE_METHOD(Fixture, "an engine gets its options, and a wrong one is refused with its place",
                 "[engine-world]") {
  EngineWorld<FakeEngine> fast, wrong;
  REQUIRE(fast.start(scene(2.0)));
  fast.step(0.5, {});
  CHECK(x_of(fast) == 1.0);
  const auto refused = wrong.start(scene(11.0));
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.error().message, Contains("pace"));
}

TEST_CASE_METHOD(Fixture, "a step that fails is undone, and says of which body and why",
                 "[engine-world]") {
  using Step = Orders::Step;
  REQUIRE(world.step(0.5, {}).status == StepStatus::ok);
  const auto [step, body, what, engines] = GENERATE(table<Step, int, std::string, int>(
      {{Step::runs_away, 0, "body 'one' left all bounds (1000 km, 100 km/s) in fake", 1},
       {Step::throws, -1, "Fake: singular", 1},
       {Step::refuses, 1, "Fake: too much", 1},
       {Step::breaks, -1, "Fake: broken", 2}}));
  orders.step = step;
  const StepResult result = world.step(0.5, {});
  CHECK(result.status == StepStatus::diverged);
  CHECK(result.body == body);
  CHECK(result.message == what);
  CHECK(orders.undone == 1);
  CHECK(orders.made == engines);
  CHECK(x_of(world) == 0.5);
  CHECK(world.time() == 0.5);
  orders.step = Step::moves;
  CHECK(world.step(0.5, {}).status == StepStatus::ok);
  CHECK(x_of(world) == 1.0);
}

TEST_CASE_METHOD(Fixture, "where not even another engine can be made the world waits for a reset",
                 "[engine-world]") {
  world.step(0.5, {});
  orders.step = Orders::Step::breaks;
  orders.make_fails = true;
  CHECK(world.step(0.5, {}).status == StepStatus::diverged);
  orders.step = Orders::Step::moves;
  CHECK_THAT(world.step(0.5, {}).message, Contains("reset or restore"));
  CHECK(world.warnings().empty());
  WorldState state;
  world.get_state(state);
  CHECK_FALSE(world.set_state(state));
  orders.make_fails = false;
  REQUIRE(world.reset());
  CHECK(world.step(0.5, {}).status == StepStatus::ok);
  CHECK(x_of(world) == 0.5);
}

TEST_CASE_METHOD(Fixture, "a change makes another engine, and one that fails changes nothing",
                 "[engine-world]") {
  world.step(0.5, {});
  auto next = std::make_shared<SceneModel>(*world.model());
  next->bodies[1].removed = true;
  orders.make_fails = true;
  const auto refused = world.remove(next);
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.error().message, Contains("Fake: no room"));
  CHECK_FALSE(world.model()->bodies[1].removed);
  orders.make_fails = false;
  REQUIRE(world.remove(next));
  CHECK(orders.made == 2);
  CHECK(orders.taken_over == 1);
  CHECK(x_of(world) == 0.5);
}

TEST_CASE_METHOD(Fixture, "restoring needs another engine only for another scene",
                 "[engine-world]") {
  world.step(0.5, {});
  const SnapshotPtr saved = world.save();
  world.step(0.5, {});
  REQUIRE(world.restore(saved));
  CHECK(x_of(world) == 0.5);
  CHECK(orders.made == 1);
  auto next = std::make_shared<SceneModel>(*world.model());
  next->bodies[1].removed = true;
  REQUIRE(world.remove(next));
  REQUIRE(world.restore(saved));
  CHECK(orders.made == 3);
  CHECK_FALSE(world.model()->bodies[1].removed);
  CHECK(x_of(world) == 0.5);
}

}  // namespace cogrsim
