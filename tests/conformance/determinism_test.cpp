// The same again, bit for bit: two runs, pieces of runs, save and restore, reset.
#include "scenes.h"

namespace conformance {
namespace {

constexpr double kSeconds = 1.0;

// Hash of every step's state from now on, chained.
std::uint64_t trace(Sim& sim, double seconds) {
  std::uint64_t chained = 1469598103934665603ULL;
  sim.run(seconds, kDt, [&] { chained = (chained ^ sim.hash()) * 1099511628211ULL; });
  return chained;
}

struct Scene {
  SceneModelPtr model;
  std::vector<Drive> drives;
};

Scene scene() {
  Playground place = playground();
  return {place.builder.build(), place.drives};
}

Sim start(const Scene& made) {
  Sim sim(made.model);
  sim.drives = made.drives;
  return sim;
}

TEST_CASE("two runs are the same", "[determinism]") {
  const Scene made = scene();
  Sim one = start(made), two = start(made);
  CHECK(one.hash() == two.hash());
  CHECK(trace(one, kSeconds) == trace(two, kSeconds));
}

TEST_CASE("two models made alike run the same", "[determinism]") {
  Sim one = start(scene()), two = start(scene());
  CHECK(trace(one, kSeconds) == trace(two, kSeconds));
}

TEST_CASE("worlds side by side do not disturb each other", "[determinism]") {
  const Scene made = scene();
  Sim alone = start(made), one = start(made), two = start(made);
  const std::uint64_t expected = trace(alone, 0.5);
  std::uint64_t chained = 1469598103934665603ULL;
  for (int i = 0; i < 500; ++i) {
    one.step();
    two.step(2.0 * kDt);
    chained = (chained ^ one.hash()) * 1099511628211ULL;
  }
  CHECK(chained == expected);
}

TEST_CASE("a run chopped into pieces is the same", "[determinism]") {
  const Scene made = scene();
  Sim whole = start(made), pieces = start(made);
  whole.run(kSeconds);
  // Reading everything between the pieces must have no effect either.
  int steps = 0;
  for (const int piece : {1, 99, 250, 3, 647}) {
    for (int i = 0; i < piece; ++i) pieces.step();
    steps += piece;
    (void)pieces.hash();
    (void)pieces.contacts();
    (void)pieces.world().save();
  }
  REQUIRE(steps == 1000);
  CHECK(pieces.hash() == whole.hash());
}

TEST_CASE("a run resumes from a restore as it did from the save", "[determinism]") {
  need("runtime.save");
  const double when = GENERATE(0.0, 0.3, 0.7);
  Sim sim = start(scene());
  sim.run(when);
  const SnapshotPtr saved = sim.world().save();
  REQUIRE(saved);
  const double time = sim.world().time();
  const std::uint64_t at_save = sim.hash();
  const std::uint64_t first = trace(sim, kSeconds);
  REQUIRE(sim.world().restore(saved));
  sim.forget_state();
  CHECK(sim.world().time() == time);
  CHECK(sim.hash() == at_save);
  CHECK(trace(sim, kSeconds) == first);
  // And again: restoring does not use the snapshot up.
  REQUIRE(sim.world().restore(saved));
  sim.forget_state();
  CHECK(trace(sim, kSeconds) == first);
}

TEST_CASE("a fresh world resumes from another's save", "[determinism]") {
  need("runtime.save");
  const Scene made = scene();
  Sim sim = start(made);
  sim.run(0.5);
  const SnapshotPtr saved = sim.world().save();
  const std::uint64_t expected = trace(sim, kSeconds);
  Sim fresh = start(made);
  fresh.run(0.1);
  REQUIRE(fresh.world().restore(saved));
  fresh.forget_state();
  CHECK(trace(fresh, kSeconds) == expected);
}

TEST_CASE("efforts and contacts come back with a restore", "[determinism]") {
  need("runtime.save");
  Sim sim = start(scene());
  sim.run(0.6);
  const std::vector<double> efforts = sim.state().joint_efforts;
  const std::size_t contacts = sim.contacts().size();
  const SnapshotPtr saved = sim.world().save();
  sim.run(0.3);
  REQUIRE(sim.world().restore(saved));
  sim.forget_state();
  CHECK(sim.state().joint_efforts == efforts);
  CHECK(sim.contacts().size() == contacts);
}

TEST_CASE("a reset world equals a fresh one", "[determinism]") {
  const Scene made = scene();
  Sim fresh = start(made), used = start(made);
  const std::uint64_t at_start = fresh.hash();
  used.run(0.7);
  REQUIRE(used.world().reset());
  used.forget_state();
  CHECK(used.world().time() == 0.0);
  CHECK(used.hash() == at_start);
  CHECK(trace(used, kSeconds) == trace(fresh, kSeconds));
}

TEST_CASE("a snapshot of another scene is refused", "[determinism]") {
  need("runtime.save");
  Sim sim = start(scene());
  ModelBuilder other;
  other.sphere("ball", 0.1, 1.0, at(0, 0, 1));
  Sim stranger(other);
  const SnapshotPtr saved = stranger.world().save();
  const std::uint64_t before = sim.hash();
  const auto result = sim.world().restore(saved);
  REQUIRE_FALSE(result);
  CHECK_FALSE(result.error().message.empty());
  sim.forget_state();
  CHECK(sim.hash() == before);
}

}  // namespace
}  // namespace conformance
