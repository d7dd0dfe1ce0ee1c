#include "rigid_body.h"

#include <cmath>

#include <Eigen/Eigenvalues>

#include <BulletCollision/CollisionShapes/btEmptyShape.h>

#include "convert.h"

namespace cogrsim::bullet {

namespace {

/// Shapes are dispatched one by one (see collision.h); Bullet only wants the pointer not to be
/// null.
btCollisionShape* no_shape() {
  static btEmptyShape shape;
  return &shape;
}

bool is_identity(const Pose& X) {
  return X.q.w() == 1.0 && X.p[0] == 0.0 && X.p[1] == 0.0 && X.p[2] == 0.0;
}

/// `v` turned by the rotation vector `r` (Rodrigues' formula, coefficients by series for the small
/// angles of one step).
btVector3 rotated(const btVector3& v, const btVector3& r) {
  const double t = r.length2();
  double s, c;
  if (t < 0.1) {
    s = 1.0 - t * (1.0 / 6 - t * (1.0 / 120 - t * (1.0 / 5040 - t / 362880)));
    c = 0.5 - t * (1.0 / 24 - t * (1.0 / 720 - t * (1.0 / 40320 - t / 3628800)));
  } else {
    const double angle = std::sqrt(t);
    s = std::sin(angle) / angle;
    c = (1.0 - std::cos(angle)) / t;
  }
  const btVector3 rv = r.cross(v);
  return v + rv * s + r.cross(rv) * c;
}

btQuaternion rotation(const btVector3& r) {
  const double t = 0.25 * r.length2();  // square of half the angle
  double s, c;
  if (t < 0.1) {
    s = 1.0 - t * (1.0 / 6 - t * (1.0 / 120 - t * (1.0 / 5040 - t / 362880)));
    c = 1.0 - t * (0.5 - t * (1.0 / 24 - t * (1.0 / 720 - t * (1.0 / 40320 - t / 3628800))));
  } else {
    const double half = std::sqrt(t);
    s = std::sin(half) / half;
    c = std::cos(half);
  }
  const btVector3 v = r * (0.5 * s);
  return {v.x(), v.y(), v.z(), c};
}

}  // namespace

void move_freely(PrincipalState& state, const btVector3& moments, bool symmetric, double dt) {
  state.X_WP.setOrigin(state.X_WP.getOrigin() + state.v * dt);
  const btVector3 w = state.w;
  if (w.length2() == 0.0) return;
  if (symmetric) {
    btQuaternion q = rotation(w * dt) * state.X_WP.getRotation();
    q.normalize();
    state.X_WP.setRotation(q);
    return;
  }
  // In the body's axes: momentum l; mean rate m obeys  I m = l as seen from half way.
  const btMatrix3x3& R = state.X_WP.getBasis();
  const btVector3 wb = w * R;  // R^T w
  const btVector3 l = wb * moments;
  const btVector3 inverse(1.0 / moments.x(), 1.0 / moments.y(), 1.0 / moments.z());
  btVector3 m = wb;
  for (int round = 0; round < 3; ++round) m = rotated(l, m * (-0.5 * dt)) * inverse;
  btQuaternion q = state.X_WP.getRotation() * rotation(m * dt);
  q.normalize();
  const btVector3 world_momentum = R * l;
  state.X_WP.setRotation(q);
  const btMatrix3x3& R_new = state.X_WP.getBasis();
  state.w = R_new * ((world_momentum * R_new) * inverse);
}

RigidBody::RigidBody(const Body& model, const Vec3& gravity)
    : kind_(model.kind), anchor_(model.X_WB) {
  double bullet_mass = 0.0;
  btVector3 bullet_moments(0, 0, 0);
  if (kind_ == BodyKind::dynamic) {
    mass_ = bullet_mass = model.mass;
    const Mat3& I = model.inertia;
    X_BP_.p = model.com;
    const double scale = I.diagonal().cwiseAbs().maxCoeff() * 1e-14;
    if (std::abs(I(0, 1)) <= scale && std::abs(I(0, 2)) <= scale && std::abs(I(1, 2)) <= scale) {
      moments_ = to_bt(I.diagonal());
    } else {
      const Eigen::SelfAdjointEigenSolver<Mat3> eigen(I);
      Mat3 axes = eigen.eigenvectors();
      if (axes.determinant() < 0.0) axes.col(2) = -axes.col(2);
      X_BP_.q = Quat(axes).normalized();
      moments_ = to_bt(eigen.eigenvalues());
    }
    bullet_moments = moments_;
    const double mean = (moments_.x() + moments_.y() + moments_.z()) / 3.0;
    symmetric_ = std::abs(moments_.x() - mean) < 1e-12 * mean &&
                 std::abs(moments_.y() - mean) < 1e-12 * mean &&
                 std::abs(moments_.z() - mean) < 1e-12 * mean;
  }
  btRigidBody::btRigidBodyConstructionInfo info(bullet_mass, nullptr, no_shape(), bullet_moments);
  info.m_linearDamping = 0.0;
  info.m_angularDamping = 0.0;
  object_ = std::make_unique<btRigidBody>(info);
  object_->setFlags(0);  // gyroscopic motion is ours, see move_freely
  object_->setActivationState(DISABLE_DEACTIVATION);
  object_->setContactProcessingThreshold(BT_LARGE_FLOAT);
  if (kind_ == BodyKind::kinematic) {
    object_->setCollisionFlags(object_->getCollisionFlags() |
                               btCollisionObject::CF_KINEMATIC_OBJECT);
  }
  if (kind_ == BodyKind::dynamic) object_->setGravity(to_bt(gravity));
  set(model.X_WB, kind_ == BodyKind::fixed ? Twist{} : model.V_WB);
}

RigidBody::RigidBody(const Body& model, const Pose& anchor) : RigidBody(model, Vec3(0, 0, 0)) {
  anchor_ = anchor;
  set(anchor, {});
}

RigidBody RigidBody::at_rest(const Body& model, const Vec3& gravity) const {
  if (model.kind == BodyKind::fixed) return {model, pose()};
  RigidBody out(model, gravity);
  out.set(pose(), {});
  return out;
}

PrincipalState RigidBody::principal() const {
  return {object_->getWorldTransform(), object_->getLinearVelocity(),
          object_->getAngularVelocity()};
}

void RigidBody::set_principal(const PrincipalState& state) {
  object_->setWorldTransform(state.X_WP);
  object_->setLinearVelocity(state.v);
  object_->setAngularVelocity(state.w);
  object_->updateInertiaTensor();
}

PrincipalState RigidBody::predicted(double dt) const {
  PrincipalState state = principal();
  if (kind_ != BodyKind::fixed) {
    move_freely(state, moments_, symmetric_ || kind_ != BodyKind::dynamic, dt);
  }
  return state;
}

Pose RigidBody::pose() const {
  const Pose X_WP = from_bt(object_->getWorldTransform());
  // Of most bodies both frames are one: the same figures with much less work.
  if (is_identity(X_BP_)) return {X_WP.p, X_WP.q.normalized()};
  return X_WP * X_BP_.inverse();
}

Twist RigidBody::twist() const {
  const Vec3 w = from_bt(object_->getAngularVelocity());
  if (is_identity(X_BP_)) return {from_bt(object_->getLinearVelocity()), w};
  const Vec3 to_origin =
      -(from_bt(object_->getWorldTransform().getBasis()) * (X_BP_.q.conjugate() * X_BP_.p));
  return {from_bt(object_->getLinearVelocity()) + w.cross(to_origin), w};
}

void RigidBody::set(const Pose& X_WB, const Twist& V_WB) {
  const Pose X_WP = X_WB * X_BP_;
  set_principal({to_bt(X_WP), to_bt(V_WB.at(X_WP.p - X_WB.p)), to_bt(V_WB.angular)});
}

void RigidBody::integrate(double dt, const btVector3& extra_v, const btVector3& extra_w) {
  PrincipalState state = principal();
  const btVector3 v = state.v;
  state.v += extra_v;
  state.w += extra_w;
  move_freely(state, moments_, symmetric_ || kind_ != BodyKind::dynamic, dt);
  state.v = v;
  state.w -= extra_w;
  set_principal(state);
}

}  // namespace cogrsim::bullet
