// Hundreds of random changes, and the cost of a change.
#include <chrono>
#include <random>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "runtime_rig.h"

namespace conformance {
namespace {

// Bytes in use; 0 where the library does not report them.
double heap_in_use() {
#ifdef __GLIBC__
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
#else
  return 0.0;
#endif
}

// A floor on which bodies are added, removed, attached, detached, made static and made dynamic.
class Turmoil {
 public:
  explicit Turmoil(std::uint64_t seed) : random_(seed), sim_(start()) {
    for (std::size_t b = 1; b < sim_.model().bodies.size(); ++b)
      alive_.push_back(static_cast<int>(b));
  }

  Sim& sim() { return sim_; }

  void act() {
    switch (random_() % 6) {
      case 0:
        if (alive_.size() < 12) spawn();
        break;
      case 1:
        if (alive_.size() > 4) remove_body(alive_[random_() % alive_.size()]);
        break;
      case 2:
      case 3:
        if (joints_.size() < 8) join();
        break;
      case 4:
        if (!joints_.empty()) {
          const std::size_t k = random_() % joints_.size();
          detach(sim_, joints_[k]);
          joints_.erase(joints_.begin() + static_cast<std::ptrdiff_t>(k));
        }
        break;
      default: {
        const int body = alive_[random_() % alive_.size()];
        const BodyKind kind = sim_.model().bodies[body].kind;
        set_static(sim_, body, kind == BodyKind::dynamic);
        break;
      }
    }
  }

  // Finite, and no removed body touches anything, nor, after a step, do attached bodies touch each
  // other.
  void check(bool after_step) {
    const SceneModel& model = sim_.model();
    for (const Pose& X : sim_.state().poses) CHECK(X.p.allFinite());
    for (const Twist& V : sim_.state().twists) {
      CHECK(V.linear.allFinite());
      CHECK(V.angular.allFinite());
    }
    const CollisionFilter filter(model);
    for (const Contact& c : sim_.contacts()) {
      CHECK_FALSE(model.bodies[c.body_a].removed);
      CHECK_FALSE(model.bodies[c.body_b].removed);
      if (after_step) CHECK(filter.collide(c.body_a, c.body_b));
    }
  }

 private:
  static SceneModelPtr start() {
    ModelBuilder builder;
    builder.plane("floor");
    for (int i = 0; i < 6; ++i) {
      const Pose X = at(0.5 * (i % 3) - 0.5, 0.6 * (i / 3) - 0.3, 0.2);
      if (i % 2 == 0) {
        builder.box("box" + std::to_string(i), Vec3(0.2, 0.25, 0.3), 1.0, X);
      } else {
        builder.sphere("ball" + std::to_string(i), 0.12, 0.8, X);
      }
    }
    return builder.build();
  }

  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11) * 0x1p-53);
  }

  void spawn() {
    ModelBuilder next = next_of(sim_);
    const Pose X = at(uniform(-0.8, 0.8), uniform(-0.8, 0.8), uniform(0.5, 1.0));
    const std::string name = "new" + std::to_string(count_++);
    alive_.push_back(random_() % 2 == 0 ? next.box(name, Vec3(0.2, 0.2, 0.2), 1.0, X)
                                        : next.sphere(name, 0.1, 0.5, X));
    add(sim_, next.build());
  }

  void remove_body(int body) {
    auto next = std::make_shared<SceneModel>(*sim_.world().model());
    next->bodies[body].removed = true;
    for (Joint& joint : next->joints)
      joint.removed = joint.removed || joint.parent == body || joint.child == body;
    mark_loops(*next);
    remove(sim_, next);
    alive_.erase(std::find(alive_.begin(), alive_.end(), body));
    joints_.erase(std::remove_if(joints_.begin(), joints_.end(),
                                 [&](int j) { return sim_.model().joints[j].removed; }),
                  joints_.end());
  }

  void join() {
    const JointType types[] = {JointType::fixed, JointType::hinge, JointType::ball};
    const int child = alive_[random_() % alive_.size()];
    int parent = random_() % 8 == 0 ? kWorld : alive_[random_() % alive_.size()];
    if (parent == child) parent = kWorld;
    const Vec3 a = sim_.pose(child).p;
    const Vec3 b = parent == kWorld ? a : sim_.pose(parent).p;
    if ((a - b).norm() > 1.0) return;
    joints_.push_back(attach(sim_, "joint" + std::to_string(count_++), types[random_() % 3], parent,
                             child, {0.5 * (a + b), z_to(Vec3(uniform(-1, 1), 1, 0.3))}));
  }

  std::mt19937_64 random_;
  Sim sim_;
  std::vector<int> alive_, joints_;
  int count_ = 0;
};

