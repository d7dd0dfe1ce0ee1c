#include "body.h"

#include <algorithm>

namespace cogrsim::ode {

namespace {

double square(const dReal* v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

}  // namespace

void BodyLink::create(dWorldID world, const Body& body) {
  id_ = dBodyCreate(world);
  p_ = dBodyGetPosition(id_);
  q_ = dBodyGetQuaternion(id_);
  v_ = dBodyGetLinearVel(id_);
  w_ = dBodyGetAngularVel(id_);
  if (body.kind == BodyKind::kinematic) {
    dBodySetKinematic(id_);
    dBodySetFiniteRotationMode(id_, 1);  // turns by exactly its angular velocity
  } else {
    com_ = body.com;
    shifted_ = !com_.isZero(0.0);
    const Mat3& I = body.inertia;
    dMass mass;
    dMassSetParameters(&mass, body.mass, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2),
                       I(1, 2));
    dBodySetMass(id_, &mass);
  }
  dBodySetAutoDisableFlag(id_, 0);
  set_pose(body.X_WB);
  set_twist(body.V_WB);
}

Pose BodyLink::pose_before(double h) const {
  // ODE turns by q + h/2 w q, made of unit length.
  const Quat back(1.0, -0.5 * h * w_[0], -0.5 * h * w_[1], -0.5 * h * w_[2]);
  return from_centre(centre_before(h), (back * to_quat(q_)).normalized());
}

Twist BodyLink::twist() const {
  const Vec3 v = to_vec(v_), w = to_vec(w_);
  return {shifted_ ? Vec3(v - w.cross(to_quat(q_) * com_)) : v, w};
}

void BodyLink::set_pose(const Pose& X_WB) {
  if (!id_) return;
  const Vec3 c = shifted_ ? Vec3(X_WB.p + X_WB.q * com_) : X_WB.p;
  const dQuaternion q = {X_WB.q.w(), X_WB.q.x(), X_WB.q.y(), X_WB.q.z()};
  dBodySetPosition(id_, c.x(), c.y(), c.z());
  dBodySetQuaternion(id_, q);
}

void BodyLink::set_twist(const Twist& V_WB) {
  if (!id_) return;
  const Vec3 v = shifted_ ? V_WB.at(to_quat(q_) * com_) : V_WB.linear;
  dBodySetLinearVel(id_, v.x(), v.y(), v.z());
  dBodySetAngularVel(id_, V_WB.angular.x(), V_WB.angular.y(), V_WB.angular.z());
}

bool BodyLink::is_within_bounds() const {
  // ODE's quaternions are of unit length or not numbers, as are w's.
  return !id_ || kBounds.hold(square(p_), square(v_), square(w_));
}

double BodyLink::spin_squared() const { return id_ ? square(w_) : 0.0; }

Motion BodyLink::motion() const {
  Motion out;
  if (!id_) return out;
  std::copy(p_, p_ + 3, out.p.begin());
  std::copy(q_, q_ + 4, out.q.begin());
  std::copy(v_, v_ + 3, out.v.begin());
  std::copy(w_, w_ + 3, out.w.begin());
  return out;
}

void BodyLink::set_motion(const Motion& motion) {
  if (!id_) return;
  dBodySetPosition(id_, motion.p[0], motion.p[1], motion.p[2]);
  std::copy(motion.q.begin(), motion.q.end(), const_cast<dReal*>(q_));
  dQtoR(q_, const_cast<dReal*>(dBodyGetRotation(id_)));
  dBodySetLinearVel(id_, motion.v[0], motion.v[1], motion.v[2]);
  dBodySetAngularVel(id_, motion.w[0], motion.w[1], motion.w[2]);
}

}  // namespace cogrsim::ode
