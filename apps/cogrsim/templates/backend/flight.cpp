#include "flight.h"

namespace flight {
namespace {

// The angular velocity for the momentum of the body at the orientation `q`.
Vec3 spin_at(const Body& body, const Quat& q) {
  // The inertia is constant in body axes, so the momentum is transformed there, and the result
  // back.
  return q * body.inertia.ldlt().solve(q.conjugate() * body.angular_momentum);
}

// dq/dt as a vector of four, in Eigen's order x y z w.
Eigen::Vector4d rate_at(const Body& body, const Eigen::Vector4d& at) {
  Quat q;
  q.coeffs() = at.normalized();
  const Vec3 w = spin_at(body, q);
  return 0.5 * (Quat(0.0, w.x(), w.y(), w.z()) * q).coeffs();
}

}  // namespace

void set_spin(Body& body, const Vec3& angular_velocity) {
  body.angular_velocity = angular_velocity;
  const Mat3 R = body.orientation.toRotationMatrix();
  body.angular_momentum = R * body.inertia * R.transpose() * angular_velocity;
}

void advance(Body& body, const Vec3& gravity, double dt) {
  if (body.motion == Motion::still) return;
  if (body.motion == Motion::carried) {
    body.position += body.velocity * dt;
    const double angle = body.angular_velocity.norm() * dt;
    if (angle > 0.0) {
      const Quat turn(Eigen::AngleAxisd(angle, body.angular_velocity.normalized()));
      body.orientation = (turn * body.orientation).normalized();
    }
    return;
  }
  body.position += body.velocity * dt + 0.5 * dt * dt * gravity;
  body.velocity += gravity * dt;
  const Eigen::Vector4d q = body.orientation.coeffs();
  const Eigen::Vector4d k1 = rate_at(body, q);
  const Eigen::Vector4d k2 = rate_at(body, q + 0.5 * dt * k1);
  const Eigen::Vector4d k3 = rate_at(body, q + 0.5 * dt * k2);
  const Eigen::Vector4d k4 = rate_at(body, q + dt * k3);
  body.orientation.coeffs() = (q + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)).normalized();
  body.angular_velocity = spin_at(body, body.orientation);
}

}  // namespace flight
