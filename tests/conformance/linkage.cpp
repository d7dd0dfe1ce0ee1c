#include "linkage.h"

#include <algorithm>

namespace conformance {
namespace {

constexpr double kGround = 0.8, kCrank = 0.25, kCoupler = 0.7, kRocker = 0.55;  // Grashof

}  // namespace

Vec3 point_b(double crank_angle) {
  return kCrank * Vec3(std::cos(crank_angle), 0, std::sin(crank_angle));
}

// The triangle B C D, C on its upper side.
Vec3 point_c(double crank_angle) {
  const Vec3 b = point_b(crank_angle), d(kGround, 0, 0);
  const Vec3 along = d - b;
  const double distance = along.norm();
  const double x =
      (distance * distance + kCoupler * kCoupler - kRocker * kRocker) / (2.0 * distance);
  const Vec3 up = Vec3(-along.z(), 0, along.x()) / distance;
  return b + along * (x / distance) + up * std::sqrt(kCoupler * kCoupler - x * x);
}

double rocker_for(double crank_angle) {
  const Vec3 c = point_c(crank_angle);
  return std::atan2(c.z(), c.x() - kGround);
}

FourBar four_bar(bool motor, JointType closing) {
  FourBar bar;
  bar.crank_angle = 120.0 * kDegree;
  const Vec3 a(0, 0, 0), b = point_b(bar.crank_angle), c = point_c(bar.crank_angle);
  const Vec3 d(kGround, 0, 0);
  bar.rocker_angle = rocker_for(bar.crank_angle);
  bar.crank = add_bar(bar.builder, "crank", a, b);
  bar.coupler = add_bar(bar.builder, "coupler", b, c);
  bar.rocker = add_bar(bar.builder, "rocker", d, c);
  const Quat axis = z_to(-Vec3::UnitY());  // turns x towards z
  const JointType hinge = JointType::hinge;
  bar.drive = bar.builder.joint("drive", hinge, kWorld, bar.crank, {a, axis});
  bar.crank_pin = bar.builder.joint("crank_pin", hinge, bar.crank, bar.coupler, {b, axis});
  bar.rocker_pin = bar.builder.joint("rocker_pin", hinge, kWorld, bar.rocker, {d, axis});
  // A universal joint turns about its x first.
  const Quat closing_axis = closing == JointType::universal ? turn(Vec3::UnitZ(), 0.5 * kPi) : axis;
  bar.loop = bar.builder.joint("loop", closing, bar.coupler, bar.rocker, {c, closing_axis});
  bar.builder.model.joints[bar.loop].closes_loop = true;
  if (motor) bar.builder.motor("motor", bar.drive, MotorMode::velocity);
  return bar;
}

int add_bar(ModelBuilder& builder, const std::string& name, const Vec3& from, const Vec3& to) {
  const double length = (to - from).norm(), mass = length;
  const Quat q = Quat(Eigen::Quaterniond::FromTwoVectors(Vec3::UnitX(), to - from));
  const double across = mass * length * length / 12.0;
  return builder.body(name, mass, Mat3(Vec3(1e-4, across, across).asDiagonal()),
                      {0.5 * (from + to), q});
}

double gap_of(Sim& sim, int joint) {
  const Joint& j = sim.model().joints[joint];
  const Pose parent = j.parent == kWorld ? Pose() : sim.pose(j.parent);
  return joint_error(j, relative_pose(j, parent, sim.pose(j.child))).distance;
}

Driven run_driven(double seconds, JointType closing) {
  FourBar bar = four_bar(true, closing);
  Sim sim(bar.builder);
  const double rate = 2.0 * kPi;
  sim.drives[0] = speed_source(rate);
  Driven worst;
  double t = 0.0;
  sim.run(seconds, kDt, [&] {
    t += kDt;
    worst.gap = std::max(worst.gap, gap_of(sim, bar.loop));
    const double expected = rocker_for(bar.crank_angle + sim.q(bar.drive));
    const double now = bar.rocker_angle + sim.q(bar.rocker_pin);
    worst.rocker_error =
        std::max(worst.rocker_error, std::abs(std::remainder(now - expected, 2.0 * kPi)));
    worst.crank_error = std::max(worst.crank_error, std::abs(sim.q(bar.drive) - rate * t));
  });
  return worst;
}

}  // namespace conformance
