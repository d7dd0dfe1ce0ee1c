// One body of the scene as Bullet holds it.
#pragma once

#include <memory>

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::bullet {

class ReducedGroup;

/// Where a body's principal frame P is and how it moves: origin at the centre of mass, axes along
/// the principal axes of inertia. Bullet knows bodies by this frame only.
struct PrincipalState {
  btTransform X_WP = btTransform::getIdentity();
  btVector3 v{0, 0, 0};  ///< of the centre of mass, world axes [m/s]
  btVector3 w{0, 0, 0};  ///< world axes [rad/s]
};

/// Advances by dt with these velocities and no torque. The angular momentum is kept exactly; the
/// rotation is that of the mean angular velocity over the step, found by a few fixed-point rounds
/// of the implicit midpoint rule, so that time can be reversed and energy does not drift.
/// `moments`: principal moments of inertia [kg m^2].
void move_freely(PrincipalState& state, const btVector3& moments, bool symmetric, double dt);

class RigidBody {
 public:
  RigidBody() = default;
  RigidBody(const Body& model, const Vec3& gravity);
  /// A fixed body at another place than its model says.
  RigidBody(const Body& model, const Pose& anchor);
  /// The same body, of the kind that `model` says, where this one is and at rest.
  RigidBody at_rest(const Body& model, const Vec3& gravity) const;

  BodyKind kind() const { return kind_; }
  bool dynamic() const { return kind_ == BodyKind::dynamic; }
  btRigidBody& object() { return *object_; }
  const btRigidBody& object() const { return *object_; }

  const Pose& X_BP() const { return X_BP_; }
  const btVector3& moments() const { return moments_; }
  double mass() const { return mass_; }

  /// Of the principal frame.
  PrincipalState principal() const;
  void set_principal(const PrincipalState& state);
  /// The same after a step of free motion with the present velocities.
  PrincipalState predicted(double dt) const;

  /// X_WB of a fixed body as it was given: where it was put first, or made static.
  const Pose& anchor() const { return anchor_; }

  Pose pose() const;    ///< X_WB
  Twist twist() const;  ///< of the body frame's origin, world axes
  void set(const Pose& X_WB, const Twist& V_WB);

  /// Moves by the present velocities, and in this step by `extra_v` and `extra_w` beside them.
  void integrate(double dt, const btVector3& extra_v, const btVector3& extra_w);

 private:
  BodyKind kind_ = BodyKind::fixed;
  Pose X_BP_, anchor_;
  btVector3 moments_{1, 1, 1};
  double mass_ = 0.0;
  bool symmetric_ = true;  ///< all moments equal: nothing gyroscopic
  std::unique_ptr<btRigidBody> object_;
};

}  // namespace cogrsim::bullet
