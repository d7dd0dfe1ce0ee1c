// The forces that joints transmit, and the efforts they report.
#include "support.h"

namespace conformance {
namespace {

constexpr double kTolerance = 1e-3;  // relative: a tenth of the table's for contact forces

double relative(const Vec3& value, const Vec3& expected) {
  return (value - expected).norm() / expected.norm();
}

TEST_CASE("reaction: hanging rod", "[reports]") {
  const double mass = 2.0;
  ModelBuilder builder;
  const int rod = builder.box("rod", Vec3(0.05, 0.05, 1.0), mass, at(1, 2, 2.5));
  const int hinge =
      builder.joint("hinge", JointType::hinge, kWorld, rod, {Vec3(1, 2, 3), z_to(Vec3::UnitY())});
  Sim sim(builder);
  sim.run(0.5);
  const Wrench wrench = sim.reaction(hinge);
  measure("force error, relative", relative(wrench.force, Vec3(0, 0, mass * kGravity)), kTolerance);
  measure("torque over m g L", wrench.torque.norm() / (mass * kGravity * 1.0), kTolerance);
}

TEST_CASE("reaction: cantilever", "[reports]") {
  // The world holds the arm's weight at its end and the moment m g d.
  const double mass = 2.0, distance = 0.4;
  ModelBuilder builder;
  const int arm =
      builder.box("arm", Vec3(2.0 * distance, 0.05, 0.05), mass, at(1 + distance, 2, 3));
  const int weld = builder.joint("weld", JointType::fixed, kWorld, arm, at(1, 2, 3));
  Sim sim(builder);
  sim.run(0.5);
  const Wrench wrench = sim.reaction(weld);
  measure("force error, relative", relative(wrench.force, Vec3(0, 0, mass * kGravity)), kTolerance);
  measure("torque error, relative",
          relative(wrench.torque, Vec3(0, -mass * kGravity * distance, 0)), kTolerance);
}

TEST_CASE("reaction: each link of a chain carries what hangs on it", "[reports]") {
  ModelBuilder builder;
  std::vector<int> joints;
  int parent = kWorld;
  for (int i = 0; i < 3; ++i) {
    const int rod = builder.box("rod" + std::to_string(i), Vec3(0.05, 0.05, 0.5), 1.0 + i,
                                at(0, 0, -0.5 * i - 0.25));
    joints.push_back(builder.joint("joint" + std::to_string(i),
                                   i == 1 ? JointType::ball : JointType::hinge, parent, rod,
                                   {Vec3(0, 0, -0.5 * i), z_to(Vec3::UnitY())}));
    parent = rod;
  }
  Sim sim(builder);
  sim.run(0.5);
  double below = 6.0;
  for (int i = 0; i < 3; ++i) {
    measure("force error, relative",
            relative(sim.reaction(joints[i]).force, Vec3(0, 0, below * kGravity)), kTolerance);
    below -= 1.0 + i;
  }
}

TEST_CASE("reaction: centripetal force of a turning arm", "[reports]") {
  const double mass = 2.0, distance = 0.5, w = 3.0;
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const int arm = builder.box("arm", Vec3(0.2, 0.1, 0.1), mass, at(distance, 0, 0));
  const int hinge = builder.joint("hinge", JointType::hinge, kWorld, arm, Pose());
  builder.model.bodies[0].V_WB = {Vec3(0, w * distance, 0), Vec3(0, 0, w)};
  builder.model.joints[0].velocity = {w};
  Sim sim(builder);
  sim.run(0.5);
  const Vec3 inwards = -sim.pose(arm).p.normalized() * (mass * w * w * distance);
  // Mean over the step that ended at this pose: the direction is half a step old, w dt / 2.
  measure("force error, relative", relative(sim.reaction(hinge).force, inwards),
          w * kDt + kTolerance);
}

TEST_CASE("reaction: a motor's torque is in it", "[reports]") {
  const double torque = 0.3;
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const int wheel = builder.cylinder("wheel", 0.2, 0.1, 1.0, Pose());
  const int hinge = builder.joint("hinge", JointType::hinge, kWorld, wheel, Pose());
  const int motor = builder.motor("motor", hinge, MotorMode::torque);
  Sim sim(builder);
  sim.drive(motor) = constant_effort(torque);
  sim.run(0.2);
  measure_relative("motor effort", sim.motor_effort(motor), torque, 1e-9);
  measure_relative("joint effort", sim.effort(hinge), torque, kTolerance);
  measure("torque error, relative", relative(sim.reaction(hinge).torque, Vec3(0, 0, torque)),
          kTolerance);
}

TEST_CASE("reaction: motor that holds an arm level", "[reports]") {
  const double mass = 1.0, distance = 0.5;
  ModelBuilder builder;
  const int arm = builder.box("arm", Vec3(1.0, 0.05, 0.05), mass, at(distance, 0, 0));
  const int hinge =
      builder.joint("hinge", JointType::hinge, kWorld, arm, {Vec3::Zero(), z_to(-Vec3::UnitY())});
  const int motor = builder.motor("motor", hinge, MotorMode::velocity);
  Sim sim(builder);
  sim.drive(motor) = speed_source(0.0);
  sim.run(1.0);
  measure("sag [rad]", std::abs(sim.q(hinge)), 1e-4);
  measure_relative("motor effort", sim.motor_effort(motor), mass * kGravity * distance, kTolerance);
  measure("torque error, relative",
          relative(sim.reaction(hinge).torque, Vec3(0, -mass * kGravity * distance, 0)),
          kTolerance);
}

}  // namespace
}  // namespace conformance
