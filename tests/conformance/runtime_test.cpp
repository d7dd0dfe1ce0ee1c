// Changing a running world: adding, removing, setting its state.
#include "runtime_rig.h"
#include "scenes.h"

namespace conformance {
namespace {

struct Ongoing {
  ModelBuilder builder;
  int box = -1, rod = -1, hinge = -1;
};

// A box at rest on a floor and a pendulum that swings.
Ongoing ongoing() {
  Ongoing scene;
  ModelBuilder& builder = scene.builder;
  builder.plane("floor");
  scene.box = builder.box("box", Vec3(0.3, 0.3, 0.2), 1.0, at(0, 0, 0.1));
  scene.rod = builder.box("rod", Vec3(1.0, 0.05, 0.05), 1.0, at(2.5, 0, 2));
  scene.hinge = builder.joint("hinge", JointType::hinge, kWorld, scene.rod,
                              {Vec3(2, 0, 2), z_to(Vec3::UnitY())});
  return scene;
}

double largest_difference(const WorldState& a, const WorldState& b, std::size_t bodies) {
  double largest = 0.0;
  for (std::size_t i = 0; i < bodies; ++i) {
    largest = std::max({largest, (a.poses[i].p - b.poses[i].p).norm(),
                        angle_between(a.poses[i].q, b.poses[i].q),
                        (a.twists[i].linear - b.twists[i].linear).norm(),
                        (a.twists[i].angular - b.twists[i].angular).norm()});
  }
  return largest;
}

TEST_CASE("add: the rest continues, the new falls", "[runtime]") {
  need("runtime.add");
  Ongoing scene = ongoing();
  const SceneModelPtr model = scene.builder.build();
  Sim sim(model), undisturbed(model);
  sim.run(0.5);
  undisturbed.run(0.5);
  ModelBuilder next = next_of(sim);
  const int ball = next.sphere("ball", 0.1, 1.0, at(-3, 0, 10));
  next.model.bodies[ball].V_WB.linear = Vec3(1, 0, 0);
  const auto added = sim.world().add(next.build());
  INFO((added ? std::string() : added.error().text()));
  REQUIRE(added);
  sim.adopt_model();
  sim.forget_state();
  REQUIRE(sim.state().poses.size() == 4);
  CHECK(largest_difference(sim.state(), undisturbed.state(), 3) == 0.0);
  const double t = 0.5;
  sim.run(t);
  undisturbed.run(t);
  measure("new body's way error [m]",
          (sim.pose(ball).p - Vec3(-3 + t, 0, 10 - 0.5 * kGravity * t * t)).norm(),
          0.5 * kGravity * kDt * t * 1.001 + 1e-9);
  // The pendulum does not feel the addition, but an integrator that serves the whole world may now
  // take other steps: its accuracy counts. The box may detect its contacts again.
  measure("pendulum off the undisturbed one [rad]",
          std::abs(sim.q(scene.hinge) - undisturbed.q(scene.hinge)), 1e-5);
  measure("box off the undisturbed one [m]",
          (sim.pose(scene.box).p - undisturbed.pose(scene.box).p).norm(), 1e-4);
}

TEST_CASE("add: the new collides with the old", "[runtime]") {
  need("runtime.add");
  Ongoing scene = ongoing();
  Sim sim(scene.builder);
  sim.run(0.3);
  ModelBuilder next = next_of(sim);
  const int ball = next.sphere("ball", 0.1, 1.0, at(0, 0, 0.32));
  REQUIRE(sim.world().add(next.build()));
  sim.adopt_model();
  sim.forget_state();
  sim.run(1.0);
  measure("height error on the box [m]", std::abs(sim.pose(ball).p.z() - 0.3), 1e-3);
}

TEST_CASE("add: a robot with joints and motors", "[runtime]") {
  need("runtime.add");
  Ongoing scene = ongoing();
  Sim sim(scene.builder);
  sim.run(0.3);
  ModelBuilder next = next_of(sim);
  const TwoWheeler robot =
      add_two_wheeler(next, "robot", {Vec3(-2, 0, 0), turn(Vec3::UnitZ(), kPi)});
  REQUIRE(sim.world().add(next.build()));
  sim.adopt_model();
  sim.forget_state();
  sim.drives.assign(2, speed_source(6.0));
  sim.run(0.5);
  const double start = sim.pose(robot.chassis).p.x();
  sim.run(1.0);
  measure_relative("way", sim.pose(robot.chassis).p.x() - start, -6.0 * robot.radius, 0.01);
}

TEST_CASE("remove: the rest continues, the gap can be fallen through", "[runtime]") {
  need("runtime.remove");
  ModelBuilder builder;
  builder.plane("floor");
  const int table = builder.box("table", Vec3(1, 1, 0.2), 0.0, at(0, 0, 1.1));
  const int ball = builder.sphere("ball", 0.1, 1.0, at(0, 0, 1.3));
  const int rod = builder.box("rod", Vec3(1.0, 0.05, 0.05), 1.0, at(2.5, 0, 2));
  const int hinge =
      builder.joint("hinge", JointType::hinge, kWorld, rod, {Vec3(2, 0, 2), z_to(Vec3::UnitY())});
  const SceneModelPtr model = builder.build();
  Sim sim(model), undisturbed(model);
  sim.run(0.5);
  undisturbed.run(0.5);
  const double height = sim.pose(ball).p.z();
  SceneModel next = *sim.world().model();
  next.bodies[table].removed = true;
  const WorldState before = sim.state();
  REQUIRE(sim.world().remove(std::make_shared<const SceneModel>(next)));
  sim.adopt_model();
  sim.forget_state();
  CHECK(largest_difference(sim.state(), before, before.poses.size()) == 0.0);
  const double t = 0.4;
  sim.run(t);
  undisturbed.run(t);
  // It falls as if nothing had been there; what it rests on may have left it 1e-3 m/s.
  measure("fall error [m]", std::abs(sim.pose(ball).p.z() - height + 0.5 * kGravity * t * t),
          0.5 * kGravity * kDt * t * 1.001 + 1e-3 * t);
  measure("pendulum off the undisturbed one [rad]", std::abs(sim.q(hinge) - undisturbed.q(hinge)),
          1e-9);
  sim.run(1.0);
  measure("height error on the floor [m]", std::abs(sim.pose(ball).p.z() - 0.1), 1e-3);
}

TEST_CASE("remove: a joint lets go, a robot disappears", "[runtime]") {
  need("runtime.remove");
  Ongoing scene = ongoing();
  add_two_wheeler(scene.builder, "robot", at(-2, 0, 0));
  Sim sim(scene.builder);
  sim.drives.assign(2, speed_source(3.0));
  sim.run(0.2);
  SceneModel next = *sim.world().model();
  for (std::size_t i = 3; i < next.bodies.size(); ++i) next.bodies[i].removed = true;
  for (Joint& joint : next.joints) joint.removed = true;
  for (Motor& motor : next.motors) motor.removed = true;
  const Pose X = sim.pose(scene.rod);
  const Twist V = sim.twist(scene.rod);
  REQUIRE(sim.world().remove(std::make_shared<const SceneModel>(next)));
  sim.adopt_model();
  sim.forget_state();
  const double t = 0.3;
  sim.run(t);
  const Vec3 expected = X.p + V.linear * t + Vec3(0, 0, -0.5 * kGravity * t * t);
  measure("released body's way error [m]", (sim.pose(scene.rod).p - expected).norm(),
          0.5 * kGravity * kDt * t * 1.001 + 1e-6);
  for (const Contact& contact : sim.contacts()) {
    CHECK(contact.body_a < 3);
    CHECK(contact.body_b < 3);
  }
}

TEST_CASE("add and remove again and again", "[runtime]") {
  need("runtime.add");
  need("runtime.remove");
  Ongoing scene = ongoing();
  Sim sim(scene.builder);
  for (int round = 0; round < 10; ++round) {
    ModelBuilder next = next_of(sim);
    const int ball = next.sphere("ball" + std::to_string(round), 0.1, 1.0, at(0, 0, 0.35));
    REQUIRE(sim.world().add(next.build()));
    sim.adopt_model();
    sim.forget_state();
    sim.run(0.1);
    SceneModel without = *sim.world().model();
    without.bodies[ball].removed = true;
    REQUIRE(sim.world().remove(std::make_shared<const SceneModel>(without)));
    sim.adopt_model();
    sim.forget_state();
    sim.run(0.05);
  }
  measure("box's height error [m]", std::abs(sim.pose(scene.box).p.z() - 0.1), 1e-3);
}

TEST_CASE("reset takes back what was added and removed", "[runtime]") {
  need("runtime.add");
  need("runtime.remove");
  Ongoing scene = ongoing();
  const SceneModelPtr model = scene.builder.build();
  Sim sim(model), fresh(model);
  ModelBuilder next = next_of(sim);
  next.sphere("ball", 0.1, 1.0, at(-3, 0, 1));
  REQUIRE(sim.world().add(next.build()));
  sim.forget_state();
  sim.run(0.2);
  SceneModel without = *sim.world().model();
  without.bodies[scene.box].removed = true;
  REQUIRE(sim.world().remove(std::make_shared<const SceneModel>(without)));
  sim.forget_state();
  sim.run(0.2);
  REQUIRE(sim.world().reset());
  sim.adopt_model();
  sim.forget_state();
  sim.run(0.5);
  fresh.run(0.5);
  REQUIRE(sim.state().poses.size() == fresh.state().poses.size());
  CHECK(sim.hash() == fresh.hash());
}

TEST_CASE("set_state moves everything, and the run resumes from there", "[runtime]") {
  need("runtime.set_state");
  Playground place = playground();
  const SceneModelPtr model = place.builder.build();
  Sim source(model), target(model);
  source.drives = target.drives = place.drives;
  source.run(0.4);
  const WorldState state = source.state();
  REQUIRE(target.world().set_state(state));
  target.forget_state();
  const WorldState got = target.state();
  // Joints win over poses: what differs is by how much the source's joints gaped.
  double moved = 0.0, joints = 0.0;
  for (std::size_t i = 0; i < state.poses.size(); ++i) {
    moved = std::max({moved, (got.poses[i].p - state.poses[i].p).norm(),
                      angle_between(got.poses[i].q, state.poses[i].q)});
  }
  for (std::size_t i = 0; i < state.joint_positions.size(); ++i) {
    joints = std::max(joints, std::abs(got.joint_positions[i] - state.joint_positions[i]));
  }
  measure("difference of poses after setting [m, rad]", moved, 1e-4);
  measure("difference of joint coordinates after setting", joints, 1e-9);
  // A state that was set once fits its joints: setting it again changes nothing.
  REQUIRE(target.world().set_state(got));
  target.forget_state();
  measure("difference after setting it again [m, rad, m/s, rad/s]",
          largest_difference(target.state(), got, got.poses.size()), 1e-9);
  // What contacts remember is gone, so only bodies without contacts continue exactly: the pendulum.
  source.run(0.2);
  target.run(0.2);
  const int bob = find_body(*model, "bob");
  measure("pendulum after 0.2 s [m]", (source.pose(bob).p - target.pose(bob).p).norm(), 1e-4);
  const int lower = find_body(*model, "lower");
  measure("box at rest after 0.2 s [m]", (source.pose(lower).p - target.pose(lower).p).norm(),
          1e-3);
}

TEST_CASE("set_state refuses what does not fit", "[runtime]") {
  need("runtime.set_state");
  Ongoing scene = ongoing();
  Sim sim(scene.builder);
  sim.run(0.1);
  const std::uint64_t before = sim.hash();
  WorldState short_one = sim.state();
  short_one.poses.pop_back();
  CHECK_FALSE(sim.world().set_state(short_one));
  WorldState not_a_number = sim.state();
  not_a_number.twists[1].linear.x() = std::nan("");
  CHECK_FALSE(sim.world().set_state(not_a_number));
  sim.forget_state();
  CHECK(sim.hash() == before);
}

}  // namespace
}  // namespace conformance
