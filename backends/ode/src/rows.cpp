#include "rows.h"

#include "convert.h"

namespace cogrsim::ode {

namespace {

// Speed that no contact ever has: the normal row of a joint that is wanted for its friction rows
// alone.
constexpr double kNever = -1e6;

double bound_of(double bound) { return bound == kNoBound ? dInfinity : bound; }

}  // namespace

void Rows::clear() {
  dJointGroupEmpty(engine_.rows());
  used_ = 0;
  count_ = 0;
}

int Rows::attach(dJointID joint, const RowBody& first, const RowBody& second, bool swapped,
                 int rows) {
  dJointAttach(joint, first.id, second.id);
  if (used_ == made_.size()) made_.emplace_back();
  Made& made = made_[used_];
  made.feedback = {};
  made.swapped = swapped;
  dJointSetFeedback(joint, &made.feedback);
  count_ += rows;
  return static_cast<int>(used_++);
}

void Rows::point(const RowBody& a, const RowBody& b, const Vec3& at_a, const Vec3& at_b,
                 const Vec3& target, double softness, std::vector<int>& handles) {
  const double cfm = softness * h_ * (a.inverse_mass + b.inverse_mass);
  if (a.id && b.id) {
    // ODE's ball joint acts at its two anchors, and those lie apart by h times the speed it makes:
    // a couple that would eat angular momentum. So three rows at one point.
    const Vec3 d[3] = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
    const Vec3 shift = target + a.at(at_a) - a.at(at_b);
    handles.push_back(along(a, b, at_b, 2, d, shift.data(), kNoBound, cfm));
    handles.push_back(along(a, b, at_b, 1, d + 2, shift.data() + 2, kNoBound, cfm));
    return;
  }
  // ODE's row: v_1 - v_2 = (p_2 - p_1) / h, on bodies 1 and 2; 1 must be movable.
  const bool swapped = b.id == nullptr;
  const RowBody& first = swapped ? a : b;
  const RowBody& second = swapped ? b : a;
  const Vec3 p1 = swapped ? at_a : at_b;
  const Vec3 c = (swapped ? Vec3(-target) : target) + second.at(swapped ? at_b : at_a);
  const Vec3 p2 = p1 + h_ * c;
  const dJointID joint = dJointCreateBall(engine_.world(), engine_.rows());
  handles.push_back(attach(joint, first, second, swapped, 3));
  dJointSetBallAnchor(joint, p1.x(), p1.y(), p1.z());
  dJointSetBallAnchor2(joint, p2.x(), p2.y(), p2.z());
  dJointSetBallParam(joint, dParamCFM, cfm);
}

int Rows::contact(const RowBody& a, const RowBody& b, dContact& c, int rows) {
  const bool swapped = b.id == nullptr;
  const RowBody& first = swapped ? a : b;
  const RowBody& second = swapped ? b : a;
  if (swapped) {
    // Seen from the other side normal and friction directions turn round; speeds along them do not.
    for (int i = 0; i < 3; ++i) {
      c.geom.normal[i] = -c.geom.normal[i];
      c.fdir1[i] = -c.fdir1[i];
    }
  }
  if (second.id == nullptr) {
    const Vec3 n = to_vec(c.geom.normal), s = to_vec(c.fdir1);
    const Vec3 t = n.cross(s), given = second.at(to_vec(c.geom.pos));
    c.surface.motionN += n.dot(given);
    c.surface.motion1 += s.dot(given);
    c.surface.motion2 += t.dot(given);
  }
  const dJointID joint = dJointCreateContact(engine_.world(), engine_.rows(), &c);
  return attach(joint, first, second, swapped, rows);
}

int Rows::along(const RowBody& a, const RowBody& b, const Vec3& at, int directions, const Vec3* d,
                const double* target, double bound, double cfm) {
  dContact c = {};
  Vec3 n, t;
  if (directions == 2) {
    n = d[0].cross(d[1]);  // then n x d0 = d1
  } else {
    perpendiculars(d[0], n, t);
  }
  c.surface.mode = dContactFDir1 | dContactMotionN | dContactMotion1 | dContactMotion2 |
                   dContactMu2 | dContactSlip1 | dContactSlip2;
  c.surface.mu = bound_of(bound);
  c.surface.mu2 = directions == 2 ? bound_of(bound) : 0.0;
  c.surface.slip1 = c.surface.slip2 = cfm;
  c.surface.motionN = kNever;
  c.surface.motion1 = target[0];
  c.surface.motion2 = directions == 2 ? target[1] : 0.0;
  copy_to(c.geom.pos, at);
  copy_to(c.geom.normal, n);
  copy_to(c.fdir1, d[0]);
  if (b.id == nullptr && directions == 2) {
    // After turning round, n x s has kept its sign while d1 turned: make n x s = -d1.
    copy_to(c.geom.normal, Vec3(-n));
  }
  return contact(a, b, c, directions + 1);
}

int Rows::turn(const RowBody& a, const RowBody& b, int directions, const Vec3* d,
               const double* target, double bound, double cfm) {
  const bool swapped = b.id == nullptr;
  const RowBody& first = swapped ? a : b;
  const RowBody& second = swapped ? b : a;
  const dJointID joint = dJointCreateAMotor(engine_.world(), engine_.rows());
  const int handle = attach(joint, first, second, swapped, directions);
  dJointSetAMotorMode(joint, dAMotorUser);
  dJointSetAMotorNumAxes(joint, directions);
  for (int i = 0; i < directions; ++i) {
    const int group = i * dParamGroup;
    double speed = swapped ? -target[i] : target[i];
    if (second.id == nullptr) speed += d[i].dot(second.w);
    dJointSetAMotorAxis(joint, i, 0, d[i].x(), d[i].y(), d[i].z());
    dJointSetAMotorParam(joint, dParamVel + group, speed);
    dJointSetAMotorParam(joint, dParamFMax + group, bound_of(bound));
    dJointSetAMotorParam(joint, dParamCFM + group, cfm);
  }
  return handle;
}

int Rows::stop_along(const RowBody& a, const RowBody& b, const Vec3& at, const Vec3& d,
                     double target) {
  dContact c = {};
  c.surface.mode = dContactMotionN;
  c.surface.mu = 0.0;
  c.surface.motionN = target;
  copy_to(c.geom.pos, at);
  copy_to(c.geom.normal, d);
  return contact(a, b, c, 1);
}

int Rows::stop_turn(const RowBody& a, const RowBody& b, const Vec3& d, double target) {
  // A motor at its lower stop asks for v >= -erp (angle - stop) / h; with an angle of -1 and the
  // stop at 0 that is erp / h.
  const bool swapped = b.id == nullptr;
  const RowBody& first = swapped ? a : b;
  const RowBody& second = swapped ? b : a;
  const Vec3 axis = swapped ? Vec3(-d) : d;
  double speed = target;
  if (second.id == nullptr) speed += axis.dot(second.w);
  const dJointID joint = dJointCreateAMotor(engine_.world(), engine_.rows());
  const int handle = attach(joint, first, second, swapped, 1);
  dJointSetAMotorMode(joint, dAMotorUser);
  dJointSetAMotorNumAxes(joint, 1);
  dJointSetAMotorAxis(joint, 0, 0, axis.x(), axis.y(), axis.z());
  dJointSetAMotorAngle(joint, 0, -1.0);
  dJointSetAMotorParam(joint, dParamLoStop, 0.0);
  dJointSetAMotorParam(joint, dParamStopERP, speed * h_);
  dJointSetAMotorParam(joint, dParamStopCFM, 0.0);
  return handle;
}

int Rows::touch(const RowBody& a, const RowBody& b, const Touch& touch) {
  dContact c = {};
  c.surface.mode = dContactFDir1 | dContactMotionN | dContactMotion1 | dContactMotion2 |
                   dContactSoftCFM | dContactSlip1 | dContactSlip2;
  c.surface.soft_cfm = touch.cfm;
  c.surface.slip1 = c.surface.slip2 = touch.slip;
  c.surface.motionN = touch.target;
  if (touch.fixed_cap) {
    c.surface.mode |= dContactMu2;
    c.surface.mu = touch.cap;
    c.surface.mu2 = touch.cap_t;
  } else {
    c.surface.mode |= dContactApprox1_1 | dContactApprox1_2;
    c.surface.mu = touch.friction;
  }
  copy_to(c.geom.pos, touch.at);
  copy_to(c.geom.normal, touch.n);
  copy_to(c.fdir1, touch.s);
  return contact(a, b, c, 3);
}

Wrench Rows::wrench(int handle, const RowBody& a, const RowBody& b, const Vec3& about) const {
  const Made& made = made_[static_cast<std::size_t>(handle)];
  // Of ODE's first body, about its centre; that of the second is the same turned round.
  const RowBody& first = made.swapped ? a : b;
  const Vec3 f = to_vec(made.feedback.f1);
  const Vec3 t = to_vec(made.feedback.t1) + (first.c - about).cross(f);
  return made.swapped ? Wrench{-f, -t} : Wrench{f, t};
}

}  // namespace cogrsim::ode
