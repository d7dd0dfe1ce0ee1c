#include "mechanism/kinematics.h"

#include <array>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/model/joint_kinematics.h"
#include "mechanism/mechanism.h"

namespace cogrsim::dynamics {
namespace {

// Rotation of a quaternion of any length, scalar first.
Mat3 rotation_of(const double* q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double s = 2.0 / (w * w + x * x + y * y + z * z);
  Mat3 R;
  R << 1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y),  //
      s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x),   //
      s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y);
  return R;
}

Vec3 entries(const double* x) { return {x[0], x[1], x[2]}; }

Placement moved_along_axis(const Mounting& mounting, const Placement& X_WI, const double* q) {
  double angle = 0.0, height = 0.0;
  if (mounting.turns) {
    angle = mounting.sign * q[0];
    height = mounting.lead * angle;
  }
  if (mounting.slide >= 0) height += mounting.sign * q[mounting.slide];
  Placement X_WO = X_WI;
  if (mounting.turns) {
    const double c = std::cos(angle), s = std::sin(angle);
    X_WO.R.col(0) = c * X_WI.R.col(0) + s * X_WI.R.col(1);
    X_WO.R.col(1) = c * X_WI.R.col(1) - s * X_WI.R.col(0);
  }
  X_WO.p += height * X_WI.R.col(2);
  return X_WO;
}

// X_IO, how O moves in I, and the rate of that at constant speeds, of any joint of the model. With R, p
// of X_FM and w, v of V_FM, the joint reversed is X_MF = (R', -R' p), in M's axes
//   w_MF = -R' w,  v_MF = R' (w x p - v),   and, as R' changes by -R' [w],
//   their rates -R' dw and R' (2 w x v - w x (w x p) + dw x p - dv).
struct JointMotion {
  Placement X;
  Twist V, rate;
};
JointMotion joint_motion(const SceneModel& model, const Link& link, const double* q,
                         const double* u) {
  const Joint& joint = model.joints[std::size_t(link.plan.joint)];
  std::array<double, 7> model_q{};
  std::array<double, 6> model_u{};
  for (int k = 0; k < link.nq; ++k) model_q[std::size_t(k)] = q[link.q_map[std::size_t(k)]];
  if (u)
    for (int k = 0; k < link.nu; ++k) model_u[std::size_t(k)] = u[link.u_map[std::size_t(k)]];
  JointMotion out{Placement(joint_pose(joint, model_q.data())),
                  joint_twist(joint, model_q.data(), model_u.data()),
                  joint_twist_rate(joint, model_q.data(), model_u.data())};
  if (!link.plan.reversed) return out;
  const Mat3 R = out.X.R.transpose();
  const Vec3 p = out.X.p, w = out.V.angular, v = out.V.linear;
  const Vec3 dw = out.rate.angular, dv = out.rate.linear;
  out.X = {R, -(R * p)};
  out.V.angular = -(R * w);
  out.V.linear = R * (w.cross(p) - v);
  out.rate.angular = -(R * dw);
  out.rate.linear = R * (2.0 * w.cross(v) - w.cross(w.cross(p)) + dw.cross(p) - dv);
  return out;
}

}  // namespace

Placement inboard_frame(const Link& link, const std::vector<LinkMotion>& motions) {
  if (link.plan.parent < 0) return link.mounting->X_PI;
  return motions[std::size_t(link.plan.parent)].X * link.mounting->X_PI;
}

Mounting mount(const SceneModel& model, const PlannedLink& plan) {
  Mounting out;
  const Joint& joint = model.joints[std::size_t(plan.joint)];
  const Placement X_PF(joint.X_PF), X_CM(joint.X_CM);
  const auto inverse = [](const Placement& X) {
    return Placement(X.R.transpose(), -(X.R.transpose() * X.p));
  };
  out.X_PI = plan.reversed ? X_CM : X_PF;
  out.X_OB = inverse(plan.reversed ? X_PF : X_CM);
  out.p_BO = plan.reversed ? X_PF.p : X_CM.p;
  if (plan.parent < 0 && plan.anchor >= 0)
    out.X_PI = Placement(model.bodies[std::size_t(plan.anchor)].X_WB) * out.X_PI;
  out.kind = Mounting::Kind::axis;
  out.sign = plan.reversed ? -1.0 : 1.0;
  switch (joint.type) {
    case JointType::fixed:
      out.kind = Mounting::Kind::fixed;
      break;
    case JointType::hinge:
      out.turns = true;
      break;
    case JointType::slider:
      out.slide = 0;
      break;
    case JointType::screw:
      out.turns = true;
      out.lead = joint.pitch / (2 * kPi);
      break;
    case JointType::cylindrical:
      out.turns = true;
      out.slide = 1;
      break;
    case JointType::universal:
    case JointType::gimbal:
    case JointType::planar:
    case JointType::ball:
    case JointType::free:
      out.kind = Mounting::Kind::other;
      break;
  }
  return out;
}

