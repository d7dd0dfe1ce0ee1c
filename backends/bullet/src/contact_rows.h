// The rows of contact points: one that pushes and two of friction, solved point by point.
#pragma once

#include <vector>

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include "step_bodies.h"

namespace cogrsim::bullet {

/// One contact point. Row 0 pushes, 1 and 2 are friction, each on the velocities of `a` and `b`.
/// Packed so that a sweep reads one such after the other and no more.
struct ContactRows {
  Six Ja[3], Ka[3];  ///< J and M^-1 J^T on a
  double rhs[3], inverse[3], impulse[3];
  double coupling[2];  ///< change of the friction rows' impulses per impulse of the push
  double keep;         ///< 1 - softness of the push
  double friction;
  double start;  ///< push that the last step left
  int a, b;      ///< b is -1 where it does not move
  Six Jb[3], Kb[3];
};

/// What setting up a point leaves for deciding how hard it is.
struct ContactCourse {
  double inverse_mass = 0.0;  ///< felt along the normal [1/kg]
  double speed = 0.0;         ///< along the normal at the start of the step [m/s]
  double gained = 0.0;        ///< what outer forces add to it [m/s]
};

/// Makes the rows of a point as if it were rigid and met at the end of the step: closing no faster
/// than its gap allows, sliding stopped. Bodies: -1 where it does not move, not both.
/// Friction acts along the sliding and across. Turns the point's friction of the last step into
/// these directions, and starts `bodies` with all impulses of the last step.
ContactCourse make_contact_rows(btManifoldPoint& point, const btCollisionObject& object_a,
                                const btCollisionObject& object_b, StepBodies& bodies, double dt,
                                ContactRows& out);

/// One turn over the points from `first` to before `last`: each brings its own three rows to what they
/// ask for, the push first; friction is cut back to the circle of Coulomb's law.
void sweep_contacts(ContactRows* first, ContactRows* last, DeltaVelocity* deltas);

}  // namespace cogrsim::bullet
