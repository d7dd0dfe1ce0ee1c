#include "cogrsim/model/joint_kinematics.h"

#include <catch2/catch.hpp>

#include "cogrsim/core/random.h"
#include "cogrsim/model/builder.h"

using namespace cogrsim;

namespace {

constexpr double kPi = 3.14159265358979323846;

Joint make_joint(JointType type) {
  Joint joint;
  joint.type = type;
  joint.pitch = 0.02;
  return joint;
}

JointType any_type() {
  return GENERATE(JointType::fixed, JointType::hinge, JointType::slider, JointType::screw,
                  JointType::cylindrical, JointType::universal, JointType::planar, JointType::ball,
                  JointType::free, JointType::gimbal);
}

/// Index of the quaternion among the coordinates; -1: none.
int quaternion_at(JointType type) {
  return type == JointType::ball ? 0 : type == JointType::free ? 3 : -1;
}

Vec3 random_vector(RandomStream& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

Quat random_rotation(RandomStream& random) {
  return Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
}

std::vector<double> random_position(JointType type, RandomStream& random, double size) {
  std::vector<double> q(static_cast<std::size_t>(position_count(type)));
  for (double& x : q) x = random.uniform(-size, size);
  if (const int at = quaternion_at(type); at >= 0) {
    const Quat r = random_rotation(random);
    const double parts[4] = {r.w(), r.x(), r.y(), r.z()};
    for (int i = 0; i < 4; ++i) q[at + i] = parts[i];
  }
  return q;
}

std::vector<double> random_velocity(JointType type, RandomStream& random) {
  std::vector<double> u(static_cast<std::size_t>(speed_count(type)));
  for (double& x : u) x = random.uniform(-3, 3);
  return u;
}

Pose random_pose(RandomStream& random) {
  return {random_vector(random, 2), random_rotation(random)};
}

/// Moves a pose by a constant twist in fixed axes for a short time h [s].
Pose moved(const Pose& X, const Twist& V, double h) {
  const double angle = V.angular.norm() * h;
  Quat turn(1, 0, 0, 0);
  if (angle != 0.0) turn = Eigen::AngleAxisd(angle, V.angular.normalized());
  return {X.p + h * V.linear, turn * X.q};
}

/// Rotation vector from A to B in fixed axes [rad]; small angles.
Vec3 turn_between(const Quat& a, const Quat& b) {
  Quat d = b * a.conjugate();
  if (d.w() < 0) d.coeffs() = -d.coeffs();
  return 2 * d.vec();
}

}  // namespace

TEST_CASE("only rotational axes have an angular speed", "[joints]") {
  const Joint joint = make_joint(any_type());
  RandomStream random(7, "turning");
  const std::vector<double> q = random_position(joint.type, random, 1.0);
  for (int i = 0; i < speed_count(joint.type); ++i) {
    std::vector<double> u(static_cast<std::size_t>(speed_count(joint.type)), 0.0);
    u[i] = 1.0;
    CAPTURE(to_string(joint.type), i);
    const double spin = joint_twist(joint, q.data(), u.data()).angular.norm();
    CHECK(spin == Approx(axis_turns(joint.type, i) ? 1.0 : 0.0).margin(1e-12));
  }
}

TEST_CASE("joint coordinates are recovered from the pose, full turns included", "[joint]") {
  const Joint joint = make_joint(any_type());
  CAPTURE(to_string(joint.type));
  RandomStream random(11, to_string(joint.type));
  for (int i = 0; i < 200; ++i) {
    const auto q = random_position(joint.type, random, 30.0);  // several turns
    auto previous = q;
    for (double& x : previous) x += random.uniform(-0.4, 0.4);
    auto back = q;
    joint_position(joint, joint_pose(joint, q.data()), previous.data(), back.data());
    for (std::size_t k = 0; k < q.size(); ++k) REQUIRE(back[k] == Approx(q[k]).margin(1e-12));
    const JointError error = joint_error(joint, joint_pose(joint, q.data()));
    REQUIRE(error.distance < 1e-12);
    REQUIRE(error.angle < 1e-12);
  }
}

TEST_CASE("without a past, angles lie within half a turn and quaternions have w >= 0", "[joint]") {
  RandomStream random(5, "no past");
  const Joint hinge = make_joint(JointType::hinge), ball = make_joint(JointType::ball);
  for (double turned : {-7.0, -kPi, 0.0, kPi, 3 * kPi, 100.0}) {
    double q = 0;
    joint_position(hinge, joint_pose(hinge, &turned), nullptr, &q);
    CHECK((q > -kPi && q <= kPi));
    CHECK(std::remainder(q - turned, 2 * kPi) == Approx(0).margin(1e-12));
  }
  for (int i = 0; i < 50; ++i) {
    double q[4];
    joint_position(ball, random_pose(random), nullptr, q);
    CHECK(q[0] >= 0.0);
  }
}

TEST_CASE("the rate of the twist is its difference along the motion", "[joint]") {
  const Joint joint = make_joint(any_type());
  CAPTURE(to_string(joint.type));
  RandomStream random(17, to_string(joint.type));
  for (int i = 0; i < 50; ++i) {
    const auto q = random_position(joint.type, random, 1.0);
    const auto u = random_velocity(joint.type, random);
    const Pose X = joint_pose(joint, q.data());
    const Twist V = joint_twist(joint, q.data(), u.data());
    const double h = 1e-5;
    const auto twist_after = [&](double time) {
      auto moved_q = q;
      joint_position(joint, moved(X, V, time), q.data(), moved_q.data());
      return joint_twist(joint, moved_q.data(), u.data());
    };
    const Twist before = twist_after(-h), after = twist_after(h);
    const Twist rate = joint_twist_rate(joint, q.data(), u.data());
    // Cut off at h^2 of terms below 1e3, rounding 1e-16 / h. Coordinates of a gimbal amplify both by
    // 1 / cos(1).
    REQUIRE(((after.angular - before.angular) / (2 * h) - rate.angular).norm() < 1e-6);
    REQUIRE(((after.linear - before.linear) / (2 * h) - rate.linear).norm() < 1e-6);
  }
}

TEST_CASE("a universal joint turns about F's x, then about M's y", "[joint]") {
  const Joint joint = make_joint(JointType::universal);
  const double q[2] = {kPi / 2, 0.3};
  const Pose X_FM = joint_pose(joint, q);
  // After a quarter turn about x, M's y axis is F's z axis whatever the second angle is.
  CHECK((X_FM.q * Vec3::UnitY() - Vec3::UnitZ()).norm() < 1e-14);
  CHECK((X_FM.q * Vec3::UnitX() - Vec3(std::cos(0.3), std::sin(0.3), 0)).norm() < 1e-14);
}

TEST_CASE("a gimbal turns about x, the turned y and the twice turned z", "[joint]") {
  const Joint joint = make_joint(JointType::gimbal);
  const double q[3] = {0.4, -0.7, 1.1};
  Mat3 x, y, z;
  x << 1, 0, 0, 0, std::cos(0.4), -std::sin(0.4), 0, std::sin(0.4), std::cos(0.4);
  y << std::cos(0.7), 0, -std::sin(0.7), 0, 1, 0, std::sin(0.7), 0, std::cos(0.7);
  z << std::cos(1.1), -std::sin(1.1), 0, std::sin(1.1), std::cos(1.1), 0, 0, 0, 1;
  CHECK((joint_pose(joint, q).q.toRotationMatrix() - x * y * z).norm() < 1e-14);
  // Without a past the second angle is within a quarter turn.
  const double beyond[3] = {0.4, 2.0, 1.1};
  double found[3];
  joint_position(joint, joint_pose(joint, beyond), nullptr, found);
  CHECK(found[1] == Approx(kPi - 2.0));
  CHECK(found[0] == Approx(0.4 - kPi));
  CHECK(found[2] == Approx(1.1 - kPi));
  // Where it is singular, the first angle is the previous one.
  const double up[3] = {0.4, 0.5 * kPi, 0.3}, before[3] = {0.2, 1.5, 0.5};
  joint_position(joint, joint_pose(joint, up), before, found);
  CHECK(found[0] == 0.2);
  CHECK(found[2] == Approx(0.5));
}

TEST_CASE("a screw advances by its pitch in a turn", "[joint]") {
  const Joint joint = make_joint(JointType::screw);
  const double turn = 2 * kPi;
  CHECK(joint_pose(joint, &turn).p.z() == Approx(0.02));
}

TEST_CASE("twists are the time derivatives of poses", "[joint]") {
  const Joint joint = make_joint(any_type());
  CAPTURE(to_string(joint.type));
  RandomStream random(17, to_string(joint.type));
  for (int i = 0; i < 50; ++i) {
    const auto q = random_position(joint.type, random, 2.0);
    const auto u = random_velocity(joint.type, random);
    const Pose X_FM = joint_pose(joint, q.data());
    const Twist V_FM = joint_twist(joint, q.data(), u.data());

    // Coordinates at t +- h. Plain ones grow by u h; quaternions follow their angular velocity.
    const double h = 1e-5;
    const int at = quaternion_at(joint.type);
    const auto position_at = [&](double t) {
      auto next = q;
      if (at < 0) {
        for (std::size_t k = 0; k < q.size(); ++k) next[k] += t * u[k];
        return next;
      }
      const std::size_t first = static_cast<std::size_t>(at);
      for (std::size_t k = 0; k < first; ++k) next[k] += t * u[k];
      const Vec3 w(u[first], u[first + 1], u[first + 2]);
      const Quat turned = Quat(Eigen::AngleAxisd(t * w.norm(), w.normalized())) * X_FM.q;
      next[first] = turned.w();
      for (std::size_t k = 0; k < 3; ++k) next[first + 1 + k] = turned.vec()[static_cast<int>(k)];
      return next;
    };
    const Pose before = joint_pose(joint, position_at(-h).data());
    const Pose after = joint_pose(joint, position_at(h).data());
    // Central differences err by h^2/6 times third derivatives (below 100) and rounding 1e-16/h.
    REQUIRE(((after.p - before.p) / (2 * h) - V_FM.linear).norm() < 1e-8);
    REQUIRE((turn_between(before.q, after.q) / (2 * h) - V_FM.angular).norm() < 1e-8);

    auto back = u;
    joint_velocity(joint, X_FM, V_FM, q.data(), back.data());
    for (std::size_t k = 0; k < u.size(); ++k) REQUIRE(back[k] == Approx(u[k]).margin(1e-12));
  }
}

TEST_CASE("a pose that a joint does not allow is an error, not a coordinate", "[joint]") {
  const double off = 0.01, tilt = 0.02;
  Pose X_FM(Vec3(off, 0, 0), Quat(Eigen::AngleAxisd(0.7, Vec3::UnitZ())));
  X_FM.q = X_FM.q * Quat(Eigen::AngleAxisd(tilt, Vec3::UnitX()));
  const Joint hinge = make_joint(JointType::hinge);
  double q = 0;
  joint_position(hinge, X_FM, nullptr, &q);
  CHECK(q == Approx(0.7));
  CHECK(joint_error(hinge, X_FM).distance == Approx(off));
  CHECK(joint_error(hinge, X_FM).angle == Approx(tilt));
  CHECK(joint_error(make_joint(JointType::ball), X_FM).angle == Approx(0).margin(1e-12));
  CHECK(joint_error(make_joint(JointType::free), X_FM).distance == Approx(0).margin(1e-12));
  CHECK(joint_error(make_joint(JointType::fixed), X_FM).distance == Approx(off));
}

TEST_CASE("relative pose and twist are those of the frames on the bodies", "[joint]") {
  RandomStream random(23, "relative");
  Joint joint = make_joint(JointType::free);
  joint.X_PF = random_pose(random);
  joint.X_CM = random_pose(random);
  const Pose X_WP = random_pose(random), X_WC = random_pose(random);
  const Twist V_WP{random_vector(random, 2), random_vector(random, 2)};
  const Twist V_WC{random_vector(random, 2), random_vector(random, 2)};

  const Pose X_FM = relative_pose(joint, X_WP, X_WC);
  const Pose M = X_WP * joint.X_PF * X_FM, M_by_child = X_WC * joint.X_CM;
  CHECK((M.p - M_by_child.p).norm() < 1e-12);
  CHECK(M.q.angularDistance(M_by_child.q) < 1e-7);

  const double h = 1e-5;
  const Pose before = relative_pose(joint, moved(X_WP, V_WP, -h), moved(X_WC, V_WC, -h));
  const Pose after = relative_pose(joint, moved(X_WP, V_WP, h), moved(X_WC, V_WC, h));
  const Twist V_FM = relative_twist(joint, X_WP, V_WP, X_WC, V_WC);
  CHECK(((after.p - before.p) / (2 * h) - V_FM.linear).norm() < 1e-8);
  CHECK((turn_between(before.q, after.q) / (2 * h) - V_FM.angular).norm() < 1e-8);
}
