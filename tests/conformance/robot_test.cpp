// A two-wheel robot against ideal rolling.
#include "scenes.h"

namespace conformance {
namespace {

struct Drivepath {
  double speed = 0.0;  // of the middle of the axle, along the arc [m/s]
  double yaw_rate = 0.0;
  double radius = 0.0;  // signed, left positive; distance over turn
};

// Drives for 4 s with constant wheel speeds and measures after the first second.
Drivepath drive(double left, double right, double heading) {
  ModelBuilder builder;
  const int floor = builder.material("floor", 0.9);
  builder.plane("floor", Pose(), floor);
  const Pose X_WR(Vec3(0.4, -0.7, 0), turn(Vec3::UnitZ(), heading));
  const TwoWheeler robot = add_two_wheeler(builder, "robot", X_WR);
  Sim sim(builder);
  sim.drives[0] = speed_source(left);
  sim.drives[1] = speed_source(right);
  sim.run(1.0);
  const auto middle = [&] {
    return Vec3(0.5 * (sim.pose(robot.left).p + sim.pose(robot.right).p));
  };
  const auto yaw = [&] {
    const Vec3 forwards = sim.pose(robot.chassis).q * Vec3::UnitX();
    return std::atan2(forwards.y(), forwards.x());
  };
  Vec3 last = middle();
  double last_yaw = yaw(), distance = 0.0, turned = 0.0, lowest = 1.0, highest = 0.0;
  const double seconds = 3.0;
  sim.run(seconds, kDt, [&] {
    const Vec3 now = middle();
    const Vec3 forwards = sim.pose(robot.chassis).q * Vec3::UnitX();
    distance += (now - last).norm() * ((now - last).dot(forwards) < 0.0 ? -1.0 : 1.0);
    turned += std::remainder(yaw() - last_yaw, 2.0 * kPi);
    last = now;
    last_yaw = yaw();
    lowest = std::min(lowest, now.z());
    highest = std::max(highest, now.z());
  });
  measure("wheel centres off the radius, up or down [m]",
          std::max(std::abs(lowest - robot.radius), std::abs(highest - robot.radius)), 1e-3);
  return {distance / seconds, turned / seconds, distance / turned};
}

void check_arc(double left, double right, double heading) {
  const TwoWheeler ideal;
  const Drivepath path = drive(left, right, heading);
  const double speed = 0.5 * ideal.radius * (left + right);
  const double yaw_rate = ideal.radius * (right - left) / ideal.track;
  measure_relative("speed", path.speed, speed, 0.01);
  measure_relative("yaw rate", path.yaw_rate, yaw_rate, 0.01);
  measure_relative("arc radius", path.radius, speed / yaw_rate, 0.01);
}

TEST_CASE("two-wheel robot: arc to the left", "[robot]") {
  const double heading = GENERATE(0.0, 37.0, 90.0, 215.0) * kDegree;
  check_arc(4.0, 8.0, heading);
}

TEST_CASE("two-wheel robot: arc to the right", "[robot]") {
  const double heading = GENERATE(0.0, 37.0, 90.0, 215.0) * kDegree;
  check_arc(8.0, 4.0, heading);
}

TEST_CASE("two-wheel robot: tight arc with one wheel standing", "[robot]") {
  check_arc(0.0, 6.0, 0.5);
}

TEST_CASE("two-wheel robot: backwards", "[robot]") { check_arc(-8.0, -5.0, 1.0); }

TEST_CASE("two-wheel robot: straight on", "[robot]") {
  const TwoWheeler ideal;
  const Drivepath path = drive(6.0, 6.0, 0.5);
  measure_relative("speed", path.speed, 6.0 * ideal.radius, 0.01);
  // Less than a degree of turning per metre.
  measure("turn per way [rad/m]", std::abs(path.yaw_rate / path.speed), 0.01);
}

TEST_CASE("two-wheel robot: turns on the spot", "[robot]") {
  const TwoWheeler ideal;
  const Drivepath path = drive(-5.0, 5.0, 0.5);
  measure_relative("yaw rate", path.yaw_rate, 10.0 * ideal.radius / ideal.track, 0.01);
  measure("speed over the wheels'", std::abs(path.speed) / (5.0 * ideal.radius), 0.01);
}

TEST_CASE("two-wheel robot: stands still while it is not driven", "[robot]") {
  ModelBuilder builder;
  builder.plane("floor");
  const TwoWheeler robot = add_two_wheeler(builder, "robot", Pose());
  Sim sim(builder);
  sim.drives[0] = sim.drives[1] = speed_source(0.0, 0.6);
  const Vec3 start = sim.pose(robot.chassis).p;
  sim.run(3.0);
  measure("creep in 3 s [m]", (sim.pose(robot.chassis).p - start).norm(), 1e-3);
}

}  // namespace
}  // namespace conformance
