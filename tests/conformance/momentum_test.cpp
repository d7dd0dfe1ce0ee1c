// Conservation in free space: a chain that is hit may fold up, its momentum may not change.
#include "scenes.h"

namespace conformance {
namespace {

struct Conservation {
  double linear = 0.0, angular = 0.0;  // relative
  double energy = 0.0;                 // at the end over the start
  double struck = 0.0;                 // speed of the outermost bar [m/s]
};

// A ball hits a floating chain of three bars off its middle; `motors` lets its hinges work too.
Conservation collide(double e, bool motors) {
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const int elastic = builder.material("elastic", 0.4, e);
  builder.model.materials[0] = builder.model.materials[elastic];
  const Chain chain = add_chain(builder, {Vec3(0.2, 0.1, -0.3), turn(Vec3(1, 1, 0), 0.4)});
  if (motors) {
    for (const int hinge : chain.hinges)
      builder.motor("m" + std::to_string(hinge), hinge, MotorMode::velocity);
  }
  const Pose X_WB = builder.model.bodies[2].X_WB;
  const Vec3 towards = X_WB.q * Vec3(0.1, -1, 0.3).normalized();
  const int ball = builder.sphere(
      "ball", 0.1, 2.0, {X_WB * Vec3(0.1, 0, 0) - 0.5 * towards, Quat(1, 0, 0, 0)}, elastic);
  builder.model.bodies[ball].V_WB.linear = 2.0 * towards;
  Sim sim(builder);
  for (std::size_t i = 0; i < sim.drives.size(); ++i) {
    sim.drives[i] = speed_source(i == 0 ? 1.0 : -0.5, 0.5);
  }
  const Momentum before = sim.momentum();
  const double energy = sim.energy();
  sim.run(1.0);
  const Momentum after = sim.momentum();
  Conservation result;
  result.linear = (after.linear - before.linear).norm() / before.linear.norm();
  result.angular = (after.angular - before.angular).norm() / before.angular.norm();
  result.energy = sim.energy() / energy;
  result.struck = sim.twist(2).linear.norm();
  return result;
}

TEST_CASE("momentum: ball hits a floating chain", "[momentum]") {
  const double e = GENERATE(0.0, 0.5, 1.0);
  const Conservation result = collide(e, false);
  REQUIRE(result.struck > 0.1);
  measure("linear momentum error, relative", result.linear, 1e-6);
  measure("angular momentum error, relative", result.angular, 1e-3);
  // Passive bodies gain no energy; 1 % for a first-order integrator's bias at 2 m/s.
  measure("energy over that at the start", result.energy, 1.01);
}

TEST_CASE("momentum: ball hits a chain whose motors work", "[momentum]") {
  const Conservation result = collide(0.5, true);
  REQUIRE(result.struck > 0.1);
  measure("linear momentum error, relative", result.linear, 1e-6);
  measure("angular momentum error, relative", result.angular, 1e-3);
}

TEST_CASE("momentum: chain that only folds", "[momentum]") {
  // Internal motion alone; angular momentum starts from a spin.
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const Chain chain = add_chain(builder, Pose());
  const Vec3 spin(0.3, 0.5, 1.0);
  for (const int bar : chain.bars) {
    Body& body = builder.model.bodies[bar];
    body.V_WB = {spin.cross(body.X_WB.p) + Vec3(0.2, 0, 0), spin};
  }
  Sim sim(builder);
  const Momentum before = sim.momentum();
  const double energy = sim.energy();
  sim.run(3.0);
  const Momentum after = sim.momentum();
  measure("linear momentum error, relative",
          (after.linear - before.linear).norm() / before.linear.norm(), 1e-6);
  measure("angular momentum error, relative",
          (after.angular - before.angular).norm() / before.angular.norm(), 1e-3);
  measure_relative("energy", sim.energy(), energy, 0.01);
}

}  // namespace
}  // namespace conformance
