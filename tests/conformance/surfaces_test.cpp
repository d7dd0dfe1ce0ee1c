// Rolling and spinning friction, and surfaces that move along themselves: closed forms.
#include "support.h"

namespace conformance {
namespace {

constexpr double kRadius = 0.1, kMass = 1.0;
constexpr double kLever = 5e-3;  // of rolling or spinning friction [m]

// A ball on a plane that falls by `angle` along its own x; both of the material.
int add_ball(ModelBuilder& builder, double rolling, double spinning, double angle = 0.0) {
  const int surface = builder.material("surface", 0.5);
  builder.model.materials.back().rolling_friction = rolling;
  builder.model.materials.back().spinning_friction = spinning;
  const Pose X_WS(Vec3(1, 2, 0.5), turn(Vec3::UnitY(), angle));
  builder.plane("floor", X_WS, surface);
  return builder.sphere("ball", kRadius, kMass, X_WS * at(0, 0, kRadius), surface);
}

Twist& start_of(ModelBuilder& builder, int body) { return builder.model.bodies[body].V_WB; }

TEST_CASE("rolling friction stops a ball", "[friction]") {
  // The torque d m g against the rolling of 7/5 m r^2 about the point of contact: it is slowed by
  // 5/7 g d / r, and stops after v^2 / 2 of that. First-order sampling errs by v dt / 2 = 0.5 mm.
  const double v = 1.0, heading = GENERATE(0.0, 40.0) * kDegree;
  const Vec3 forward(std::cos(heading), std::sin(heading), 0);
  ModelBuilder builder;
  const int ball = add_ball(builder, kLever, 0.0);
  start_of(builder, ball) = {v * forward, Vec3::UnitZ().cross(forward) * (v / kRadius)};
  Sim sim(builder);
  const Vec3 start = sim.pose(ball).p;
  sim.run(4.0);  // it stops after 2.9 s
  const Vec3 way = sim.pose(ball).p - start;
  const double slowing = 5.0 / 7.0 * kGravity * kLever / kRadius;
  measure_relative("stopping distance", way.dot(forward), 0.5 * v * v / slowing, 2e-3);
  measure("sideways over distance", std::abs(way.cross(forward).z()) / way.norm(), 2e-3);
  measure("speed at rest [m/s]", sim.twist(ball).linear.norm(), 1e-6);
}

TEST_CASE("a ball rests on a slope below its rolling friction", "[friction]") {
  // d m g cos(a) holds m g sin(a) r.
  ModelBuilder builder;
  const int ball = add_ball(builder, kLever, 0.0, std::atan(0.9 * kLever / kRadius));
  Sim sim(builder);
  const Vec3 start = sim.pose(ball).p;
  sim.run(3.0);
  measure("creep in 3 s [m]", (sim.pose(ball).p - start).norm(), 1e-3);
}

TEST_CASE("a ball rolls on a slope above its rolling friction", "[friction]") {
  const double angle = std::atan(2.0 * kLever / kRadius);
  ModelBuilder builder;
  const int ball = add_ball(builder, kLever, 0.0, angle);
  Sim sim(builder);
  LineFit fit;
  double t = 0.0;
  sim.run(1.5, kDt, [&] {
    t += kDt;
    if (t > 0.5) fit.add(t, sim.twist(ball).linear.norm());
  });
  const double expected =
      5.0 / 7.0 * kGravity * (std::sin(angle) - std::cos(angle) * kLever / kRadius);
  measure_relative("acceleration", fit.slope(), expected, 2e-3);
}

TEST_CASE("spinning friction stops a ball", "[friction]") {
  // The torque d m g against the inertia 2/5 m r^2. First-order sampling errs by w dt / 2.
  const double w = 10.0;
  ModelBuilder builder;
  const int ball = add_ball(builder, 0.0, kLever);
  start_of(builder, ball).angular = Vec3(0, 0, w);
  Sim sim(builder);
  double angle = 0.0;
  sim.run(1.2, kDt, [&] { angle += kDt * sim.twist(ball).angular.z(); });  // it stops after 0.8 s
  const double slowing = kLever * kGravity / (0.4 * kRadius * kRadius);
  measure_relative("turned", angle, 0.5 * w * w / slowing, 3e-3);
  measure("spin at rest [rad/s]", sim.twist(ball).angular.norm(), 1e-6);
}

constexpr double kMu = 0.4, kBelt = 1.0;  // [1], [m/s]

// A plane whose surface moves along its own x, which points to `heading`.
void add_belt(ModelBuilder& builder, double heading) {
  const int surface = builder.material("surface", kMu);
  builder.plane("belt", Pose(Vec3(1, 2, 0.5), turn(Vec3::UnitZ(), heading)), surface);
  builder.model.bodies.back().shapes[0].surface_velocity = Vec3(kBelt, 0, 0);
}

TEST_CASE("a belt takes a block along", "[friction]") {
  // Accelerated by mu g until it is as fast as the belt, behind by v^2 / (2 mu g) = 0.13 m.
  const double heading = GENERATE(0.0, 40.0) * kDegree;
  const Vec3 forward(std::cos(heading), std::sin(heading), 0);
  ModelBuilder builder;
  add_belt(builder, heading);
  const int block = builder.box("block", Vec3(0.3, 0.2, 0.1), 2.0, at(1, 2, 0.55), 1);
  Sim sim(builder);
  const Vec3 start = sim.pose(block).p;
  sim.run(0.1);
  measure_relative("speed after 0.1 s", sim.twist(block).linear.dot(forward), kMu * kGravity * 0.1,
                   5e-3);
  sim.run(0.9);
  measure_relative("speed after 1 s", sim.twist(block).linear.dot(forward), kBelt, 1e-3);
  const Vec3 way = sim.pose(block).p - start;
  measure_relative("way in 1 s", way.dot(forward), kBelt - 0.5 * kBelt * kBelt / (kMu * kGravity),
                   2e-3);
  measure("sideways over the way", std::abs(way.cross(forward).z()) / way.norm(), 2e-3);
}

TEST_CASE("a belt makes a ball roll", "[friction]") {
  // Its angular momentum about a point of the belt is zero: m r v = 2/5 m r^2 w, and v + w r is the
  // belt's speed once it rolls, after 2 v / (7 mu g) = 0.07 s.
  ModelBuilder builder;
  add_belt(builder, 0.0);
  const int ball = builder.sphere("ball", kRadius, kMass, at(1, 2, 0.5 + kRadius), 1);
  Sim sim(builder);
  sim.run(0.5);
  measure_relative("speed", sim.twist(ball).linear.x(), 2.0 / 7.0 * kBelt, 5e-3);
  measure_relative("spin", -sim.twist(ball).angular.y(), 5.0 / 7.0 * kBelt / kRadius, 5e-3);
}

TEST_CASE("a body drives on surfaces that move", "[friction]") {
  // As a vehicle on tracks: its surface moves backwards, itself forwards, wherever it points.
  const double heading = GENERATE(0.0, 130.0) * kDegree;
  const Vec3 forward(std::cos(heading), std::sin(heading), 0);
  ModelBuilder builder;
  const int surface = builder.material("surface", kMu);
  builder.plane("floor", Pose(), surface);
  const int tracks = builder.box("tracks", Vec3(0.3, 0.2, 0.1), 2.0,
                                 Pose(Vec3(0, 0, 0.05), turn(Vec3::UnitZ(), heading)), surface);
  builder.model.bodies.back().shapes[0].surface_velocity = Vec3(-kBelt, 0, 0);
  Sim sim(builder);
  sim.run(1.0);
  measure_relative("speed", sim.twist(tracks).linear.dot(forward), kBelt, 1e-3);
  measure_relative("way in 1 s", sim.pose(tracks).p.dot(forward),
                   kBelt - 0.5 * kBelt * kBelt / (kMu * kGravity), 2e-3);
}

}  // namespace
}  // namespace conformance