TEST_CASE("500 changes at random", "[runtime]") {
  need("runtime.add");
  need("runtime.remove");
  need("runtime.attach");
  need("runtime.body_kind");
  Turmoil turmoil(20), again(20);
  Sim& sim = turmoil.sim();
  double half = 0.0;
  for (int i = 0; i < 500; ++i) {
    INFO("change " << i);
    turmoil.act();
    turmoil.check(false);
    sim.run(0.005);
    turmoil.check(true);
    again.act();
    again.sim().run(0.005);
    CHECK(again.sim().hash() == sim.hash());
    if (i % 37 == 0) {
      // Bit for bit, contacts' memory and all.
      const SnapshotPtr saved = sim.world().save();
      sim.run(0.02);
      const std::uint64_t gone_on = sim.hash();
      REQUIRE(sim.world().restore(saved));
      sim.forget_state();
      sim.run(0.02);
      CHECK(sim.hash() == gone_on);
      REQUIRE(sim.world().restore(saved));
      sim.forget_state();
    }
    if (i == 250) half = heap_in_use();
  }
  // Removed objects keep their entries in the model, in two worlds and tests' copies: some
  // kilobytes a body or joint. A leak of an engine's world would be 100 times that.
  measure("heap growth per change [kB]", (heap_in_use() - half) / 249e3, 16.0);
  REQUIRE(sim.world().reset());
  sim.adopt_model();
  sim.forget_state();
  Turmoil fresh(20);
  sim.run(0.2);
  fresh.sim().run(0.2);
  CHECK(sim.hash() == fresh.sim().hash());
}

TEST_CASE("a snapshot from before and between changes", "[runtime]") {
  need("runtime.add");
  need("runtime.attach");
  need("runtime.body_kind");
  Turmoil turmoil(7);
  Sim& sim = turmoil.sim();
  std::vector<SnapshotPtr> saved;
  std::vector<std::uint64_t> then;
  const auto goes_on = [&sim] {
    sim.forget_state();
    sim.run(0.03);
    return sim.hash();
  };
  const SceneModelPtr scene = sim.world().model();
  for (int i = 0; i < 40; ++i) {
    turmoil.act();
    sim.run(0.02);
    const SnapshotPtr now = sim.world().save();
    const std::uint64_t hash = goes_on();
    REQUIRE(sim.world().restore(now));
    sim.adopt_model();
    sim.forget_state();
    saved.push_back(now);
    then.push_back(hash);
  }
  Sim fresh(scene);
  for (std::size_t k = saved.size(); k-- > 0;) {
    INFO("snapshot " << k);
    REQUIRE(sim.world().restore(saved[k]));
    CHECK(goes_on() == then[k]);
    REQUIRE(fresh.world().restore(saved[k]));
    fresh.forget_state();
    fresh.run(0.03);
    CHECK(fresh.hash() == then[k]);
  }
}

TEST_CASE("1000 bodies come and go among 25", "[runtime]") {
  need("runtime.add");
  need("runtime.remove");
  ModelBuilder builder;
  builder.plane("floor");
  for (int i = 0; i < 25; ++i) {
    builder.box("box" + std::to_string(i), Vec3(0.2, 0.2, 0.2), 1.0,
                at(0.5 * (i % 5), 0.5 * (i / 5), 0.1));
  }
  Sim sim(builder);
  sim.run(0.05);
  using Clock = std::chrono::steady_clock;
  double adding = 0.0, removing = 0.0, last_adding = 0.0, last_removing = 0.0;
  const auto since = [](Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  };
  for (int i = 0; i < 1000; ++i) {
    ModelBuilder next = next_of(sim);
    const int ball =
        next.sphere("ball" + std::to_string(i), 0.1, 1.0, at(0.5 * (i % 5), 0.25, 0.11));
    const SceneModelPtr with = next.build();
    auto start = Clock::now();
    REQUIRE(sim.world().add(with));
    (i < 900 ? adding : last_adding) += since(start);
    sim.forget_state();
    sim.step();
    auto without = std::make_shared<SceneModel>(*with);
    without->bodies[ball].removed = true;
    start = Clock::now();
    REQUIRE(sim.world().remove(without));
    (i < 900 ? removing : last_removing) += since(start);
    sim.forget_state();
    sim.step();
  }
  // No claim: a shared machine's clock.
  observe("time to add a body [ms]", adding / 900);
  observe("time to remove a body [ms]", removing / 900);
  observe("time to add a body after 900 others [ms]", last_adding / 100);
  observe("time to remove a body after 900 others [ms]", last_removing / 100);
  sim.adopt_model();
  sim.forget_state();
  for (int b = 1; b <= 25; ++b) {
    measure("height error of what stayed [m]", std::abs(sim.pose(b).p.z() - 0.1), 1e-4);
  }
}

}  // namespace
}  // namespace conformance
