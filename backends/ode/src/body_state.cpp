#include "body_state.h"

#include <Eigen/LU>
#include <algorithm>

#include "convert.h"

namespace cogrsim::ode {

BodyState::BodyState(const Body& model)
    : kind(model.kind), removed(model.removed), com_(model.com), mass_(model.mass) {
  if (dynamic()) {
    inertia_ = model.inertia;
    inverse_ = model.inertia.inverse();
  }
  set(model.X_WB, kind == BodyKind::fixed ? Twist() : model.V_WB);
}

void BodyState::set(const Pose& X_WB, const Twist& V_WB) {
  now.q = X_WB.q;
  const Vec3 arm = X_WB.q * com_;
  now.c = X_WB.p + arm;
  now.v = V_WB.at(arm);
  now.w = V_WB.angular;
}

Mat3 BodyState::inertia_at(const Quat& q) const {
  const Mat3 R = q.toRotationMatrix();
  return R * inertia_ * R.transpose();
}

Mat3 BodyState::inverse_inertia_at(const Quat& q) const {
  if (!dynamic()) return Mat3::Zero();
  const Mat3 R = q.toRotationMatrix();
  return R * inverse_ * R.transpose();
}

Vec3 BodyState::mean_spin(const Vec3& L, double h) const {
  Vec3 w = inverse_inertia_at(now.q) * L;
  // A contraction with factor |w| h / 2 or so.
  for (int i = 0; i < 20; ++i) {
    const Vec3 next = inverse_inertia_at(rotation_by(0.5 * h * w) * now.q) * L;
    const bool same = (next - w).squaredNorm() <= 1e-32 * next.squaredNorm();
    w = next;
    if (same) break;
  }
  return w;
}

void BodyState::fly(double h, const Vec3& g) {
  now.c += h * now.v + 0.5 * h * h * g;
  now.v += h * g;
  const Vec3 L = inertia_at(now.q) * now.w;
  if (L.isZero(0.0)) return;
  const auto rate = [&](const Eigen::Vector4d& x) {
    const Quat q = Quat(x[0], x[1], x[2], x[3]).normalized();
    const Vec3 w = inverse_inertia_at(q) * L;
    const Quat turn = Quat(0.0, w.x(), w.y(), w.z()) * Quat(x[0], x[1], x[2], x[3]);
    return Eigen::Vector4d(0.5 * Eigen::Vector4d(turn.w(), turn.x(), turn.y(), turn.z()));
  };
  // Steps of at most a hundredth of a radian: the error of a whole turn is then below 1e-10.
  const double turn = std::max(now.w.norm(), (inverse_inertia_at(now.q) * L).norm()) * h;
  const int parts = std::clamp(static_cast<int>(std::ceil(turn / 0.01)), 1, 50);
  const double s = h / parts;
  Eigen::Vector4d x(now.q.w(), now.q.x(), now.q.y(), now.q.z());
  for (int i = 0; i < parts; ++i) {
    const Eigen::Vector4d k1 = rate(x), k2 = rate(x + 0.5 * s * k1), k3 = rate(x + 0.5 * s * k2),
                          k4 = rate(x + s * k3);
    x += s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    x.normalize();
  }
  now.q = Quat(x[0], x[1], x[2], x[3]);
  now.w = inverse_inertia_at(now.q) * L;
}

void BodyState::carry(double h) {
  const Twist V = twist();
  Pose X = pose();
  X.p += h * V.linear;
  X.q = (rotation_by(h * V.angular) * X.q).normalized();
  set(X, V);
}

}  // namespace cogrsim::ode
