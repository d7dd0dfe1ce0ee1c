#include "joint_rows.h"

#include <cmath>

#include "cogrsim/model/joint_kinematics.h"

namespace cogrsim::bullet {

namespace {

constexpr double kTurn = 6.283185307179586;

}  // namespace

btVector3 rotation_vector(const btQuaternion& q) {
  const double side = q.w() < 0.0 ? -1.0 : 1.0;
  const btVector3 v(q.x() * side, q.y() * side, q.z() * side);
  const double sine = v.length();
  if (sine < 1e-9) return v * 2.0;
  return v * (2.0 * std::atan2(sine, q.w() * side) / sine);
}

int locked_count(JointType type) {
  // A ball's and a free joint's coordinates outnumber their speeds, which are the freedom.
  return 6 - speed_count(type);
}

int locked_directions(const Joint& joint, const btTransform& X_WF, const btTransform& X_WM,
                      std::array<Direction, 6>& out) {
  const btVector3 zero(0, 0, 0);
  const btMatrix3x3& F = X_WF.getBasis();
  const btVector3 x = F.getColumn(0), y = F.getColumn(1), z = F.getColumn(2);
  switch (joint.type) {
    case JointType::fixed:
      out = {{{x, zero}, {y, zero}, {z, zero}, {zero, x}, {zero, y}, {zero, z}}};
      return 6;
    case JointType::hinge:
      out = {{{x, zero}, {y, zero}, {z, zero}, {zero, x}, {zero, y}}};
      return 5;
    case JointType::slider:
      out = {{{x, zero}, {y, zero}, {zero, x}, {zero, y}, {zero, z}}};
      return 5;
    case JointType::screw:
      out = {{{x, zero}, {y, zero}, {z, z * (-joint.pitch / kTurn)}, {zero, x}, {zero, y}}};
      return 5;
    case JointType::cylindrical:
      out = {{{x, zero}, {y, zero}, {zero, x}, {zero, y}}};
      return 4;
    case JointType::universal: {
      btVector3 across = x.cross(X_WM.getBasis().getColumn(1));
      across.normalize();
      out = {{{x, zero}, {y, zero}, {z, zero}, {zero, across}}};
      return 4;
    }
    case JointType::planar:
      out = {{{z, zero}, {zero, x}, {zero, y}}};
      return 3;
    case JointType::ball:
      out = {{{x, zero}, {y, zero}, {z, zero}}};
      return 3;
    case JointType::free:
      break;
  }
  return 0;
}

void locked_errors(const Joint& joint, const btTransform& X_WF, const btTransform& X_WM,
                   const double* q, std::array<double, 6>& out) {
  const btMatrix3x3& F = X_WF.getBasis();
  const btMatrix3x3& M = X_WM.getBasis();
  const btVector3 p = (X_WM.getOrigin() - X_WF.getOrigin()) * F;
  // Tilt of M's z against F's, about F's x and y.
  const btVector3 zm = M.getColumn(2) * F;
  const double tilt_x = -zm.y(), tilt_y = zm.x();
  switch (joint.type) {
    case JointType::fixed:
    case JointType::slider: {
      btQuaternion turn;
      (F.transpose() * M).getRotation(turn);
      const btVector3 r = rotation_vector(turn);
      if (joint.type == JointType::fixed) {
        out = {p.x(), p.y(), p.z(), r.x(), r.y(), r.z()};
      } else {
        out = {p.x(), p.y(), r.x(), r.y(), r.z()};
      }
      break;
    }
    case JointType::hinge:
      out = {p.x(), p.y(), p.z(), tilt_x, tilt_y};
      break;
    case JointType::screw:
      out = {p.x(), p.y(), p.z() - joint.pitch / kTurn * q[0], tilt_x, tilt_y};
      break;
    case JointType::cylindrical:
      out = {p.x(), p.y(), tilt_x, tilt_y};
      break;
    case JointType::universal:
      out = {p.x(), p.y(), p.z(), -F.getColumn(0).dot(M.getColumn(1))};
      break;
    case JointType::planar:
      out = {p.z(), tilt_x, tilt_y};
      break;
    case JointType::ball:
      out = {p.x(), p.y(), p.z()};
      break;
    case JointType::free:
      break;
  }
}

int free_directions(const Joint& joint, const btTransform& X_WF, const btTransform& X_WM,
                    std::array<Direction, 3>& out) {
  const btVector3 zero(0, 0, 0);
  const btMatrix3x3& F = X_WF.getBasis();
  const btVector3 x = F.getColumn(0), y = F.getColumn(1), z = F.getColumn(2);
  switch (joint.type) {
    case JointType::hinge:
    case JointType::screw:
      out[0] = {zero, z};
      return 1;
    case JointType::slider:
      out[0] = {z, zero};
      return 1;
    case JointType::cylindrical:
      out[0] = {zero, z};
      out[1] = {z, zero};
      return 2;
    case JointType::universal:
      out[0] = {zero, x};
      out[1] = {zero, X_WM.getBasis().getColumn(1)};
      return 2;
    case JointType::planar:
      out[0] = {x, zero};
      out[1] = {y, zero};
      out[2] = {zero, z};
      return 3;
    default:
      return 0;
  }
}

}  // namespace cogrsim::bullet
