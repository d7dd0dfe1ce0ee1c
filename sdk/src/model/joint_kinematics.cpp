#include "cogrsim/model/joint_kinematics.h"

#include <array>
#include <cmath>

#include "cogrsim/core/constants.h"

namespace cogrsim {
namespace {

Quat about_x(double angle) { return {std::cos(angle / 2), std::sin(angle / 2), 0, 0}; }
Quat about_y(double angle) { return {std::cos(angle / 2), 0, std::sin(angle / 2), 0}; }
Quat about_z(double angle) { return {std::cos(angle / 2), 0, 0, std::sin(angle / 2)}; }

Quat quaternion_at(const double* q) { return Quat(q[0], q[1], q[2], q[3]).normalized(); }

/// Adds full turns to `angle` so that it is within pi of `previous`, or of 0.
double near_previous(double angle, const double* previous) {
  if (previous != nullptr) {
    return angle + 2 * kPi * std::round((*previous - angle) / (2 * kPi));
  }
  angle = std::remainder(angle, 2 * kPi);
  return angle <= -kPi ? kPi : angle;
}

// The rotation about one axis nearest to q (smallest remaining angle) has the same ratio of that
// axis' vector part to the scalar part: q = swing * twist.
double angle_about(double axis_part, double scalar_part) {
  return 2 * std::atan2(axis_part, scalar_part);
}

/// The angles of a gimbal, that of the second within a quarter turn.
std::array<double, 3> gimbal_angles(const Quat& q_FM, const double* previous) {
  constexpr double kSingular = 1e-9;  // cosine of the second angle: only first +- third is defined
  const Vec3 z_M = q_FM * Vec3::UnitZ();
  const double cosine = std::hypot(z_M.y(), z_M.z());
  double first = previous != nullptr ? previous[0] : 0.0;
  if (cosine > kSingular) first = std::atan2(-z_M.y(), z_M.z());
  const double second = std::atan2(z_M.x(), cosine);
  const Quat rest = (about_x(first) * about_y(second)).conjugate() * q_FM;
  return {first, second, angle_about(rest.z(), rest.w())};
}

void put_quaternion(const Quat& value, const double* previous, double* q) {
  Quat unit = value.normalized();
  // q and -q are the same orientation: keep the sign of the previous one.
  const double side = previous == nullptr
                          ? unit.w()
                          : unit.dot(Quat(previous[0], previous[1], previous[2], previous[3]));
  if (side < 0) unit.coeffs() = -unit.coeffs();
  q[0] = unit.w();
  q[1] = unit.x();
  q[2] = unit.y();
  q[3] = unit.z();
}

}  // namespace

bool axis_turns(JointType type, int i) {
  switch (type) {
    case JointType::slider:
      return false;
    case JointType::cylindrical:
      return i == 0;
    case JointType::planar:
      return i == 2;
    case JointType::free:
      return i >= 3;
    default:
      return true;
  }
}

Vec3 axis_direction(JointType type, int i) {
  const bool along_z = type == JointType::hinge || type == JointType::slider ||
                       type == JointType::screw || type == JointType::cylindrical;
  return along_z ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::Unit(i % 3));
}

Pose joint_pose(const Joint& joint, const double* q) {
  Pose X_FM;
  switch (joint.type) {
    case JointType::fixed:
      break;
    case JointType::hinge:
      X_FM.q = about_z(q[0]);
      break;
    case JointType::slider:
      X_FM.p.z() = q[0];
      break;
    case JointType::screw:
      X_FM.q = about_z(q[0]);
      X_FM.p.z() = joint.pitch * q[0] / (2 * kPi);
      break;
    case JointType::cylindrical:
      X_FM.q = about_z(q[0]);
      X_FM.p.z() = q[1];
      break;
    case JointType::universal:
      X_FM.q = about_x(q[0]) * about_y(q[1]);
      break;
    case JointType::gimbal:
      X_FM.q = about_x(q[0]) * about_y(q[1]) * about_z(q[2]);
      break;
    case JointType::planar:
      X_FM.p = Vec3(q[0], q[1], 0);
      X_FM.q = about_z(q[2]);
      break;
    case JointType::ball:
      X_FM.q = quaternion_at(q);
      break;
    case JointType::free:
      X_FM.p = Vec3(q[0], q[1], q[2]);
      X_FM.q = quaternion_at(q + 3);
      break;
  }
  return X_FM;
}

