#include "axis_rig.h"

namespace conformance {
namespace {

constexpr double kMass = 2.0;
constexpr double kMoment = 0.05;
constexpr double kPitch = 1.0;  // makes the two parts of a screw's inertia alike

// Ball joints turn about this direction of F.
Vec3 ball_direction() { return Vec3(2, -1, 2) / 3.0; }

}  // namespace

std::vector<AxisKind> axis_kinds() {
  return {
      {"hinge", JointType::hinge, 0, true},
      {"slider", JointType::slider, 0, false},
      {"screw", JointType::screw, 0, true},
      {"cylindrical 0 (angle)", JointType::cylindrical, 0, true},
      {"cylindrical 1 (travel)", JointType::cylindrical, 1, false},
      {"universal 0", JointType::universal, 0, true},
      {"universal 1", JointType::universal, 1, true},
      {"planar 0 (x)", JointType::planar, 0, false},
      {"planar 1 (y)", JointType::planar, 1, false},
      {"planar 2 (angle)", JointType::planar, 2, true},
      {"ball", JointType::ball, 0, true},
      {"gimbal 0", JointType::gimbal, 0, true},
      {"gimbal 1", JointType::gimbal, 1, true},
      {"gimbal 2", JointType::gimbal, 2, true},
  };
}

AxisRig::AxisRig(const AxisKind& axis_kind) : kind(axis_kind) {
  builder.model.physics.gravity = Vec3::Zero();
  // Nothing is aligned with anything: neither joint and world, nor body and joint.
  const Pose X_WJ(Vec3(0.3, -0.2, 1.1), turn(Vec3(1, 2, 3), 0.7));
  const Vec3 com(0.1, -0.05, 0.02);
  const Quat q_WB = turn(Vec3(-2, 1, 1), 1.1);
  body = builder.body("body", kMass, Mat3(kMoment * Mat3::Identity()), {X_WJ.p - q_WB * com, q_WB});
  builder.model.bodies[0].com = com;
  joint = builder.joint("joint", kind.type, kWorld, body, X_WJ);
  builder.model.joints[0].pitch = kPitch;
  builder.model.joints[0].axes.resize(
      kind.type == JointType::ball ? 1 : static_cast<std::size_t>(speed_count(kind.type)));
  inertia = kind.angular ? kMoment : kMass;
  if (kind.type == JointType::screw) {
    const double lead = kPitch / (2.0 * kPi);
    inertia += kMass * lead * lead;
  }
}

JointAxis& AxisRig::axis() { return builder.model.joints[0].axes[kind.axis]; }

void AxisRig::start_speed(double u) {
  Joint& j = builder.model.joints[0];
  Body& b = builder.model.bodies[0];
  std::vector<double> q(static_cast<std::size_t>(position_count(kind.type)), 0.0);
  std::vector<double> speeds(static_cast<std::size_t>(speed_count(kind.type)), 0.0);
  if (kind.type == JointType::ball) {
    q[0] = 1.0;
    for (int i = 0; i < 3; ++i) speeds[i] = u * ball_direction()[i];
  } else {
    speeds[kind.axis] = u;
  }
  j.position = q;
  j.velocity = speeds;
  const Twist V_FM = joint_twist(j, q.data(), speeds.data());
  const Twist V_WM = {j.X_PF.q * V_FM.linear, j.X_PF.q * V_FM.angular};
  b.V_WB = {V_WM.at(b.X_WB.p - j.X_PF.p), V_WM.angular};
}

int AxisRig::motor(MotorMode mode) { return builder.motor("motor", joint, mode, kind.axis); }

double AxisRig::q(Sim& sim) const {
  if (kind.type != JointType::ball) return sim.q(joint, kind.axis);
  const Quat turned(sim.q(joint, 0), sim.q(joint, 1), sim.q(joint, 2), sim.q(joint, 3));
  const double half = std::atan2(turned.vec().dot(ball_direction()), turned.w());
  return std::remainder(2.0 * half, 2.0 * kPi);
}

double AxisRig::u(Sim& sim) const {
  if (kind.type != JointType::ball) return sim.u(joint, kind.axis);
  return Vec3(sim.u(joint, 0), sim.u(joint, 1), sim.u(joint, 2)).dot(ball_direction());
}

double AxisRig::effort(Sim& sim) const {
  if (kind.type != JointType::ball) return sim.effort(joint, kind.axis);
  return Vec3(sim.effort(joint, 0), sim.effort(joint, 1), sim.effort(joint, 2))
      .dot(ball_direction());
}

}  // namespace conformance
