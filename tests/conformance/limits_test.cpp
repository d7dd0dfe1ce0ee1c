// Limits of every joint axis: where they stop, that they hold, and that they let go.
#include "axis_rig.h"

namespace conformance {
namespace {

constexpr double kSpeed = 1.0;
constexpr double kLimit = 0.2;

AxisKind kind_of(JointType type, int axis) {
  for (const AxisKind& kind : axis_kinds()) {
    if (kind.type == type && kind.axis == axis) return kind;
  }
  return {};
}

// Runs into the upper (sign 1) or lower (sign -1) limit, is pushed into it, is pulled off it.
void run_into(const AxisKind& kind, double sign) {
  AxisRig rig(kind);
  (sign > 0 ? rig.axis().upper : rig.axis().lower) = sign * kLimit;
  rig.start_speed(sign * kSpeed);
  const int motor = rig.motor(MotorMode::torque);
  Sim sim(rig.builder);
  double beyond = 0.0;
  const auto watch = [&] { beyond = std::max(beyond, sign * rig.q(sim) - kLimit); };
  const double effort = 10.0 * rig.inertia;
  sim.run(0.5, kDt, watch);
  // The impact is seen at the end of the step it falls into: u dt, and as much for the way back.
  measure("overshoot", beyond, 2.0 * kSpeed * kDt);
  measure("rebound over the speed", std::max(0.0, -sign * rig.u(sim)) / kSpeed, 0.05);
  sim.drive(motor) = constant_effort(sign * effort);
  // It may have drifted off by its rebound: 0.05 m at 10 m/s^2 take 0.1 s back.
  sim.run(1.0, kDt, watch);
  measure("overshoot, pushed", beyond, 2.0 * kSpeed * kDt);
  measure("place under load against the limit", std::abs(sign * rig.q(sim) - kLimit), 1e-3);
  measure("net effort at the limit over the motor's", std::abs(rig.effort(sim)) / effort, 0.01);
  const double before = rig.u(sim);
  sim.drive(motor) = constant_effort(-sign * effort);
  sim.run(0.1);
  // Whatever the limit stores within its 1e-3 may not throw the axis off: 10 * 0.1 = 1 is wanted.
  measure_relative("speed when pulled off", -sign * (rig.u(sim) - before), 1.0, 0.02);
}

void both_sides(JointType type, int axis) {
  for (const double sign : {1.0, -1.0}) run_into(kind_of(type, axis), sign);
}

TEST_CASE("limit: hinge", "[limits]") { both_sides(JointType::hinge, 0); }
TEST_CASE("limit: slider", "[limits]") { both_sides(JointType::slider, 0); }
TEST_CASE("limit: screw", "[limits]") { both_sides(JointType::screw, 0); }
TEST_CASE("limit: cylindrical 0 (angle)", "[limits]") { both_sides(JointType::cylindrical, 0); }
TEST_CASE("limit: cylindrical 1 (travel)", "[limits]") { both_sides(JointType::cylindrical, 1); }
TEST_CASE("limit: universal 0", "[limits]") { both_sides(JointType::universal, 0); }
TEST_CASE("limit: universal 1", "[limits]") { both_sides(JointType::universal, 1); }
TEST_CASE("limit: gimbal 0", "[limits]") { both_sides(JointType::gimbal, 0); }
TEST_CASE("limit: gimbal 1", "[limits]") { both_sides(JointType::gimbal, 1); }
TEST_CASE("limit: gimbal 2", "[limits]") { both_sides(JointType::gimbal, 2); }
TEST_CASE("limit: planar 0 (x)", "[limits]") { both_sides(JointType::planar, 0); }
TEST_CASE("limit: planar 1 (y)", "[limits]") { both_sides(JointType::planar, 1); }
TEST_CASE("limit: planar 2 (angle)", "[limits]") { both_sides(JointType::planar, 2); }

TEST_CASE("limit: a speed source pushes against it with its bound", "[limits]") {
  for (const JointType type : {JointType::hinge, JointType::slider}) {
    AxisRig rig(kind_of(type, 0));
    rig.axis().upper = kLimit;
    const int motor = rig.motor(MotorMode::velocity);
    Sim sim(rig.builder);
    const double bound = 10.0 * rig.inertia;
    sim.drive(motor) = speed_source(kSpeed, bound);
    double beyond = 0.0;
    sim.run(1.0, kDt, [&] { beyond = std::max(beyond, rig.q(sim) - kLimit); });
    measure("overshoot", beyond, 2.0 * kSpeed * kDt);
    measure("place against the limit", std::abs(rig.q(sim) - kLimit), 1e-3);
    measure_relative("effort of the motor", sim.motor_effort(motor), bound, 0.01);
    measure("net effort over the motor's", std::abs(rig.effort(sim)) / bound, 0.01);
    sim.drive(motor) = speed_source(-kSpeed, bound);
    sim.run(0.05);
    // 0.5 within 0.05 s: still moving at its effort limit, and not held back by the joint limit.
    measure_relative("speed when it turns round", rig.u(sim), -0.5, 0.02);
  }
}

TEST_CASE("limit: light fingers held at their stops", "[limits]") {
  // Of 2 mg, as in models of public robots: motor and stop are two rows of a solver for one speed.
  ModelBuilder builder;
  const int palm =
      builder.body("palm", 0.2, Mat3(Vec3(7e-5, 1.4e-4, 1.3e-4).asDiagonal()), at(0, 0, 1));
  constexpr int kFingers = 8;
  for (int i = 0; i < kFingers; ++i) {
    const Vec3 place(0.06 + 0.01 * i, 0.01 * i, 0.99);
    const int finger = builder.body("finger" + std::to_string(i), 2e-6, 1.1e-9 * Mat3::Identity(),
                                    {place + Vec3(0.001, 0.002, 0.001), Quat(1, 0, 0, 0)});
    const int hinge = builder.joint("hinge" + std::to_string(i), JointType::hinge, palm, finger,
                                    {place, z_to(Vec3::UnitX())});
    builder.model.joints[hinge].axes.resize(1);
    builder.model.joints[hinge].axes[0].lower = 0.0;
    builder.model.joints[hinge].axes[0].upper = 1.0;
    builder.motor("motor" + std::to_string(i), hinge, MotorMode::velocity);
  }
  Sim sim(builder);
  for (int i = 0; i < kFingers; ++i) sim.drive(i) = speed_source(0.0, 0.3);
  sim.run(0.2);
  for (int i = 0; i < kFingers; ++i)
    measure("place against the stop [rad]", std::abs(sim.q(i)), 2e-3);
}

TEST_CASE("limit: hinge beyond one turn", "[limits]") {
  // The coordinate is not wrapped: a limit at two and a half turns is one.
  AxisRig rig(kind_of(JointType::hinge, 0));
  const double limit = 5.0 * kPi;
  rig.axis().upper = limit;
  rig.start_speed(6.0);
  Sim sim(rig.builder);
  double furthest = 0.0;
  sim.run(4.0, kDt, [&] { furthest = std::max(furthest, rig.q(sim)); });
  measure("overshoot [rad]", std::abs(furthest - limit), 2.0 * 6.0 * kDt);
}

void stop_at(JointType type, int axis) {
  // Driven at 1 rad/s to stops from 2 to 10 rad: the first step beyond is seen, and 1 ms of it.
  for (const double stop : {2.0, -3.5, 4.0, -7.0, 10.0}) {
    AxisRig rig(kind_of(type, axis));
    rig.axis().lower = -std::abs(stop);
    rig.axis().upper = std::abs(stop);
    const int motor = rig.motor(MotorMode::velocity);
    Sim sim(rig.builder);
    const double sign = stop > 0.0 ? 1.0 : -1.0;
    sim.drive(motor) = speed_source(sign, 10.0 * rig.inertia);
    double beyond = 0.0;
    sim.run(std::abs(stop) + 0.5, kDt,
            [&] { beyond = std::max(beyond, sign * rig.q(sim) - std::abs(stop)); });
    measure("overshoot [rad]", beyond, 2e-3);
    measure("place against the limit [rad]", std::abs(rig.q(sim) - stop), 2e-3);
  }
}

TEST_CASE("limit: hinge, up to three turns apart", "[limits]") { stop_at(JointType::hinge, 0); }
TEST_CASE("limit: cylindrical, up to three turns apart", "[limits]") {
  stop_at(JointType::cylindrical, 0);
}
TEST_CASE("limit: universal, up to three turns apart", "[limits]") {
  stop_at(JointType::universal, 0);
  stop_at(JointType::universal, 1);
}
TEST_CASE("limit: gimbal, up to three turns apart", "[limits]") {
  stop_at(JointType::gimbal, 0);
  stop_at(JointType::gimbal, 2);
}

TEST_CASE("limit: hinge beyond one turn, from a snapshot", "[limits]") {
  AxisRig rig(kind_of(JointType::hinge, 0));
  constexpr double kStop = 3.0 * kPi;
  rig.axis().upper = kStop;
  rig.start_speed(3.0);
  Sim sim(rig.builder);
  sim.run(2.5);
  const SnapshotPtr saved = sim.world().save();
  double furthest = 0.0;
  for (int i = 0; i < 2; ++i) {
    REQUIRE(sim.world().restore(saved));
    sim.forget_state();
    measure("coordinate after the snapshot off [rad]", std::abs(rig.q(sim) - 7.5), 1e-2);
    sim.run(1.0, kDt, [&] { furthest = std::max(furthest, rig.q(sim)); });
    measure("overshoot [rad]", std::abs(furthest - kStop), 2.0 * 3.0 * kDt);
  }
}

TEST_CASE("limit: cone of a ball", "[limits]") {
  AxisRig rig(kind_of(JointType::ball, 0));
  rig.axis().upper = kLimit;
  rig.start_speed(kSpeed);
  Sim sim(rig.builder);
  double beyond = -kLimit;
  sim.run(0.5, kDt, [&] { beyond = std::max(beyond, std::abs(rig.q(sim)) - kLimit); });
  measure("overshoot [rad]", std::abs(beyond), 2.0 * kSpeed * kDt);
  measure("rebound over the speed", std::abs(rig.u(sim)) / kSpeed, 0.05);
}

TEST_CASE("limit: cone of a ball under load, in any direction", "[limits]") {
  // A rod in tilted gravity leans on the cone around its start.
  const double direction = GENERATE(0.0, 50.0, 130.0, 270.0) * kDegree;
  const double cone = 0.5, mass = 1.0, length = 1.0;
  ModelBuilder builder;
  builder.model.physics.gravity = 9.81 * Vec3(std::sin(1.2) * std::cos(direction),
                                              std::sin(1.2) * std::sin(direction), -std::cos(1.2));
  const double moment = mass * length * length / 12.0;
  const int rod = builder.body("rod", mass, Mat3(Vec3(moment, moment, 0.1 * moment).asDiagonal()),
                               at(0, 0, -0.5 * length));
  const int ball = builder.joint("ball", JointType::ball, kWorld, rod, Pose());
  builder.model.joints[0].axes.resize(1);
  builder.model.joints[0].axes[0].upper = cone;
  builder.model.joints[0].axes[0].damping = 1.0;
  Sim sim(builder);
  sim.run(4.0);
  (void)ball;
  const Vec3 along = -(sim.pose(rod).p.normalized());
  measure("lean against the cone [rad]", std::abs(std::acos(along.z()) - cone), 1e-3);
  const double leans_to = std::atan2(sim.pose(rod).p.y(), sim.pose(rod).p.x());
  measure("direction error [rad]", std::abs(std::remainder(leans_to - direction, 2.0 * kPi)), 0.01);
}

TEST_CASE("limit: pendulum that falls into its stop", "[limits]") {
  // A rod released level comes to rest on a stop 30 degrees below, carrying m g d cos 30.
  const double mass = 1.0, length = 1.0, stop = 30.0 * kDegree;
  ModelBuilder builder;
  const double moment = mass * length * length / 12.0;
  const int rod = builder.body("rod", mass, Mat3(Vec3(1e-3, moment, moment).asDiagonal()),
                               at(0.5 * length, 0, 0));
  builder.joint("hinge", JointType::hinge, kWorld, rod, {Vec3::Zero(), z_to(Vec3::UnitY())});
  builder.model.joints[0].axes.resize(1);
  builder.model.joints[0].axes[0].upper = stop;
  Sim sim(builder);
  double furthest = 0.0;
  sim.run(3.0, kDt, [&] { furthest = std::max(furthest, sim.q(0)); });
  const double speed = std::sqrt(3.0 * 9.81 / length * std::sin(stop));
  measure("overshoot [rad]", furthest - stop, 2.0 * speed * kDt);
  measure("angle at rest against the stop [rad]", std::abs(sim.q(0) - stop), 1e-3);
  measure_relative("effort of the stop [N m]", sim.effort(0),
                   -mass * 9.81 * 0.5 * length * std::cos(stop), 0.01);
}

TEST_CASE("limit: pendulum with a range of 300 degrees", "[limits]") {
  // A rod that stands 30 degrees off the middle of its range falls to the stop on that side, 30
  // degrees before it would hang. One of the stops is beyond 180 degrees.
  const double mass = 1.0, length = 1.0, range = 300.0 * kDegree;
  const double start = GENERATE(120.0, 180.0) * kDegree;
  const double stop = start > 0.5 * range ? range : 0.0;
  const auto below_level = [](double q) { return q + 120.0 * kDegree; };
  const auto place = [&](double q) {
    const Quat turn(Eigen::AngleAxisd(below_level(q), Vec3::UnitY()));
    return Pose{turn * Vec3(0.5 * length, 0, 0), turn};
  };
  ModelBuilder builder;
  const double moment = mass * length * length / 12.0;
  const int rod =
      builder.body("rod", mass, Mat3(Vec3(1e-3, moment, moment).asDiagonal()), place(0.0));
  builder.joint("hinge", JointType::hinge, kWorld, rod, {Vec3::Zero(), z_to(Vec3::UnitY())});
  Joint& hinge = builder.model.joints[0];
  hinge.axes.resize(1);
  hinge.axes[0].lower = 0.0;
  hinge.axes[0].upper = range;
  hinge.position = {start};
  builder.model.bodies[static_cast<std::size_t>(rod)].X_WB = place(start);
  Sim sim(builder);
  double overshoot = 0.0;
  sim.run(3.0, kDt, [&] { overshoot = std::max({overshoot, -sim.q(0), sim.q(0) - range}); });
  // m g (fall) = (m l² / 3) w² / 2, and it falls from 60 degrees above level to 60 below.
  const double speed = std::sqrt(3.0 * 9.81 / length * 2.0 * std::sin(60.0 * kDegree));
  measure("overshoot [rad]", overshoot, 2.0 * speed * kDt);
  measure("angle at rest against the stop [rad]", std::abs(sim.q(0) - stop), 1e-3);
  measure_relative("effort of the stop [N m]", sim.effort(0),
                   -mass * 9.81 * 0.5 * length * std::cos(below_level(stop)), 0.01);
}

}  // namespace
}  // namespace conformance