Twist joint_twist(const Joint& joint, const double* q, const double* u) {
  Twist V_FM;
  switch (joint.type) {
    case JointType::fixed:
      break;
    case JointType::hinge:
      V_FM.angular.z() = u[0];
      break;
    case JointType::slider:
      V_FM.linear.z() = u[0];
      break;
    case JointType::screw:
      V_FM.angular.z() = u[0];
      V_FM.linear.z() = joint.pitch * u[0] / (2 * kPi);
      break;
    case JointType::cylindrical:
      V_FM.angular.z() = u[0];
      V_FM.linear.z() = u[1];
      break;
    case JointType::universal:
      V_FM.angular = Vec3(u[0], u[1] * std::cos(q[0]), u[1] * std::sin(q[0]));
      break;
    case JointType::gimbal:
      V_FM.angular = Vec3(u[0], 0, 0) +
                     about_x(q[0]) * Vec3(u[2] * std::sin(q[1]), u[1], u[2] * std::cos(q[1]));
      break;
    case JointType::planar:
      V_FM.linear = Vec3(u[0], u[1], 0);
      V_FM.angular.z() = u[2];
      break;
    case JointType::ball:
      V_FM.angular = Vec3(u[0], u[1], u[2]);
      break;
    case JointType::free:
      V_FM.linear = Vec3(u[0], u[1], u[2]);
      V_FM.angular = Vec3(u[3], u[4], u[5]);
      break;
  }
  return V_FM;
}

Twist joint_twist_rate(const Joint& joint, const double* q, const double* u) {
  Twist out;
  const bool gimbal = joint.type == JointType::gimbal;
  if (gimbal || joint.type == JointType::universal)
    out.angular = u[0] * u[1] * Vec3(0.0, -std::sin(q[0]), std::cos(q[0]));
  if (gimbal) {
    const double s = std::sin(q[1]), c = std::cos(q[1]);
    out.angular += u[2] * u[1] * Vec3(c, s * std::sin(q[0]), -s * std::cos(q[0]));
    out.angular -= u[2] * u[0] * c * Vec3(0.0, std::cos(q[0]), std::sin(q[0]));
  }
  return out;
}

void joint_position(const Joint& joint, const Pose& X_FM, const double* previous, double* q) {
  const auto before = [previous](int i) { return previous == nullptr ? nullptr : previous + i; };
  const double turn_z = angle_about(X_FM.q.z(), X_FM.q.w());
  switch (joint.type) {
    case JointType::fixed:
      break;
    case JointType::hinge:
    case JointType::screw:  // the angle is the coordinate; the travel follows from it
      q[0] = near_previous(turn_z, before(0));
      break;
    case JointType::slider:
      q[0] = X_FM.p.z();
      break;
    case JointType::cylindrical:
      q[0] = near_previous(turn_z, before(0));
      q[1] = X_FM.p.z();
      break;
    case JointType::universal: {
      // The y axis of M is (0, cos q0, sin q0) in F; the remaining rotation is about y.
      const Vec3 y_M = X_FM.q * Vec3::UnitY();
      const double first = std::atan2(y_M.z(), y_M.y());
      const Quat rest = about_x(first).conjugate() * X_FM.q;
      q[0] = near_previous(first, before(0));
      q[1] = near_previous(angle_about(rest.y(), rest.w()), before(1));
      break;
    }
    case JointType::gimbal: {
      std::array<double, 3> angles = gimbal_angles(X_FM.q, previous);
      if (previous != nullptr) {
        // The same orientation; the one nearer to the previous.
        const std::array<double, 3> other = {angles[0] + kPi, kPi - angles[1], angles[2] + kPi};
        const auto far = [&](const std::array<double, 3>& from) {
          double sum = 0.0;
          for (std::size_t i = 0; i < 3; ++i)
            sum += std::abs(std::remainder(from[i] - previous[i], 2 * kPi));
          return sum;
        };
        if (far(other) < far(angles)) angles = other;
      }
      for (int i = 0; i < 3; ++i) q[i] = near_previous(angles[i], before(i));
      break;
    }
    case JointType::planar:
      q[0] = X_FM.p.x();
      q[1] = X_FM.p.y();
      q[2] = near_previous(turn_z, before(2));
      break;
    case JointType::ball:
      put_quaternion(X_FM.q, before(0), q);
      break;
    case JointType::free:
      for (int i = 0; i < 3; ++i) q[i] = X_FM.p[i];
      put_quaternion(X_FM.q, before(3), q + 3);
      break;
  }
}

