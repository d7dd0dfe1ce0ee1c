// Loops closed by each type of joint that can close one.
#include "linkage.h"

namespace conformance {
namespace {

constexpr double kClosure = 1e-4;  // [m], the four-bar's figure

void mark_loop(ModelBuilder& builder, int joint) { builder.model.joints[joint].closes_loop = true; }

void four_bar_closed_by(JointType closing) {
  const Driven worst = run_driven(3.0, closing);
  measure("closure [m]", worst.gap, kClosure);
  // A gap of 1e-4 m turns the rocker by at most 4e-4 rad, see the four-bar's own test.
  measure("rocker angle error [rad]", worst.rocker_error, 4e-4);
}

TEST_CASE("loop closed by a ball", "[loop]") { four_bar_closed_by(JointType::ball); }
TEST_CASE("loop closed by a cylindrical", "[loop]") { four_bar_closed_by(JointType::cylindrical); }
TEST_CASE("loop closed by a universal", "[loop]") { four_bar_closed_by(JointType::universal); }
TEST_CASE("loop closed by a gimbal", "[loop]") { four_bar_closed_by(JointType::gimbal); }

// Crank, rod and a piston on rails: x = r cos a + sqrt(l^2 - r^2 sin^2 a). The loop is closed by
// the piston's rails or by its pin.
void slider_crank(bool by_rails) {
  const double r = 0.2, l = 0.6, rate = 2.0 * kPi;
  ModelBuilder builder;
  const double start = 60.0 * kDegree;
  const Vec3 b(r * std::cos(start), 0, r * std::sin(start));
  const Vec3 c(b.x() + std::sqrt(l * l - b.z() * b.z()), 0, 0);
  const int crank = add_bar(builder, "crank", Vec3::Zero(), b);
  const int rod = add_bar(builder, "rod", b, c);
  const int piston = builder.body("piston", 0.5, Mat3(1e-3 * Mat3::Identity()), at(c.x(), 0, 0));
  const Quat axis = z_to(-Vec3::UnitY()), along = z_to(Vec3::UnitX());
  const int drive = builder.joint("drive", JointType::hinge, kWorld, crank, {Vec3::Zero(), axis});
  builder.joint("crank_pin", JointType::hinge, crank, rod, {b, axis});
  int loop = -1;
  if (by_rails) {
    builder.joint("piston_pin", JointType::hinge, rod, piston, {c, axis});
    loop = builder.joint("rails", JointType::slider, kWorld, piston, {c, along});
  } else {
    builder.joint("rails", JointType::slider, kWorld, piston, {c, along});
    loop = builder.joint("piston_pin", JointType::hinge, rod, piston, {c, axis});
  }
  mark_loop(builder, loop);
  builder.motor("motor", drive, MotorMode::velocity);
  Sim sim(builder);
  sim.drives[0] = speed_source(rate);
  double gap = 0.0, error = 0.0;
  sim.run(3.0, kDt, [&] {
    gap = std::max(gap, gap_of(sim, loop));
    const double a = start + sim.q(drive), height = r * std::sin(a);
    error = std::max(error, std::abs(sim.pose(piston).p.x() - r * std::cos(a) -
                                     std::sqrt(l * l - height * height)));
  });
  measure("closure [m]", gap, kClosure);
  measure("piston's place error [m]", error,
          2.0 * kClosure);  // closure at the rails and at the pin
}

TEST_CASE("loop closed by a slider", "[loop]") { slider_crank(true); }
TEST_CASE("loop of hinges and a slider, closed by a hinge", "[loop]") { slider_crank(false); }

TEST_CASE("loop closed by a fixed joint", "[loop]") {
  // The coupler of a parallelogram is two halves that are welded together.
  ModelBuilder builder;
  const double length = 0.5;
  const Vec3 a(0, 0, 0), d(1, 0, 0), lean(length * std::sin(0.6), 0, -length * std::cos(0.6));
  const Vec3 b = a + lean, c = d + lean, middle = 0.5 * (b + c);
  const int left = add_bar(builder, "left", a, b), right = add_bar(builder, "right", d, c);
  const int half1 = add_bar(builder, "half1", b, middle);
  const int half2 = add_bar(builder, "half2", c, middle);
  const Quat axis = z_to(-Vec3::UnitY());
  const int left_pin = builder.joint("a", JointType::hinge, kWorld, left, {a, axis});
  const int right_pin = builder.joint("d", JointType::hinge, kWorld, right, {d, axis});
  builder.joint("b", JointType::hinge, left, half1, {b, axis});
  builder.joint("c", JointType::hinge, right, half2, {c, axis});
  const int weld = builder.joint("weld", JointType::fixed, half1, half2, {middle, axis});
  mark_loop(builder, weld);
  Sim sim(builder);
  double gap = 0.0, skew = 0.0, level = 0.0, furthest = 0.0;
  sim.run(3.0, kDt, [&] {
    gap = std::max(gap, gap_of(sim, weld));
    skew = std::max(skew, std::abs(sim.q(left_pin) - sim.q(right_pin)));
    level = std::max(level, std::abs(sim.pose(half1).p.z() - sim.pose(half2).p.z()));
    furthest = std::max(furthest, std::abs(sim.q(left_pin)));
  });
  measure("closure [m]", gap, kClosure);
  // In a parallelogram both sides stand at one angle, and the coupler stays level.
  measure("difference of the sides' angles [rad]", skew, 2.0 * kClosure / length);
  measure("coupler off level [m]", level, 2.0 * kClosure);
  // Released at 0.6 rad it swings as far to the other side.
  measure("swing against 1.2 rad [rad]", std::abs(furthest - 1.2), 5e-3);
}

TEST_CASE("loop closed by a planar joint", "[loop]") {
  // A rod on a ball that may only move in a vertical plane is a plane pendulum.
  const double length = 1.0, start = 1.0 * kDegree;
  ModelBuilder builder;
  const Vec3 end = turn(Vec3::UnitY(), -start) * Vec3(0, 0, -length);
  const int rod = add_bar(builder, "rod", Vec3::Zero(), end);
  builder.joint("ball", JointType::ball, kWorld, rod, Pose());
  const int plane =
      builder.joint("plane", JointType::planar, kWorld, rod, {0.5 * end, z_to(Vec3::UnitY())});
  mark_loop(builder, plane);
  Sim sim(builder);
  Crossings crossings;
  double t = 0.0, off = 0.0;
  sim.run(10.0, kDt, [&] {
    crossings.add(t += kDt, sim.pose(rod).p.x());
    off = std::max(off, gap_of(sim, plane));
  });
  measure("closure [m]", off, kClosure);
  // T = 2 pi sqrt(2 L / 3 g) (1 + start^2 / 16).
  const double period =
      2.0 * kPi * std::sqrt(2.0 * length / (3.0 * kGravity)) * (1.0 + start * start / 16.0);
  measure_relative("period", crossings.period(), period, 1e-4);
}

TEST_CASE("loop closed by a screw", "[loop]") {
  // What is free to fall and turn falls as a screw: (I + m k^2) w' = -m g k.
  const double pitch = 0.5, mass = 2.0, moment = 0.02, t = 1.0;
  ModelBuilder builder;
  const int nut = builder.body("nut", mass, Mat3(moment * Mat3::Identity()), Pose());
  builder.joint("guide", JointType::cylindrical, kWorld, nut, Pose());
  const int screw = builder.joint("screw", JointType::screw, kWorld, nut, Pose());
  builder.model.joints[screw].pitch = pitch;
  mark_loop(builder, screw);
  Sim sim(builder);
  double gap = 0.0;
  sim.run(t, kDt, [&] { gap = std::max(gap, gap_of(sim, screw)); });
  const double k = pitch / (2.0 * kPi), a = -mass * kGravity * k / (moment + mass * k * k);
  measure("closure [m]", gap, kClosure);
  measure_relative("speed", sim.u(screw), a * t, 1e-3);
}

}  // namespace
}  // namespace conformance
