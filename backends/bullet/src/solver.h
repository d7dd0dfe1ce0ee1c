// Bullet's sequential impulse solver with our joints in its loop and our restitution.
#pragma once

#include <memory>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletDynamics/ConstraintSolver/btContactSolverInfo.h>

#include "joint_group.h"

namespace cogrsim::bullet {

struct SolverSettings {
  int iterations = 10;
  double bounce_threshold = 0.05;  ///< [m/s]
};

/// One step's velocities: contacts by Bullet's rows, joints by their groups, in turn.
///
/// Restitution: a contact that will close within the step gets the one speed with which the flight
/// that follows reaches e^2 times the height fallen, wherever in the step the impact lies. With a
/// the acceleration into the contact, d the gap and v the approach speed at the start of the step,
/// symplectic Euler keeps  E = a d + v^2/2 + v a dt/2  on the way down, and the speed u given on
/// the way up must fulfil  u^2/2 + u a dt/2 + a d = e^2 E.
///
/// Contacts that carry are a little soft: a spring of natural frequency kContactRate per step and
/// critical damping, both at the end of the step, on the mass felt at the point. What is sunk in is
/// some micrometres, and the load spreads over the points of a body instead of jumping between
/// them.
class StepSolver {
 public:
  /// What a body moves by in this step beside its velocity.
  struct Displacement {
    btRigidBody* body;
    btVector3 v, w;
  };
  virtual ~StepSolver() = default;
  virtual void solve(std::vector<btCollisionObject*>& bodies, btPersistentManifold** manifolds,
                     int manifold_count, std::vector<std::unique_ptr<JointGroup>>& groups,
                     double dt, btDispatcher* dispatcher) = 0;
  const std::vector<Displacement>& displacements() const { return displacement_; }

 protected:
  std::vector<Displacement> displacement_;
};

std::unique_ptr<StepSolver> make_solver(const SolverSettings& settings);

}  // namespace cogrsim::bullet