void joint_velocity(const Joint& joint, const Pose& X_FM, const Twist& V_FM, const double* q,
                    double* u) {
  (void)X_FM;  // the speeds of all joint types depend on q only
  const Vec3& v = V_FM.linear;
  const Vec3& w = V_FM.angular;
  switch (joint.type) {
    case JointType::fixed:
      break;
    case JointType::hinge:
    case JointType::screw:
      u[0] = w.z();
      break;
    case JointType::slider:
      u[0] = v.z();
      break;
    case JointType::cylindrical:
      u[0] = w.z();
      u[1] = v.z();
      break;
    case JointType::universal:
      // The two axes are perpendicular for every q, so projections give both speeds.
      u[0] = w.x();
      u[1] = w.y() * std::cos(q[0]) + w.z() * std::sin(q[0]);
      break;
    case JointType::gimbal: {
      // In the axes that the first angle has turned, w = (u0 + u2 sin q1, u1, u2 cos q1).
      const Vec3 turned = about_x(q[0]).conjugate() * w;
      const double c = std::cos(q[1]);
      u[2] = c != 0.0 ? turned.z() / c : 0.0;
      u[1] = turned.y();
      u[0] = turned.x() - u[2] * std::sin(q[1]);
      break;
    }
    case JointType::planar:
      u[0] = v.x();
      u[1] = v.y();
      u[2] = w.z();
      break;
    case JointType::ball:
      for (int i = 0; i < 3; ++i) u[i] = w[i];
      break;
    case JointType::free:
      for (int i = 0; i < 3; ++i) {
        u[i] = v[i];
        u[3 + i] = w[i];
      }
      break;
  }
}

JointError joint_error(const Joint& joint, const Pose& X_FM) {
  std::array<double, 7> q{}, near{};
  const double* previous = nullptr;
  if (joint.type == JointType::screw && joint.pitch != 0.0) {
    // The orientation does not determine the number of turns, but the travel does.
    near[0] = X_FM.p.z() * 2 * kPi / joint.pitch;
    previous = near.data();
  }
  joint_position(joint, X_FM, previous, q.data());
  const Pose left = joint_pose(joint, q.data()).inverse() * X_FM;
  return {left.p.norm(), 2 * std::atan2(left.q.vec().norm(), std::abs(left.q.w()))};
}

Pose relative_pose(const Joint& joint, const Pose& X_WP, const Pose& X_WC) {
  return (X_WP * joint.X_PF).inverse() * (X_WC * joint.X_CM);
}

Twist relative_twist(const Joint& joint, const Pose& X_WP, const Twist& V_WP, const Pose& X_WC,
                     const Twist& V_WC) {
  const Vec3 p_CM_W = X_WC.q * joint.X_CM.p;
  const Vec3 p_PM_W = X_WC.p + p_CM_W - X_WP.p;
  const Quat q_FW = (X_WP.q * joint.X_PF.q).conjugate();
  return {q_FW * (V_WC.at(p_CM_W) - V_WP.at(p_PM_W)), q_FW * (V_WC.angular - V_WP.angular)};
}

}  // namespace cogrsim
