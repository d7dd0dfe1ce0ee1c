// Restitution: the rebound after a drop, independent of the time of impact within a step.
#include "support.h"

namespace conformance {
namespace {

constexpr double kDrop = 1.0;  // [m], gap under the body at the start
constexpr double kRadius = 0.1;

// Height [m] of the first bounce above the position of rest, of body 1 dropped onto body 0. The top
// between two samples is completed by v^2 / 2g.
double bounce_height(ModelBuilder& builder, double rest_height) {
  Sim sim(builder);
  const double fall = std::sqrt(2.0 * kDrop / kGravity);
  double top = 0.0;
  bool rebounded = false, down_again = false;
  sim.run(2.6 * fall, kDt, [&] {
    const double v = sim.twist(1).linear.z();
    if (v > 0.0) rebounded = true;
    if (rebounded && v < 0.0) down_again = true;
    if (!rebounded || down_again) return;
    // Only once it has left the surface: before that the contact still gives it energy.
    const double height = sim.pose(1).p.z() - rest_height;
    if (height > 0.0) top = std::max(top, height + 0.5 * v * v / kGravity);
  });
  return top;
}

// e = 0.5 and 0.8: relative to e^2 H. e = 0: the bounce may not exceed what a body at rest may be
// off its height, 1 mm.
void check_height(double e, double height) {
  if (e > 0.0) {
    measure_relative("bounce height at e > 0", height, e * e * kDrop, 0.02);
  } else {
    measure("bounce height at e = 0 [m]", height, 1e-3);
  }
}

// Drop heights that move the impact through one step in sixteenths.
double phase_shift(int phase) {
  const double speed = std::sqrt(2.0 * kGravity * kDrop);
  return speed * kDt * phase / 16.0;
}

TEST_CASE("bounce of a sphere on a plane", "[bounce]") {
  const double e = GENERATE(0.0, 0.5, 0.8);
  for (int phase = 0; phase < 16; ++phase) {
    ModelBuilder builder;
    const int elastic = builder.material("elastic", 0.5, e);
    builder.plane("floor", Pose(), elastic);
    builder.sphere("ball", kRadius, 1.0, at(0, 0, kRadius + kDrop + phase_shift(phase)), elastic);
    check_height(e, bounce_height(builder, kRadius));
  }
}

TEST_CASE("bounce of a sphere on a box", "[bounce]") {
  const double e = GENERATE(0.0, 0.5, 0.8);
  for (int phase = 0; phase < 16; ++phase) {
    ModelBuilder builder;
    const int elastic = builder.material("elastic", 0.5, e);
    builder.box("slab", Vec3(2, 2, 0.5), 0.0, at(0, 0, -0.25), elastic);
    builder.sphere("ball", kRadius, 1.0, at(0, 0, kRadius + kDrop + phase_shift(phase)), elastic);
    check_height(e, bounce_height(builder, kRadius));
  }
}

TEST_CASE("bounce of a box that lands flat", "[bounce]") {
  const double e = GENERATE(0.0, 0.5, 0.8);
  for (int phase = 0; phase < 16; ++phase) {
    ModelBuilder builder;
    const int elastic = builder.material("elastic", 0.5, e);
    builder.plane("floor", Pose(), elastic);
    builder.box("box", Vec3(0.3, 0.3, 0.2), 1.0, at(0, 0, 0.1 + kDrop + phase_shift(phase)),
                elastic);
    check_height(e, bounce_height(builder, 0.1));
  }
}

TEST_CASE("bounce of two free spheres, head on", "[bounce]") {
  // v1' = (m1 - e m2) / (m1 + m2) v, v2' = (1 + e) m1 / (m1 + m2) v.
  const double e = GENERATE(0.0, 0.5, 0.8), m1 = 1.0, m2 = 3.0, v = 2.0;
  for (int phase = 0; phase < 16; ++phase) {
    ModelBuilder builder;
    builder.model.physics.gravity = Vec3::Zero();
    const int elastic = builder.material("elastic", 0.0, e);
    builder.sphere("one", kRadius, m1, at(0, 0, 0), elastic);
    builder.sphere("two", kRadius, m2, at(0.5 + v * kDt * phase / 16.0, 0, 0), elastic);
    builder.model.bodies[0].V_WB.linear = Vec3(v, 0, 0);
    Sim sim(builder);
    sim.run(0.5);
    // 2 % of the height is 1 % of the speed.
    measure("speed of the struck one, relative",
            std::abs(sim.twist(1).linear.x() / ((1 + e) * m1 / (m1 + m2) * v) - 1.0), 0.01);
    measure("speed of the striking one over v",
            std::abs(sim.twist(0).linear.x() - (m1 - e * m2) / (m1 + m2) * v) / v, 0.01);
  }
}

TEST_CASE("approaches below the threshold do not bounce", "[bounce]") {
  ModelBuilder builder;
  const int elastic = builder.material("elastic", 0.5, 0.8);
  builder.model.physics.bounce_threshold = 0.5;
  builder.plane("floor", Pose(), elastic);
  const double drop = 0.8 * 0.5 * 0.5 / (2.0 * kGravity);  // arrives at 0.45 m/s
  builder.sphere("ball", kRadius, 1.0, at(0, 0, kRadius + drop), elastic);
  Sim sim(builder);
  double fastest = 0.0;
  sim.run(0.3, kDt, [&] { fastest = std::max(fastest, sim.twist(1).linear.z()); });
  // A bounce at e = 0.8 would leave with 0.36 m/s.
  measure("speed upwards [m/s]", fastest, 0.05);
}

}  // namespace
}  // namespace conformance
