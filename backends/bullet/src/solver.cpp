#include "solver.h"

#include <cmath>

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

namespace cogrsim::bullet {

namespace {

constexpr double kPi = 3.14159265358979323846;
// Restitution is ours: Bullet never sees an approach as fast as this [m/s].
constexpr double kNever = 1e30;

/// Speed after a bounce, see StepSolver; negative when it would not leave the surface.
double rebound(double gap, double approach, double acceleration, double e, double dt) {
  const double fall = acceleration * gap + 0.5 * approach * approach + 0.5 * approach * acceleration * dt;
  const double left = e * e * fall - acceleration * gap;
  const double half = 0.5 * acceleration * dt;
  if (left <= 0.0) return -1.0;
  return std::sqrt(half * half + 2.0 * left) - half;
}

class RigidSolver final : public btSequentialImpulseConstraintSolver, public StepSolver {
 public:
  explicit RigidSolver(const SolverSettings& settings) : settings_(settings) {
    info_.m_numIterations = settings.iterations;
    info_.m_splitImpulse = settings.split_impulse;
    info_.m_splitImpulsePenetrationThreshold = 0.0;
    info_.m_restitutionVelocityThreshold = kNever;
    info_.m_solverMode = SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS;
    info_.m_leastSquaresResidualThreshold = 0.0;
  }

  void solve(std::vector<btCollisionObject*>& bodies, btPersistentManifold** manifolds,
             int manifold_count, std::vector<ConstraintGroup>& groups, double dt,
             btDispatcher* dispatcher) override {
    info_.m_timeStep = dt;
    groups_ = &groups;
    solveGroup(bodies.data(), static_cast<int>(bodies.size()), manifolds, manifold_count, nullptr,
               0, info_, nullptr, dispatcher);
  }

 protected:
  void convertContacts(btPersistentManifold** manifolds, int count,
                       const btContactSolverInfo& info) override {
    remember_friction(manifolds, count);
    btSequentialImpulseConstraintSolver::convertContacts(manifolds, count, info);
    for (int i = 0; i < m_tmpSolverContactConstraintPool.size(); ++i) {
      btSolverConstraint& row = m_tmpSolverContactConstraintPool[i];
      warm_start_friction(row, info.m_warmstartingFactor);
      adjust(row, info.m_timeStep);
    }
  }

  btScalar solveGroupCacheFriendlySetup(btCollisionObject** bodies, int body_count,
                                        btPersistentManifold** manifolds, int manifold_count,
                                        btTypedConstraint** constraints, int constraint_count,
                                        const btContactSolverInfo& info,
                                        btIDebugDraw* drawer) override {
    const btScalar result = btSequentialImpulseConstraintSolver::solveGroupCacheFriendlySetup(
        bodies, body_count, manifolds, manifold_count, constraints, constraint_count, info, drawer);
    for (ConstraintGroup& group : *groups_) group.bind(&RigidSolver::find_body, this);
    return result;
  }

  btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int body_count,
                                btPersistentManifold** manifolds, int manifold_count,
                                btTypedConstraint** constraints, int constraint_count,
                                const btContactSolverInfo& info, btIDebugDraw* drawer) override {
    for (ConstraintGroup& group : *groups_) group.iterate();
    return btSequentialImpulseConstraintSolver::solveSingleIteration(
        iteration, bodies, body_count, manifolds, manifold_count, constraints, constraint_count,
        info, drawer);
  }

  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int body_count,
                                         const btContactSolverInfo& info) override {
    for (ConstraintGroup& group : *groups_) group.iterate();
    return btSequentialImpulseConstraintSolver::solveGroupCacheFriendlyFinish(bodies, body_count,
                                                                              info);
  }

 private:
  static btSolverBody* find_body(void* context, btRigidBody& body) {
    auto& self = *static_cast<RigidSolver*>(context);
    const int id = body.getCompanionId();
    return id >= 0 ? &self.m_tmpSolverBodyPool[id] : nullptr;
  }

  /// Begins with the friction of the last step, turned into this step's directions. Bullet begins
  /// with none, and what the sweeps then do not find again shows as creep.
  void warm_start_friction(const btSolverConstraint& normal, double factor) {
    const auto& point = *static_cast<const btManifoldPoint*>(normal.m_originalContactPoint);
    const btVector3 old = old_friction_[point_index_++] * factor;
    btSolverBody& a = m_tmpSolverBodyPool[normal.m_solverBodyIdA];
    btSolverBody& b = m_tmpSolverBodyPool[normal.m_solverBodyIdB];
    const btVector3* directions[2] = {&point.m_lateralFrictionDir1, &point.m_lateralFrictionDir2};
    for (int k = 0; k < 2; ++k) {
      btSolverConstraint& row = m_tmpSolverContactFrictionConstraintPool[normal.m_frictionIndex + k];
      const double impulse = old.dot(*directions[k]);
      row.m_appliedImpulse = impulse;
      if (a.m_originalBody) {
        a.internalApplyImpulse(row.m_contactNormal1 * a.internalGetInvMass(),
                               row.m_angularComponentA, impulse);
      }
      if (b.m_originalBody) {
        b.internalApplyImpulse(row.m_contactNormal2 * b.internalGetInvMass(),
                               row.m_angularComponentB, impulse);
      }
    }
  }

