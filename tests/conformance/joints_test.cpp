// The motion that each joint type allows under gravity, and the reactions of its two bodies.
#include "support.h"

namespace conformance {
namespace {

// First-order bias of a displacement under constant acceleration, and rounding.
double way_tolerance(double acceleration, double t) {
  return 0.5 * std::abs(acceleration) * kDt * t * (1.0 + 1e-3) + 1e-6;
}

int add_lump(ModelBuilder& builder, const Pose& X_WB, double mass = 2.0, double moment = 0.02) {
  return builder.body("lump", mass, Mat3(moment * Mat3::Identity()), X_WB);
}

TEST_CASE("slider falls along its axis", "[joints]") {
  const double tilt = GENERATE(0.0, 30.0, 75.0) * kDegree, t = 1.0;
  ModelBuilder builder;
  const Pose X_WJ(Vec3(1, 1, 1), turn(Vec3::UnitX(), tilt));
  const int body = add_lump(builder, X_WJ);
  const int slider = builder.joint("slider", JointType::slider, kWorld, body, X_WJ);
  Sim sim(builder);
  sim.run(t);
  const double a = -kGravity * std::cos(tilt);
  measure("speed error [m/s]", std::abs(sim.u(slider) - a * t), 1e-3 * kGravity * t);
  measure("way error [m]", std::abs(sim.q(slider) - 0.5 * a * t * t), way_tolerance(kGravity, t));
  const Vec3 off = sim.pose(body).p - (X_WJ.p + X_WJ.q * Vec3(0, 0, sim.q(slider)));
  measure("off the rail [m]", off.norm(), 1e-4);
}

TEST_CASE("screw falls with its effective inertia", "[joints]") {
  // (I + m k^2) w' = -m g k, k = pitch / 2 pi; several turns, right- and left-handed.
  const double pitch = GENERATE(0.5, -0.5), t = 1.0, mass = 2.0, moment = 0.02;
  ModelBuilder builder;
  const int body = add_lump(builder, Pose(), mass, moment);
  const int screw = builder.joint("screw", JointType::screw, kWorld, body, Pose());
  builder.model.joints[0].pitch = pitch;
  Sim sim(builder);
  sim.run(t);
  const double k = pitch / (2.0 * kPi);
  const double a = -mass * kGravity * k / (moment + mass * k * k);
  measure_relative("speed", sim.u(screw), a * t, 1e-3);
  measure("angle error [rad]", std::abs(sim.q(screw) - 0.5 * a * t * t),
          way_tolerance(a, t) + 1e-3 * std::abs(a));
  measure("travel against the angle [m]", std::abs(sim.pose(body).p.z() - k * sim.q(screw)), 1e-4);
}

TEST_CASE("cylindrical joint falls and turns", "[joints]") {
  const double t = 1.0, spin = 3.0;
  ModelBuilder builder;
  const int body = add_lump(builder, Pose());
  const int joint = builder.joint("joint", JointType::cylindrical, kWorld, body, Pose());
  builder.model.bodies[0].V_WB.angular = Vec3(0, 0, spin);
  builder.model.joints[0].velocity = {spin, 0.0};
  Sim sim(builder);
  sim.run(t);
  measure("angle error [rad]", std::abs(sim.q(joint, 0) - spin * t), 1e-4);
  measure("fall error [m]", std::abs(sim.q(joint, 1) + 0.5 * kGravity * t * t),
          way_tolerance(kGravity, t));
}

TEST_CASE("planar joint falls in its plane", "[joints]") {
  // The plane stands upright: its x points down, its y sideways, it turns about the level z.
  const double t = 1.0, spin = 3.0, drift = 0.7;
  ModelBuilder builder;
  const Quat q_WJ = turn(Vec3::UnitY(), 0.5 * kPi);  // x down, z along x
  const int body = add_lump(builder, {Vec3::Zero(), q_WJ});
  const int joint = builder.joint("joint", JointType::planar, kWorld, body, {Vec3::Zero(), q_WJ});
  builder.model.bodies[0].V_WB = {Vec3(0, drift, 0), Vec3(spin, 0, 0)};
  builder.model.joints[0].velocity = {0.0, drift, spin};
  Sim sim(builder);
  sim.run(t);
  measure("fall error [m]", std::abs(sim.q(joint, 0) - 0.5 * kGravity * t * t),
          way_tolerance(kGravity, t));
  measure("drift error [m]", std::abs(sim.q(joint, 1) - drift * t), 1e-4);
  measure("angle error [rad]", std::abs(sim.q(joint, 2) - spin * t), 1e-4);
  measure("off the plane [m]", std::abs(sim.pose(body).p.x()), 1e-4);
}

TEST_CASE("universal joint turns about both axes at once", "[joints]") {
  // With equal moments the two rates do not disturb each other: the axes stay perpendicular.
  const double t = 1.0, first = 1.2, second = -0.8;
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  add_lump(builder, Pose());
  const int joint = builder.joint("joint", JointType::universal, kWorld, 0, Pose());
  builder.model.bodies[0].V_WB.angular = Vec3(first, second, 0);
  builder.model.joints[0].velocity = {first, second};
  Sim sim(builder);
  sim.run(t);
  // Rates are about axes that turn: a first-order method errs by w^2 dt t in angle.
  measure("first angle error [rad]", std::abs(sim.q(joint, 0) - first * t), first * first * kDt);
  measure("second angle error [rad]", std::abs(sim.q(joint, 1) - second * t), first * first * kDt);
  const Quat expected = turn(Vec3::UnitX(), first * t) * turn(Vec3::UnitY(), second * t);
  measure("orientation error [rad]", angle_between(sim.pose(0).q, expected),
          2.0 * first * first * kDt);
}

TEST_CASE("gimbal turns about all three axes at once", "[joints]") {
  // A body with equal moments turns about a fixed direction at a constant rate. The angles of that
  // rotation pass neither a right angle of the second nor half a turn.
  const double t = 1.0;
  const Vec3 start(0.5, 0.3, -0.4), w(0.5, -0.9, 0.4);
  Joint gimbal;
  gimbal.type = JointType::gimbal;
  const Quat before = joint_pose(gimbal, start.data()).q;
  Vec3 u;
  joint_velocity(gimbal, {Vec3::Zero(), before}, {Vec3::Zero(), w}, start.data(), u.data());
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  add_lump(builder, Pose(Vec3::Zero(), before));
  const int joint = builder.joint("joint", JointType::gimbal, kWorld, 0, Pose());
  builder.model.joints[0].X_CM.q = Quat(1, 0, 0, 0);
  builder.model.bodies[0].V_WB.angular = w;
  builder.model.joints[0].position = {start[0], start[1], start[2]};
  builder.model.joints[0].velocity = {u[0], u[1], u[2]};
  Sim sim(builder);
  sim.run(t);
  const Quat expected = turn(w, w.norm() * t) * before;
  Vec3 q;
  joint_position(gimbal, {Vec3::Zero(), expected}, start.data(), q.data());
  // As above, times the largest rate of an angle over that of the body: 1 / cos of the second.
  const double tolerance = 2.0 * w.squaredNorm() * kDt / std::cos(0.7);
  for (int i = 0; i < 3; ++i)
    measure("angle error [rad]", std::abs(sim.q(joint, i) - q[i]), tolerance);
  measure("orientation error [rad]", angle_between(sim.pose(0).q, expected), tolerance);
}

TEST_CASE("ball joint: torque-free precession", "[joints]") {
  // A symmetric top of moments A, A, C: the body's axis goes round the angular momentum L at
  // |L| / A, and its spin stays.
  const double A = 0.04, C = 0.02, t = 2.0;
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const int body = builder.body("top", 1.0, Mat3(Vec3(A, A, C).asDiagonal()), Pose());
  const int ball = builder.joint("ball", JointType::ball, kWorld, body, Pose());
  const Vec3 w0(0.6, 0.0, 3.0);
  builder.model.bodies[0].V_WB.angular = w0;
  builder.model.joints[0].velocity = {w0.x(), w0.y(), w0.z()};
  Sim sim(builder);
  sim.run(t);
  const Vec3 L(A * w0.x(), A * w0.y(), C * w0.z());
  const Vec3 axis = turn(L, L.norm() / A * t) * Vec3::UnitZ();
  const Vec3 now = sim.pose(body).q * Vec3::UnitZ();
  // First order: the state errs by about w dt of itself per radian turned.
  const double tolerance = w0.norm() * kDt * w0.norm() * t;
  measure("axis direction error [rad]", std::acos(std::min(1.0, axis.dot(now))), tolerance);
  measure_relative("spin about the axis", sim.twist(body).angular.dot(now), w0.z(), 1e-3);
  const Vec3 u(sim.u(ball, 0), sim.u(ball, 1), sim.u(ball, 2));
  measure("joint speeds against the body's [rad/s]", (u - sim.twist(body).angular).norm(), 1e-6);
}

TEST_CASE("fixed joint: two bodies fly as one", "[joints]") {
  const double t = 2.0;
  ModelBuilder builder;
  const Vec3 moments(0.01, 0.02, 0.025), w0(1, 2, 3);
  const int a = builder.body("a", 1.0, Mat3(moments.asDiagonal()), at(0, 0, 0));
  const int b = builder.body("b", 3.0, Mat3(moments.asDiagonal()), at(0.4, 0.1, 0));
  const int joint = builder.joint("weld", JointType::fixed, a, b, at(0.2, 0, 0));
  builder.model.bodies[0].V_WB = {Vec3::Zero(), w0};
  builder.model.bodies[1].V_WB = {w0.cross(Vec3(0.4, 0.1, 0)), w0};
  Sim sim(builder);
  const auto centre = [&] { return Vec3(0.25 * (sim.pose(a).p + 3.0 * sim.pose(b).p)); };
  const Vec3 start = centre(), speed = 0.75 * w0.cross(Vec3(0.4, 0.1, 0));
  double gap = 0.0, tilt = 0.0;
  sim.run(t, kDt, [&] {
    const JointError error = joint_error(
        sim.model().joints[joint], relative_pose(sim.model().joints[0], sim.pose(a), sim.pose(b)));
    gap = std::max(gap, error.distance);
    tilt = std::max(tilt, error.angle);
  });
  measure("gap [m]", gap, 1e-4);
  measure("tilt [rad]", tilt, 1e-4);
  const Vec3 expected = start + speed * t + Vec3(0, 0, -0.5 * kGravity * t * t);
  // First-order bias of the fall, and of the centre's own motion about the frames: w^2 r dt t.
  measure("centre of mass error [m]", (centre() - expected).norm(),
          way_tolerance(kGravity, t) + 0.5 * w0.squaredNorm() * 0.3 * kDt * t);
}

TEST_CASE("free joint is no joint", "[joints]") {
  const double t = 1.0;
  ModelBuilder builder;
  const Pose X_WB(Vec3(1, 2, 3), turn(Vec3(1, 1, 0), 0.5));
  const int body = add_lump(builder, X_WB);
  const int joint = builder.joint("free", JointType::free, kWorld, body, X_WB);
  const Vec3 v0(1, 0.5, 2), w0(0, 0, 2);
  builder.model.bodies[0].V_WB = {v0, w0};
  const Vec3 v_F = X_WB.q.conjugate() * v0, w_F = X_WB.q.conjugate() * w0;
  builder.model.joints[0].velocity = {v_F.x(), v_F.y(), v_F.z(), w_F.x(), w_F.y(), w_F.z()};
  Sim sim(builder);
  sim.run(t);
  const Vec3 moved = v0 * t + Vec3(0, 0, -0.5 * kGravity * t * t);
  measure("way error [m]", (sim.pose(body).p - X_WB.p - moved).norm(), way_tolerance(kGravity, t));
  measure("orientation error [rad]", angle_between(sim.pose(body).q, turn(w0, 2.0 * t) * X_WB.q),
          8.0 * kDt * kDt / 12.0 + 1e-6);
  const Vec3 q(sim.q(joint, 0), sim.q(joint, 1), sim.q(joint, 2));
  measure("coordinates against the pose [m]", (X_WB * q - sim.pose(body).p).norm(), 1e-6);
}

TEST_CASE("hinge between two free bodies: equal and opposite", "[joints]") {
  // A motor between two coaxial wheels in free space: I1 w1 = -I2 w2, relative speed e t
  // (1/I1+1/I2).
  const double I1 = 0.02, I2 = 0.05, e = 0.1, t = 1.0;
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const int one = builder.body("one", 1.0, Mat3(I1 * Mat3::Identity()), at(0, 0, 0));
  const int two = builder.body("two", 2.0, Mat3(I2 * Mat3::Identity()), at(0, 0, 0.2));
  const int hinge = builder.joint("hinge", JointType::hinge, one, two, at(0, 0, 0.1));
  const int motor = builder.motor("motor", hinge, MotorMode::torque);
  Sim sim(builder);
  sim.drive(motor) = constant_effort(e);
  sim.run(t);
  measure_relative("speed of the first", sim.twist(one).angular.z(), -e * t / I1, 1e-3);
  measure_relative("speed of the second", sim.twist(two).angular.z(), e * t / I2, 1e-3);
  measure_relative("relative speed", sim.u(hinge), e * t * (1.0 / I1 + 1.0 / I2), 1e-3);
}

TEST_CASE("joint that starts away from zero", "[joints]") {
  // The coordinate at the start is what the scene says, and counts on from there through turns.
  const double q0 = 5.0, u0 = 2.0, t = 2.0;
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const int body = add_lump(builder, Pose());
  const int hinge = builder.joint("hinge", JointType::hinge, kWorld, body, Pose());
  builder.model.bodies[0].X_WB.q = turn(Vec3::UnitZ(), q0);
  builder.model.bodies[0].V_WB.angular = Vec3(0, 0, u0);
  builder.model.joints[0].position = {q0};
  builder.model.joints[0].velocity = {u0};
  Sim sim(builder);
  measure("start [rad]", std::abs(sim.q(hinge) - q0), 1e-9);
  sim.run(t);
  measure("angle [rad]", std::abs(sim.q(hinge) - q0 - u0 * t), 1e-6);
}

}  // namespace
}  // namespace conformance
