// Scenes that diverge, and the required reports.
#include "scenes.h"

namespace conformance {
namespace {

// Steps until it fails; the world must say so, name the body and not move on.
void must_diverge(SceneModelPtr model, const std::vector<Drive>& drives, int body) {
  Sim sim(std::move(model));
  double before = 0.0;
  StepResult result;
  for (int i = 0; i < 3000 && result.status == StepStatus::ok; ++i) {
    before = sim.world().time();
    result = sim.world().step(kDt, drives);
  }
  REQUIRE(result.status == StepStatus::diverged);
  CHECK(result.body == body);
  CHECK_FALSE(result.message.empty());
  CHECK(sim.world().time() == before);
}

TEST_CASE("a body with a speed beyond all bounds is named", "[faults]") {
  ModelBuilder builder;
  builder.sphere("calm", 0.1, 1.0, at(0, 0, 1));
  const int diverging = builder.sphere("diverging", 0.1, 1.0, at(3, 0, 1));
  builder.model.bodies[1].V_WB.linear = Vec3(1e300, 0, 0);
  must_diverge(builder.build(), {}, diverging);
}

TEST_CASE("a body beyond all bounds is named", "[faults]") {
  ModelBuilder builder;
  builder.sphere("calm", 0.1, 1.0, at(0, 0, 1));
  const int diverging = builder.sphere("diverging", 0.1, 1.0, at(-1e300, 0, 1));
  must_diverge(builder.build(), {}, diverging);
}

TEST_CASE("what stands still at the end of the world ends no program", "[faults]") {
  ModelBuilder builder;
  const int wall = builder.box("wall", Vec3(1, 1, 1), 1.0, at(-1e300, 0, 0));
  builder.model.bodies[wall].kind = BodyKind::static_body;
  builder.sphere("ball", 0.1, 1.0, at(0, 0, 1));
  Sim sim(builder.build());
  for (int i = 0; i < 3; ++i) {
    CHECK(sim.world().step(kDt, {}).status == StepStatus::ok);
  }
}

TEST_CASE("a motor that tears everything apart is named", "[faults]") {
  ModelBuilder builder;
  builder.sphere("calm", 0.1, 1.0, at(0, 0, 1));
  const int arm = builder.box("arm", Vec3(1, 0.1, 0.1), 1.0, at(0.5, 3, 0));
  const int hinge = builder.joint("hinge", JointType::hinge, kWorld, arm, at(0, 3, 0));
  builder.motor("motor", hinge, MotorMode::torque);
  must_diverge(builder.build(), {constant_effort(1e300)}, arm);
}

TEST_CASE("a world that diverged can be reset", "[faults]") {
  ModelBuilder builder;
  const int arm = builder.box("arm", Vec3(1, 0.1, 0.1), 1.0, at(0.5, 0, 0));
  const int hinge = builder.joint("hinge", JointType::hinge, kWorld, arm, Pose());
  builder.motor("motor", hinge, MotorMode::torque);
  const SceneModelPtr model = builder.build();
  Sim sim(model), fresh(model);
  StepResult result;
  for (int i = 0; i < 3000 && result.status == StepStatus::ok; ++i) {
    result = sim.world().step(kDt, {constant_effort(1e300)});
  }
  REQUIRE(result.status == StepStatus::diverged);
  REQUIRE(sim.world().reset());
  sim.forget_state();
  sim.run(0.2);
  fresh.run(0.2);
  CHECK(sim.hash() == fresh.hash());
}

TEST_CASE("bodies that start inside each other do not explode", "[faults]") {
  // Half overlapping boxes of 1 kg: separating them must not shoot them off.
  ModelBuilder builder;
  builder.plane("floor");
  builder.box("one", Vec3(0.2, 0.2, 0.2), 1.0, at(0, 0, 0.1));
  builder.box("two", Vec3(0.2, 0.2, 0.2), 1.0, at(0.02, 0, 0.2));
  Sim sim(builder);
  double fastest = 0.0;
  sim.run(2.0, kDt, [&] {
    for (const int body : {1, 2}) fastest = std::max(fastest, sim.twist(body).linear.norm());
  });
  measure("fastest [m/s]", fastest, 5.0);
  for (const int body : {1, 2}) CHECK(sim.pose(body).p.allFinite());
}

TEST_CASE("mass ratio of a thousand in a joint stays together", "[faults]") {
  ModelBuilder builder;
  const int light = builder.box("light", Vec3(0.05, 0.05, 0.5), 0.1, at(0, 0, -0.25));
  const int heavy = builder.box("heavy", Vec3(0.2, 0.2, 0.2), 100.0, at(0, 0, -0.6));
  const Quat axis = z_to(Vec3::UnitY());
  builder.joint("upper", JointType::hinge, kWorld, light, {Vec3::Zero(), axis});
  const int lower =
      builder.joint("lower", JointType::hinge, light, heavy, {Vec3(0, 0, -0.5), axis});
  builder.model.bodies[1].V_WB.linear = Vec3(0.5, 0, 0);
  Sim sim(builder);
  double gap = 0.0;
  sim.run(3.0, kDt, [&] {
    const Joint& joint = sim.model().joints[lower];
    gap = std::max(
        gap, joint_error(joint, relative_pose(joint, sim.pose(light), sim.pose(heavy))).distance);
  });
  measure("gap [m]", gap, 1e-4);
}

}  // namespace
}  // namespace conformance
