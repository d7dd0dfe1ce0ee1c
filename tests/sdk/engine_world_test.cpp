// What EngineWorld does for an engine that is one object per scene, on one that moves bodies along their twists
// and fails where a test wants it to.
#include "cogrsim/physics/engine_world.h"

#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"

namespace cogrsim {
namespace {

using Catch::Matchers::Contains;

/// What the engine does in its next step, and what has become of engines.
struct Orders {
  enum class Step { moves, throws, refuses, runs_away, breaks } step = Step::moves;
  bool make_fails = false, restore_fails = false;
  int made = 0, undone = 0, taken_over = 0;
  std::vector<std::pair<int, double>> driven;  // bodies, and how fast along x
};
Orders orders;

/// One that holds no twists of kinematic bodies and restores only what was just made has `kFresh`.
template <bool kFresh>
class FakeEngineOf final : public SceneEngine {
 public:
  static constexpr bool kHoldsTwists = !kFresh, kRestoresInPlace = !kFresh;
  static constexpr const char *kName = "fake", *kTitle = "Fake";
  static constexpr bool kLacksCouplings = false;
  static const ParameterTable& options() {
    static const ParameterTable table = {parameter("pace", 1.0, "times as fast").range(0.0, 10.0)};
    return table;
  }
  static Result<std::unique_ptr<FakeEngineOf>> make(const SceneModelPtr& model,
                                                    const Parameters& options,
                                                    const WorldState& begin,
                                                    const FakeEngineOf* old) {
    if (orders.make_fails) throw std::runtime_error("no room");
    ++orders.made;
    auto out = std::make_unique<FakeEngineOf>();
    out->scene_ = model;
    out->now_ = begin;
    out->pace_ = value_of<double>(options, "pace");
    out->follows_ = old != nullptr;
    return out;
  }
  void take_over(FakeEngineOf&, const WorldState&, const SceneChange&) {
    CHECK(follows_);
    ++orders.taken_over;
  }
  void step(const StepInput& input) {
    used_ = true;
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
  Twist twist(int body) const {
    CHECK((kHoldsTwists ||
           scene_->bodies[static_cast<std::size_t>(body)].kind != BodyKind::kinematic));
    return now_.twists[static_cast<std::size_t>(body)];
  }
  void move_kinematic(int body, const Twist& twist) {
    orders.driven.emplace_back(body, twist.linear.x());
    now_.twists[static_cast<std::size_t>(body)] = twist;
  }
  void write(const WorldState& state) { now_ = state; }
  void read_efforts(std::vector<double>&, std::vector<double>&) const {}
  void read_contacts(std::vector<Contact>&) const {}
  void read_reactions(std::vector<Wrench>&) const {}
  std::shared_ptr<const HostedMemory> save() const {
    auto out = std::make_shared<Memory>();
    out->now = now_;
    return out;
  }
  void restore(const HostedMemory& memory) {
    if (orders.restore_fails) throw std::runtime_error("no memory of that");
    CHECK((kRestoresInPlace || !used_));
    now_ = static_cast<const Memory&>(memory).now;
  }

 private:
  struct Memory final : HostedMemory {
    WorldState now;
  };
  SceneModelPtr scene_;
  WorldState now_, before_;
  double pace_ = 1.0;
  bool follows_ = false, used_ = false;
};
using FakeEngine = FakeEngineOf<false>;
using FreshEngine = FakeEngineOf<true>;

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

TEST_CASE_METHOD(Fixture, "restoring anything needs another engine where one cannot be used again",
                 "[engine-world]") {
  EngineWorld<FreshEngine> fresh;
  REQUIRE(fresh.start(scene()));
  fresh.step(0.5, {});
  const SnapshotPtr saved = fresh.save();
  fresh.step(0.5, {});
  const int before = orders.made;
  REQUIRE(fresh.restore(saved));
  CHECK(orders.made == before + 1);
  CHECK(x_of(fresh) == 0.5);
}

TEST_CASE_METHOD(Fixture,
                 "a static body that stands elsewhere in the snapshot needs another engine",
                 "[engine-world]") {
  EngineWorld<FakeEngine> other;
  REQUIRE(other.start(world.model()));
  world.step(0.5, {});
  other.step(0.25, {});
  auto next = std::make_shared<SceneModel>(*world.model());
  next->bodies[0].kind = BodyKind::static_body;
  REQUIRE(world.change(next));
  REQUIRE(other.change(next));
  const SnapshotPtr saved = world.save();
  const int before = orders.made;
  REQUIRE(world.restore(saved));
  CHECK(orders.made == before);
  REQUIRE(other.restore(saved));
  CHECK(orders.made == before + 1);
  CHECK(x_of(other) == 0.5);
}

TEST_CASE_METHOD(Fixture, "a restore that fails half-way leaves no engine of another scene",
                 "[engine-world]") {
  world.step(0.5, {});
  const SnapshotPtr saved = world.save();
  auto next = std::make_shared<SceneModel>(*world.model());
  next->bodies[1].removed = true;
  REQUIRE(world.remove(next));
  world.step(0.25, {});
  orders.restore_fails = true;
  const auto refused = world.restore(saved);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().message == "Fake: no memory of that");
  CHECK(world.model() == next);
  CHECK(x_of(world) == 0.75);
  // In place: what is half restored cannot go on.
  REQUIRE_FALSE(world.restore(world.save()));
  CHECK_THAT(world.step(0.5, {}).message, Contains("reset or restore"));
  orders.restore_fails = false;
  REQUIRE(world.restore(saved));
  CHECK(x_of(world) == 0.5);
}

TEST_CASE_METHOD(Fixture, "an engine that takes nothing over from a broken one is no engine",
                 "[engine-world]") {
  world.step(0.5, {});
  orders.step = Orders::Step::breaks;
  orders.restore_fails = true;
  CHECK(world.step(0.5, {}).message == "Fake: broken");
  CHECK_THAT(world.step(0.5, {}).message, Contains("reset or restore"));
  std::vector<Contact> contacts;
  world.get_contacts(contacts);
  CHECK(contacts.empty());
  CHECK(x_of(world) == 0.0);
  // A snapshot of it has nothing to go on from.
  const SnapshotPtr empty = world.save();
  orders = {};
  CHECK_FALSE(world.restore(empty));
  REQUIRE(world.reset());
  CHECK_FALSE(world.restore(empty));
  CHECK(world.step(0.5, {}).status == StepStatus::ok);
}

TEMPLATE_TEST_CASE("twists that kinematic bodies are given reach the engine, and are read back",
                   "[engine-world]", FakeEngine, FreshEngine) {
  orders = {};
  SceneModel model = *scene();
  model.bodies[0].kind = BodyKind::kinematic;
  EngineWorld<TestType> world;
  REQUIRE(world.start(std::make_shared<const SceneModel>(model)));
  Twist twist;
  twist.linear.x() = 3.0;
  REQUIRE(world.set_kinematic_twist(0, twist));
  CHECK(orders.driven == std::vector<std::pair<int, double>>{{0, 3.0}});
  world.step(0.5, {});
  WorldState state;
  world.get_state(state);
  CHECK(state.twists[0].linear.x() == 3.0);
  CHECK(state.poses[0].p.x() == 1.5);
}

}  // namespace cogrsim