void find_poses(const SceneModel& model, const std::vector<Link>& links, const double* q,
                std::vector<LinkMotion>& out) {
  out.resize(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    const double* const own = q + link.first_q;
    Placement& X = out[i].X;
    if (!link.mounting) {
      X.R = rotation_of(own);
      X.p = entries(own + 4) - X.R * link.centre();
      continue;
    }
    const Mounting& mounting = *link.mounting;
    switch (mounting.kind) {
      case Mounting::Kind::fixed:
        X = inboard_frame(link, out) * mounting.X_OB;
        break;
      case Mounting::Kind::axis:
        X = moved_along_axis(mounting, inboard_frame(link, out), own) * mounting.X_OB;
        break;
      case Mounting::Kind::other:
        X = inboard_frame(link, out) * joint_motion(model, link, own, nullptr).X * mounting.X_OB;
        break;
    }
  }
}

void find_velocities(const SceneModel& model, const std::vector<Link>& links, const double* q,
                     const double* u, std::vector<LinkMotion>& out) {
  const LinkMotion still;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    const double* const own = u + link.first_u;
    LinkMotion& motion = out[i];
    if (!link.mounting) {
      motion.angular = entries(own);
      motion.linear = entries(own + 3) - motion.angular.cross(motion.X.R * link.centre());
      continue;
    }
    const Mounting& mounting = *link.mounting;
    const bool carried = link.plan.parent >= 0;
    const LinkMotion& inboard = carried ? out[std::size_t(link.plan.parent)] : still;
    motion.angular = inboard.angular;
    if (mounting.kind == Mounting::Kind::fixed) {
      motion.linear = inboard.velocity_at(motion.X.p);
      continue;
    }
    // As if fixed to the body inboard, and the joint's own motion at O.
    const Vec3 at = motion.X * mounting.p_BO;
    motion.linear = inboard.velocity_at(at);
    if (mounting.kind == Mounting::Kind::axis) {
      Vec3 axis = mounting.X_PI.R.col(2);
      if (carried) axis = inboard.X.R * axis;
      const double spin = mounting.turns ? mounting.sign * own[0] : 0.0;
      double speed = mounting.lead * spin;
      if (mounting.slide >= 0) speed += mounting.sign * own[mounting.slide];
      motion.angular += spin * axis;
      motion.linear += speed * axis;
    } else {
      const Mat3 R_WI = inboard_frame(link, out).R;
      const Twist V_IO = joint_motion(model, link, q + link.first_q, own).V;
      motion.angular += R_WI * V_IO.angular;
      motion.linear += R_WI * V_IO.linear;
    }
    motion.linear += motion.angular.cross(motion.X.p - at);
  }
}

void find_joint_columns(const SceneModel& model, const Link& link, const Placement& X_WI,
                        const double* q, const Vec3& origin, Spatial* columns) {
  std::array<double, 6> u{};
  for (int k = 0; k < link.nu; ++k) {
    u[std::size_t(k)] = 1.0;
    const JointMotion motion = joint_motion(model, link, q, u.data());
    u[std::size_t(k)] = 0.0;
    Spatial& column = columns[k];
    column.angular = X_WI.R * motion.V.angular;
    column.linear = X_WI.R * motion.V.linear + column.angular.cross(origin - X_WI * motion.X.p);
  }
}

Spatial find_joint_bias(const SceneModel& model, const Link& link, const Placement& X_WI,
                        const double* q, const double* u, const Vec3& origin) {
  // The velocity at I's origin is v + p x w, where p, of O, changes by v.
  const JointMotion motion = joint_motion(model, link, q, u);
  const Twist& rate = motion.rate;
  Spatial out;
  out.angular = X_WI.R * rate.angular;
  out.linear = X_WI.R * (rate.linear + motion.V.linear.cross(motion.V.angular) +
                         motion.X.p.cross(rate.angular));
  out.linear += out.angular.cross(origin - X_WI.p);
  return out;
}

void find_rates(const std::vector<Link>& links, const double* q, const double* u, double* qdot) {
  for (const Link& link : links) {
    const double* const own_u = u + link.first_u;
    double* const rate = qdot + link.first_q;
    if (!link.has_quaternion) {
      std::copy(own_u, own_u + link.nu, rate);
      continue;
    }
    // The spin is in I's axes: qdot = (0, w) q / 2.
    const double* const e = q + link.first_q;
    const double x = 0.5 * own_u[0], y = 0.5 * own_u[1], z = 0.5 * own_u[2];
    rate[0] = -(x * e[1] + y * e[2] + z * e[3]);
    rate[1] = x * e[0] + y * e[3] - z * e[2];
    rate[2] = y * e[0] + z * e[1] - x * e[3];
    rate[3] = z * e[0] + x * e[2] - y * e[1];
    std::copy(own_u + 3, own_u + link.nu, rate + 4);
  }
}

}  // namespace cogrsim::dynamics
