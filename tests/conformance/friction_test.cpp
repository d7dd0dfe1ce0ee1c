// Rolling and sliding down a slope.
#include "support.h"

namespace conformance {
namespace {

// A plane through a point away from the origin, falling by `angle` along its own x, whose compass
// direction is `heading`.
Pose slope(double angle, double heading) {
  return {Vec3(1, 2, 0.5), turn(Vec3::UnitZ(), heading) * turn(Vec3::UnitY(), angle)};
}

struct Slide {
  double acceleration = 0.0;  // downhill, fitted after the first half second
  double distance = 0.0;      // downhill
  double sideways = 0.0;
  double slip = 0.0;  // |v - w r| / v at the end, for what rolls
};

// Runs body 1 down body 0, its centre `radius` above it.
Slide slide(ModelBuilder& builder, const Pose& X_WS, double radius, double seconds, double from) {
  Sim sim(builder);
  const Vec3 start = sim.pose(1).p, down = X_WS.q * Vec3::UnitX(), side = X_WS.q * Vec3::UnitY();
  LineFit fit;
  double t = 0.0;
  sim.run(seconds, kDt, [&] {
    t += kDt;
    if (t >= from) fit.add(t, sim.twist(1).linear.dot(down));
  });
  Slide result;
  result.acceleration = fit.slope();
  result.distance = (sim.pose(1).p - start).dot(down);
  result.sideways = std::abs((sim.pose(1).p - start).dot(side));
  const double v = sim.twist(1).linear.dot(down);
  result.slip = std::abs(v - radius * sim.twist(1).angular.dot(side)) / std::abs(v);
  return result;
}

TEST_CASE("sphere rolls down a slope", "[friction]") {
  const double angle = 20.0 * kDegree, radius = 0.1;
  const double heading = GENERATE(0.0, 40.0, 200.0) * kDegree;
  ModelBuilder builder;
  const int rough = builder.material("rough", 0.8);
  const Pose X_WS = slope(angle, heading);
  builder.plane("slope", X_WS, rough);
  builder.sphere("ball", radius, 1.5, X_WS * at(0, 0, radius), rough);
  const Slide result = slide(builder, X_WS, radius, 1.5, 0.5);
  const double expected = 5.0 / 7.0 * kGravity * std::sin(angle);
  measure_relative("acceleration", result.acceleration, expected, 1e-3);
  measure("slip over speed", result.slip, 1e-3);
  measure("sideways over distance", result.sideways / result.distance, 1e-3);
}

TEST_CASE("cylinder rolls down a slope", "[friction]") {
  const double angle = 20.0 * kDegree, radius = 0.1;
  const double heading = GENERATE(0.0, 40.0, 200.0) * kDegree;
  ModelBuilder builder;
  const int rough = builder.material("rough", 0.8);
  const Pose X_WS = slope(angle, heading);
  builder.plane("slope", X_WS, rough);
  builder.cylinder("roller", radius, 0.3, 1.5, X_WS * Pose(Vec3(0, 0, radius), z_to(Vec3::UnitY())),
                   rough);
  const Slide result = slide(builder, X_WS, radius, 1.5, 0.5);
  const double expected = 2.0 / 3.0 * kGravity * std::sin(angle);
  measure_relative("acceleration", result.acceleration, expected, 1e-3);
  measure("slip over speed", result.slip, 1e-3);
  measure("sideways over distance", result.sideways / result.distance, 1e-3);
}

TEST_CASE("sphere that skids before it rolls", "[friction]") {
  // Thrown without spin it slides at mu g until v = 5/7 v0, after 2 v0 / (7 mu g).
  const double mu = 0.3, radius = 0.1, v0 = 3.0;
  ModelBuilder builder;
  const int surface = builder.material("surface", mu);
  builder.plane("floor", Pose(), surface);
  const int ball = builder.sphere("ball", radius, 1.0, at(0, 0, radius), surface);
  builder.model.bodies[1].V_WB.linear = Vec3(v0, 0, 0);
  Sim sim(builder);
  const double rolls_at = 2.0 * v0 / (7.0 * mu * kGravity);
  LineFit fit;
  double t = 0.0;
  sim.run(2.0 * rolls_at, kDt, [&] {
    t += kDt;
    if (t > 0.2 * rolls_at && t < 0.9 * rolls_at) fit.add(t, sim.twist(ball).linear.x());
  });
  measure_relative("deceleration while it skids", fit.slope(), -mu * kGravity, 5e-3);
  measure_relative("speed once it rolls", sim.twist(ball).linear.x(), 5.0 / 7.0 * v0, 5e-3);
}

constexpr double kMu = 0.5;

void add_block(ModelBuilder& builder, const Pose& X_WS) {
  const int surface = builder.material("surface", kMu);
  builder.plane("slope", X_WS, surface);
  builder.box("block", Vec3(0.3, 0.2, 0.1), 2.0, X_WS * at(0, 0, 0.05), surface);
}

TEST_CASE("block slides one degree above the friction angle", "[friction]") {
  const double angle = std::atan(kMu) + 1.0 * kDegree;
  const double heading = GENERATE(0.0, 40.0) * kDegree;
  const Pose X_WS = slope(angle, heading);
  ModelBuilder builder;
  add_block(builder, X_WS);
  const Slide result = slide(builder, X_WS, 1.0, 2.0, 0.5);
  const double expected = kGravity * (std::sin(angle) - kMu * std::cos(angle));
  measure_relative("acceleration", result.acceleration, expected, 5e-3);
}

TEST_CASE("block stays one degree below the friction angle", "[friction]") {
  const double angle = std::atan(kMu) - 1.0 * kDegree;
  const double heading = GENERATE(0.0, 40.0) * kDegree;
  const Pose X_WS = slope(angle, heading);
  ModelBuilder builder;
  add_block(builder, X_WS);
  const Slide result = slide(builder, X_WS, 1.0, 5.0, 0.5);
  measure("creep in 5 s [m]", std::abs(result.distance), 1e-3);
  measure("sideways creep in 5 s [m]", result.sideways, 1e-3);
}

TEST_CASE("friction of a pair is decided by the scene", "[friction]") {
  // sqrt(0.2 * 0.8) = 0.4 by the general rule; a <contact> between the two materials wins.
  const double v0 = 2.0;
  const bool own = GENERATE(false, true);
  ModelBuilder builder;
  const int ice = builder.material("ice", 0.2), rubber = builder.material("rubber", 0.8);
  if (own) {
    MaterialPair pair;
    pair.a = ice;
    pair.b = rubber;
    pair.friction = 0.25;
    builder.model.material_pairs.push_back(pair);
  }
  builder.plane("floor", Pose(), ice);
  const int block = builder.box("block", Vec3(0.4, 0.4, 0.1), 1.0, at(0, 0, 0.05), rubber);
  builder.model.bodies[1].V_WB.linear = Vec3(v0, 0, 0);
  Sim sim(builder);
  LineFit fit;
  double t = 0.0;
  sim.run(0.35, kDt, [&] {
    t += kDt;
    if (t > 0.1) fit.add(t, sim.twist(block).linear.x());
  });
  measure_relative("deceleration", fit.slope(), -(own ? 0.25 : 0.4) * kGravity, 5e-3);
}

TEST_CASE("friction is the same in every direction", "[friction]") {
  // d = v^2 / (2 mu g), straight on; first-order sampling errs by v dt / 2.
  const double v0 = 2.0, mu = 0.5;
  const double heading = GENERATE(0.0, 15.0, 30.0, 45.0, 100.0) * kDegree;
  ModelBuilder builder;
  const int surface = builder.material("surface", mu);
  builder.plane("floor", Pose(), surface);
  const int block = builder.box("block", Vec3(0.4, 0.4, 0.05), 1.0, at(0, 0, 0.025), surface);
  const Vec3 forward(std::cos(heading), std::sin(heading), 0);
  builder.model.bodies[1].V_WB.linear = v0 * forward;
  Sim sim(builder);
  sim.run(1.0);
  const Vec3 displacement = sim.pose(block).p - Vec3(0, 0, 0.025);
  const double expected = v0 * v0 / (2.0 * mu * kGravity);
  measure_relative("sliding distance", displacement.dot(forward), expected, 5e-3);
  measure("sideways over the distance", (displacement - displacement.dot(forward) * forward).norm() / expected, 5e-3);
}

TEST_CASE("a ball that rolls on the level loses nothing", "[friction]") {
  const double v = 1.0, radius = 0.1, spin = 4.0;
  ModelBuilder builder;
  builder.plane("floor");
  const int ball = builder.sphere("ball", radius, 1.0, at(0, 0, radius));
  builder.model.bodies[1].V_WB = {Vec3(v, 0, 0), Vec3(0, v / radius, spin)};
  Sim sim(builder);
  sim.run(3.0);
  measure_relative("speed after 3 s", sim.twist(ball).linear.x(), v, 1e-3);
  // One point of contact has no torque about its normal.
  measure_relative("spin about the vertical after 3 s", sim.twist(ball).angular.z(), spin, 1e-3);
}

}  // namespace
}  // namespace conformance
