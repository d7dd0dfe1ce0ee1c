// Forces and torques that are given for each step.
#include "cogrsim/physics/world.h"
#include "support.h"

namespace conformance {
namespace {

ExternalForces& external(Sim& sim) {
  need("body.force");
  auto* const found = sim.world().extension<ExternalForces>();
  REQUIRE(found != nullptr);
  return *found;
}

TEST_CASE("a force and a torque from outside", "[free]") {
  constexpr double kMass = 2.0, kInertia = 0.3;
  const Vec3 force(1.0, -2.0, 3.0), torque(0.0, 0.0, 0.6), com(0.1, 0.2, -0.1);
  ModelBuilder builder;
  builder.model.physics.gravity.setZero();
  const int body = builder.body("body", kMass, kInertia * Mat3::Identity(), at(1, 2, 3));
  builder.model.bodies[0].com = com;
  const int other = builder.body("other", kMass, kInertia * Mat3::Identity(), at(5, 0, 0));
  Sim sim(builder);
  ExternalForces& given = external(sim);
  given.set_external_forces({{force, torque}, {}});
  sim.run(1.0);
  const Twist& V = sim.twist(body);
  const Vec3 at_com = V.at(sim.pose(body).q * com);
  measure("velocity off [m/s]", (at_com - force / kMass).norm(), 1e-9);
  measure("spin off [rad/s]", (V.angular - torque / kInertia).norm(), 1e-9);
  measure("other body moves [m/s]", sim.twist(other).linear.norm(), 1e-15);
  // Half a step's worth at most: methods of first order.
  const Vec3 way = sim.pose(body) * com - Vec3(1.1, 2.2, 2.9);
  measure("path off [m]", (way - 0.5 * force / kMass).norm(), 0.51 * kDt * force.norm() / kMass);
  given.set_external_forces({});
  sim.run(0.5);
  measure("velocity changes without force [m/s]",
          (sim.twist(body).at(sim.pose(body).q * com) - force / kMass).norm(), 1e-9);
}

TEST_CASE("a force from outside drives a chain", "[joints]") {
  // A torque on the second of two wheels on one axis, the first carrying the second's hinge: it turns
  // the second alone. A force beside the first's axis turns both.
  constexpr double kFirst = 0.2, kSecond = 0.1, kTorque = 0.05;
  ModelBuilder builder;
  builder.model.physics.gravity.setZero();
  const int first = builder.body("first", 1.0, kFirst * Mat3::Identity(), at(0, 0, 0));
  const int second = builder.body("second", 1.0, kSecond * Mat3::Identity(), at(0, 0, 0));
  const int base = builder.joint("base", JointType::hinge, kWorld, first, at(0, 0, 0));
  const int top = builder.joint("top", JointType::hinge, first, second, at(0, 0, 0));
  Sim sim(builder);
  ExternalForces& given = external(sim);
  given.set_external_forces({{}, {Vec3::Zero(), Vec3(0, 0, kTorque)}});
  sim.run(1.0);
  measure("first turns [rad/s]", std::abs(sim.u(base)), 1e-6);
  measure_relative("second's speed", sim.u(top), kTorque / kSecond, 1e-6);
  if (backend().capabilities().get("report.joint_reaction").support != Support::unsupported) {
    // The hinge has no friction: no torque about its axis comes through.
    measure("torque through the hinge [N m]", std::abs(sim.reaction(top).torque.z()), 1e-6);
  }
}

TEST_CASE("a force holds a floating chain where it is", "[momentum]") {
  // Against the weight of both links, at the centre of the first: the momentum stays zero.
  ModelBuilder builder;
  const int first = builder.body("first", 1.0, Mat3::Identity(), at(0, 0, 0));
  const int second = builder.body("second", 2.0, Mat3::Identity(), at(1, 0, 0));
  builder.joint("hinge", JointType::hinge, first, second,
                {Vec3(0.5, 0, 0), z_to(Vec3::UnitY())});
  Sim sim(builder);
  ExternalForces& given = external(sim);
  given.set_external_forces({{Vec3(0, 0, 3.0 * kGravity), Vec3::Zero()}, {}});
  sim.run(0.5);
  measure("linear momentum [kg m/s]", sim.momentum().linear.norm(), 1e-9);
}

}  // namespace
}  // namespace conformance
