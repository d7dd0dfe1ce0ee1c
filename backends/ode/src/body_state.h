// One rigid body: what ODE is told of it, and its motion where ODE need not be asked.
#pragma once

#include "cogrsim/model/scene_model.h"

namespace cogrsim::ode {

/// Motion of the centre of mass, world axes.
struct Motion {
  Vec3 c = Vec3::Zero();      ///< where it is [m]
  Quat q = Quat(1, 0, 0, 0);  ///< orientation of the body's axes
  Vec3 v = Vec3::Zero();      ///< [m/s]
  Vec3 w = Vec3::Zero();      ///< [rad/s]
};

/// A body about its centre of mass. Immovable ones (static, kinematic) have no mass here.
class BodyState {
 public:
  BodyState() = default;
  /// At the pose and with the twist of the model.
  explicit BodyState(const Body& model);

  BodyKind kind = BodyKind::dynamic;
  bool removed = false;
  Motion now;

  bool dynamic() const { return kind == BodyKind::dynamic && !removed; }
  const Vec3& com() const { return com_; }
  double mass() const { return mass_; }
  const Mat3& inertia() const { return inertia_; }  ///< body axes, about the centre of mass
  Mat3 inertia_at(const Quat& q) const;             ///< world axes
  Mat3 inverse_inertia_at(const Quat& q) const;
  double inverse_mass() const { return dynamic() ? 1.0 / mass_ : 0.0; }

  Pose pose() const { return pose(now); }
  Pose pose(const Motion& m) const { return {m.c - m.q * com_, m.q}; }
  Twist twist() const { return {now.v - now.w.cross(now.q * com_), now.w}; }
  void set(const Pose& X_WB, const Twist& V_WB);

  /// Mean angular velocity over the next h [s] of free rotation with the angular momentum L, by
  /// the implicit midpoint rule.
  Vec3 mean_spin(const Vec3& L, double h) const;
  /// Moves `now` freely for h under the acceleration `g`: exact for the centre of mass, rotation by
  /// Runge-Kutta of fourth order with the angular momentum held.
  void fly(double h, const Vec3& g);
  /// Moves `now` with a constant twist of the body's origin.
  void carry(double h);

 private:
  Vec3 com_ = Vec3::Zero();
  double mass_ = 1.0;
  Mat3 inertia_ = Mat3::Identity(), inverse_ = Mat3::Identity();
};

}  // namespace cogrsim::ode