  /// The friction impulses of the last step by contact point, before Bullet turns the directions.
  void remember_friction(btPersistentManifold** manifolds, int count) {
    old_friction_.clear();
    point_index_ = 0;
    for (int i = 0; i < count; ++i) {
      for (int k = 0; k < manifolds[i]->getNumContacts(); ++k) {
        const btManifoldPoint& p = manifolds[i]->getContactPoint(k);
        old_friction_.push_back(p.m_lateralFrictionDir1 * p.m_appliedImpulseLateral1 +
                                p.m_lateralFrictionDir2 * p.m_appliedImpulseLateral2);
      }
    }
  }

  void adjust(btSolverConstraint& row, double dt) {
    const auto& point = *static_cast<const btManifoldPoint*>(row.m_originalContactPoint);
    const bool soft = (point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING) != 0;
    const double e = point.m_combinedRestitution;
    if (!soft && e <= 0.0) return;
    const btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
    const btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
    const double speed = row.m_contactNormal1.dot(a.m_linearVelocity) +
                         row.m_relpos1CrossNormal.dot(a.m_angularVelocity) +
                         row.m_contactNormal2.dot(b.m_linearVelocity) +
                         row.m_relpos2CrossNormal.dot(b.m_angularVelocity);
    const double gained = row.m_contactNormal1.dot(a.m_externalForceImpulse) +
                          row.m_relpos1CrossNormal.dot(a.m_externalTorqueImpulse) +
                          row.m_contactNormal2.dot(b.m_externalForceImpulse) +
                          row.m_relpos2CrossNormal.dot(b.m_externalTorqueImpulse);
    const double gap = point.getDistance();
    if (soft) {
      soften(row, point.m_combinedContactStiffness1, e, gap, speed + gained, dt);
      return;
    }
    if (speed >= -settings_.bounce_threshold || gap + (speed + gained) * dt >= 0.0) return;
    const double wanted = rebound(gap, -speed, -gained / dt, e, dt);
    if (wanted <= 0.0) return;
    row.m_rhs = (wanted - speed - gained) * row.m_jacDiagABInv;
    row.m_rhsPenetration = 0.0;
  }

  /// A spring of the scene's stiffness with the damping that gives its restitution (of the free
  /// linear oscillator), both at the end of the step.
  static void soften(btSolverConstraint& row, double stiffness, double e, double gap, double speed,
                     double dt) {
    const double inverse_mass =
        row.m_contactNormal1.dot(row.m_contactNormal1) > 0.0 ||
                row.m_contactNormal2.dot(row.m_contactNormal2) > 0.0
            ? 1.0 / row.m_jacDiagABInv - (row.m_cfm / row.m_jacDiagABInv)
            : 0.0;
    if (inverse_mass <= 0.0) return;
    double ratio = 1.0;
    if (e > 0.0) {
      const double log_e = std::log(e);
      ratio = -log_e / std::sqrt(kPi * kPi + log_e * log_e);
    }
    const double damping = 2.0 * ratio * std::sqrt(stiffness / inverse_mass);
    // impulse = -dt k (gap + dt u) - dt c u, and u = speed + inverse_mass * impulse
    const double slope = dt * (dt * stiffness + damping);
    const double compliance = 1.0 / slope;
    row.m_jacDiagABInv = 1.0 / (inverse_mass + compliance);
    row.m_cfm = compliance * row.m_jacDiagABInv;
    row.m_rhs = (-dt * stiffness * gap * compliance - speed) * row.m_jacDiagABInv;
    row.m_rhsPenetration = 0.0;
  }

  SolverSettings settings_;
  btContactSolverInfo info_;
  std::vector<ConstraintGroup>* groups_ = nullptr;
  std::vector<btVector3> old_friction_;
  std::size_t point_index_ = 0;
};

}  // namespace

std::unique_ptr<StepSolver> make_solver(const SolverSettings& settings) {
  return std::make_unique<RigidSolver>(settings);
}

}  // namespace cogrsim::bullet
