// Changes of a running world. The conformance suite tests them with touching bodies, which this
// backend does not support yet.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#include <catch2/catch.hpp>
#endif
#include <cmath>
#include <limits>
#include <memory>

#include <cogrsim/model/builder.h>
#include <cogrsim/physics/frame.h>

#include "world.h"

using adapter::FlightWorld;
using cogrsim::Pose;
using cogrsim::Quat;
using cogrsim::Vec3;

namespace {

// Two tumbling boxes whose centres of mass are not their origins.
cogrsim::ModelBuilder thrown() {
  cogrsim::ModelBuilder builder;
  for (const double y : {0.0, 2.0}) {
    const int box = builder.box(y == 0.0 ? "near" : "far", Vec3(0.1, 0.4, 0.9), 2.0,
                                Pose(Vec3(0, y, 1), Quat(1, 0, 0, 0)));
    cogrsim::Body& body = builder.model.bodies[static_cast<std::size_t>(box)];
    body.com = Vec3(0.1, 0.05, -0.2);
    body.V_WB = {Vec3(1, 0, 4), Vec3(0.1, 5, 0.1)};
  }
  return builder;
}

void run(FlightWorld& world, int steps) {
  for (int i = 0; i < steps; ++i) {
    REQUIRE(world.step(1e-3, {}).status == cogrsim::StepStatus::ok);
  }
}

cogrsim::WorldState state_of(const FlightWorld& world) {
  cogrsim::WorldState state;
  world.get_state(state);
  return state;
}

std::uint64_t hash_of(const FlightWorld& world) { return cogrsim::state_hash(state_of(world)); }

}  // namespace

TEST_CASE("a run after a restore is bit-identical to that after the save") {
  const auto model = thrown().build();
  FlightWorld world(model, 1), other(model, 1);
  run(world, 100);
  const cogrsim::SnapshotPtr saved = world.save();
  run(world, 100);
  const std::uint64_t expected = hash_of(world);
  REQUIRE(world.restore(saved));
  run(world, 100);
  CHECK(hash_of(world) == expected);
  REQUIRE(other.restore(saved));
  run(other, 100);
  CHECK(hash_of(other) == expected);
  CHECK(other.time() == world.time());
}

TEST_CASE("a reset world equals a new one") {
  const auto model = thrown().build();
  FlightWorld fresh(model, 2), used(model, 2);
  run(used, 50);
  REQUIRE(used.reset());
  CHECK(used.time() == 0.0);
  run(fresh, 50);
  run(used, 50);
  CHECK(hash_of(used) == hash_of(fresh));
}

TEST_CASE("adding and removing bodies does not affect the other bodies") {
  const auto model = thrown().build();
  FlightWorld world(model, 1), undisturbed(model, 1);
  run(world, 50);
  auto more = std::make_shared<cogrsim::SceneModel>(*model);
  more->bodies.push_back(more->bodies[0]);
  more->bodies.back().name = "new";
  REQUIRE(world.add(more));
  run(world, 50);
  CHECK(state_of(world).poses.size() == 3);
  auto fewer = std::make_shared<cogrsim::SceneModel>(*more);
  fewer->bodies[2].removed = true;
  REQUIRE(world.remove(fewer));
  const Pose last = state_of(world).poses[2];
  run(world, 50);
  run(undisturbed, 150);
  const auto found = state_of(world), expected = state_of(undisturbed);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(found.poses[i].p == expected.poses[i].p);
    CHECK(found.twists[i].angular == expected.twists[i].angular);
  }
  CHECK(found.poses[2].p == last.p);  // its last values remain
  // Joints are rejected without changing anything.
  auto jointed = std::make_shared<cogrsim::SceneModel>(*fewer);
  jointed->joints.emplace_back();
  CHECK_FALSE(world.add(jointed));
  CHECK(world.model() == fewer);
}

TEST_CASE("get_state returns the state that was set") {
  const auto model = thrown().build();
  FlightWorld source(model, 1), target(model, 1);
  run(source, 100);
  run(target, 7);
  REQUIRE(target.set_state(state_of(source)));
  const auto found = state_of(target), expected = state_of(source);
  for (std::size_t i = 0; i < 2; ++i) {
    // Rounding of the conversion from the body origin to the centre of mass and back.
    CHECK((found.poses[i].p - expected.poses[i].p).norm() < 1e-13);
    CHECK((found.twists[i].linear - expected.twists[i].linear).norm() < 1e-12);
  }
  auto wrong = expected;
  wrong.poses.pop_back();
  CHECK_FALSE(target.set_state(wrong));
  wrong = expected;
  wrong.twists[1].linear.x() = std::numeric_limits<double>::quiet_NaN();
  const std::uint64_t before = hash_of(target);
  CHECK_FALSE(target.set_state(wrong));
  CHECK(hash_of(target) == before);
}

TEST_CASE("a body made static keeps its pose, and made dynamic it falls from rest") {
  const auto model = thrown().build();
  FlightWorld world(model, 1);
  run(world, 100);
  auto made_static = std::make_shared<cogrsim::SceneModel>(*model);
  made_static->bodies[0].kind = cogrsim::BodyKind::static_body;
  REQUIRE(world.change(made_static));
  const Pose there = state_of(world).poses[0];
  run(world, 100);
  // Here and below: rounding of the conversion to the centre of mass and back.
  CHECK((state_of(world).poses[0].p - there.p).norm() < 1e-14);
  REQUIRE(world.change(model));
  run(world, 100);
  const auto state = state_of(world);
  CHECK((state.poses[0].p - there.p - Vec3(0, 0, -0.5 * 9.81 * 0.01)).norm() < 1e-12);
  CHECK(state.twists[0].angular.norm() == 0.0);
}

TEST_CASE("a diverged body is named, and the time does not advance") {
  cogrsim::ModelBuilder builder = thrown();
  builder.model.bodies[1].V_WB.linear.x() = 1e300;
  FlightWorld world(builder.build(), 1);
  const auto result = world.step(1e-3, {});
  CHECK(result.status == cogrsim::StepStatus::diverged);
  CHECK(result.body == 1);
  CHECK_FALSE(result.message.empty());
  CHECK(world.time() == 0.0);
}
