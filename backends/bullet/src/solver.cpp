#include "solver.h"

#include <algorithm>
#include <cmath>

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

namespace cogrsim::bullet {

namespace {

constexpr double kPi = 3.14159265358979323846;
// Restitution is ours: Bullet never sees an approach as fast as this [m/s].
constexpr double kNever = 1e30;

// Natural frequency times dt and damping ratio of a contact that carries.
constexpr double kContactRate = 1.0;
constexpr double kContactDamping = 1.0;
// Bodies that overlap are driven apart no faster than this [m/s].
constexpr double kFastestRecovery = 1.0;
constexpr int kRelaxSweeps = 2;
// A contact sunk in by up to so many times what its load explains, and this much [m], is at rest.
constexpr double kRestingShare = 3.0;
constexpr double kNoOverlap = 1e-7;
// Contacts that close faster than this are impacts [m/s].
constexpr double kImpactSpeed = 0.03;
// Surfaces this near at the end of a step have met, whatever rounding says [m].
constexpr double kReached = 1e-9;

/// Speed after a bounce, see StepSolver; negative when it would not leave the surface.
double rebound(double gap, double approach, double acceleration, double e, double dt) {
  const double fall =
      acceleration * gap + 0.5 * approach * approach + 0.5 * approach * acceleration * dt;
  const double left = e * e * fall - acceleration * gap;
  const double half = 0.5 * acceleration * dt;
  if (left <= 0.0) return -1.0;
  return std::sqrt(half * half + 2.0 * left) - half;
}

class RigidSolver final : public btSequentialImpulseConstraintSolver, public StepSolver {
 public:
  explicit RigidSolver(const SolverSettings& settings) : settings_(settings) {
    info_.m_numIterations = settings.iterations;
    info_.m_splitImpulse = false;
    info_.m_restitutionVelocityThreshold = kNever;
    info_.m_solverMode = SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS;
    info_.m_leastSquaresResidualThreshold = 0.0;
    info_.m_warmstartingFactor = 1.0;
  }

  void solve(std::vector<btCollisionObject*>& bodies, btPersistentManifold** manifolds,
             int manifold_count, std::vector<std::unique_ptr<JointGroup>>& groups, double dt,
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
    recovering_.clear();
    impacts_.clear();
    displacement_.clear();
    btSequentialImpulseConstraintSolver::convertContacts(manifolds, count, info);
    for (int i = 0; i < m_tmpSolverContactConstraintPool.size(); ++i) {
      warm_start_friction(m_tmpSolverContactConstraintPool[i], info.m_warmstartingFactor);
      adjust(i, info.m_timeStep);
    }
    pack();
  }

  btScalar solveGroupCacheFriendlySetup(btCollisionObject** bodies, int body_count,
                                        btPersistentManifold** manifolds, int manifold_count,
                                        btTypedConstraint** constraints, int constraint_count,
                                        const btContactSolverInfo& info,
                                        btIDebugDraw* drawer) override {
    const btScalar result = btSequentialImpulseConstraintSolver::solveGroupCacheFriendlySetup(
        bodies, body_count, manifolds, manifold_count, constraints, constraint_count, info, drawer);
    for (auto& group : *groups_) group->bind(&RigidSolver::find_body, this);
    return result;
  }

  btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int body_count,
                                btPersistentManifold** manifolds, int manifold_count,
                                btTypedConstraint** constraints, int constraint_count,
                                const btContactSolverInfo& info, btIDebugDraw* drawer) override {
    (void)bodies, (void)body_count, (void)manifolds, (void)manifold_count;
    (void)constraints, (void)constraint_count, (void)info, (void)drawer;
    // Groups are dear and warm-started contacts change little: they take every other turn.
    if (iteration % 2 == 0) solve_groups();
    sweep();
    return 1.0;  // never done early: the number of sweeps is the scene's
  }

 private:
  void solve_groups() {
    for (auto& group : *groups_) group->iterate();
  }

  /// The three rows of a contact point, packed: sweeps are bound by memory, and Bullet's rows are
  /// more than twice as long. Row 0 pushes, 1 and 2 are friction; normals point from b to a.
  struct Point {
    double direction[3][3];
    double arm_a[3][3], arm_b[3][3];    ///< angular parts of J
    double turn_a[3][3], turn_b[3][3];  ///< of M^-1 J^T
    double rhs[3], inverse[3], impulse[3];
    double coupling[2];  ///< speed along a friction row per impulse of the push
    double softness, friction;
    double start;  ///< push that the last step left
    double inverse_mass_a, inverse_mass_b;
    int a, b;
  };

  static void copy(const btVector3& v, double* out) {
    out[0] = v.x();
    out[1] = v.y();
    out[2] = v.z();
  }

  void pack() {
    points_.resize(static_cast<std::size_t>(m_tmpSolverContactConstraintPool.size()));
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const btSolverConstraint& normal = m_tmpSolverContactConstraintPool[static_cast<int>(i)];
      const btSolverConstraint* rows[3] = {
          &normal, &m_tmpSolverContactFrictionConstraintPool[normal.m_frictionIndex],
          &m_tmpSolverContactFrictionConstraintPool[normal.m_frictionIndex + 1]};
      Point& p = points_[i];
      p.a = normal.m_solverBodyIdA;
      p.b = normal.m_solverBodyIdB;
      p.inverse_mass_a = m_tmpSolverBodyPool[p.a].m_invMass.x();
      p.inverse_mass_b = m_tmpSolverBodyPool[p.b].m_invMass.x();
      p.start = normal.m_appliedImpulse;
      p.friction = normal.m_friction;
      p.softness = normal.m_cfm;
      const bool a_there = m_tmpSolverBodyPool[p.a].m_originalBody != nullptr;
      for (int k = 0; k < 3; ++k) {
        const btSolverConstraint& row = *rows[k];
        copy(a_there ? row.m_contactNormal1 : -row.m_contactNormal2, p.direction[k]);
        copy(row.m_relpos1CrossNormal, p.arm_a[k]);
        copy(row.m_relpos2CrossNormal, p.arm_b[k]);
        copy(row.m_angularComponentA, p.turn_a[k]);
        copy(row.m_angularComponentB, p.turn_b[k]);
        p.rhs[k] = row.m_rhs;
        p.inverse[k] = row.m_jacDiagABInv;
        p.impulse[k] = row.m_appliedImpulse;
      }
      for (int k = 0; k < 2; ++k) {
        p.coupling[k] = dot(p.arm_a[k + 1], p.turn_a[0]) + dot(p.arm_b[k + 1], p.turn_b[0]);
      }
    }
  }

  /// Gives the impulses to Bullet's rows, which hand them to the contact points.
  void unpack() {
    for (std::size_t i = 0; i < points_.size(); ++i) {
      btSolverConstraint& normal = m_tmpSolverContactConstraintPool[static_cast<int>(i)];
      normal.m_appliedImpulse = points_[i].impulse[0];
      // The smaller of two steps' pushes is the load: an impact lasts one. Kept in a field of the
      // point that Bullet carries along and has no use for itself.
      static_cast<btManifoldPoint*>(normal.m_originalContactPoint)->m_prevRHS =
          std::min(points_[i].impulse[0], points_[i].start);
      for (int k = 0; k < 2; ++k) {
        m_tmpSolverContactFrictionConstraintPool[normal.m_frictionIndex + k].m_appliedImpulse =
            points_[i].impulse[k + 1];
      }
    }
  }

  static double dot(const double* x, const double* y) {
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
  }

  void sweep() {
    for (Point& p : points_) {
      btSolverBody& a = m_tmpSolverBodyPool[p.a];
      btSolverBody& b = m_tmpSolverBodyPool[p.b];
      double* va = a.m_deltaLinearVelocity.m_floats;
      double* wa = a.m_deltaAngularVelocity.m_floats;
      double* vb = b.m_deltaLinearVelocity.m_floats;
      double* wb = b.m_deltaAngularVelocity.m_floats;
      // The speeds that impulses have changed, along all three rows at once; what the push then
      // changes of the other two comes in through their coupling.
      const double v[3] = {va[0] - vb[0], va[1] - vb[1], va[2] - vb[2]};
      double speed[3];
      for (int k = 0; k < 3; ++k) {
        speed[k] = dot(p.direction[k], v) + (dot(p.arm_a[k], wa) + dot(p.arm_b[k], wb));
      }
      const double push = std::max(
          p.impulse[0] + p.rhs[0] - p.impulse[0] * p.softness - speed[0] * p.inverse[0], 0.0);
      const double d0 = push - p.impulse[0];
      // Friction in both directions at once, cut back to the circle of Coulomb's law: the bound
      // holds for its length, not for each direction, and is nil where the contact carries nothing.
      double x = p.impulse[1] + p.rhs[1] - (speed[1] + p.coupling[0] * d0) * p.inverse[1];
      double y = p.impulse[2] + p.rhs[2] - (speed[2] + p.coupling[1] * d0) * p.inverse[2];
      const double bound = p.friction * push, size2 = x * x + y * y;
      if (size2 > bound * bound) {
        const double scale = bound / std::sqrt(size2);
        x *= scale;
        y *= scale;
      }
      const double d1 = x - p.impulse[1], d2 = y - p.impulse[2];
      p.impulse[0] = push;
      p.impulse[1] = x;
      p.impulse[2] = y;
      for (int i = 0; i < 3; ++i) {
        const double lin = p.direction[0][i] * d0 + p.direction[1][i] * d1 + p.direction[2][i] * d2;
        va[i] += lin * p.inverse_mass_a;
        vb[i] -= lin * p.inverse_mass_b;
        wa[i] += p.turn_a[0][i] * d0 + p.turn_a[1][i] * d1 + p.turn_a[2][i] * d2;
        wb[i] += p.turn_b[0][i] * d0 + p.turn_b[1][i] * d1 + p.turn_b[2][i] * d2;
      }
    }
  }

  /// The places at the end of the step follow from the velocities found so far. They contain what
  /// drives overlapping bodies apart, which must not stay in the bodies as momentum: a few more
  /// sweeps without it (the relaxing ones of Catto, "Solver2D", box2d.org, 2024).
  void relax() {
    if (recovering_.empty()) return;
    displacement_.clear();
    for (int i = 0; i < m_tmpSolverBodyPool.size(); ++i) {
      const btSolverBody& body = m_tmpSolverBodyPool[i];
      displacement_.push_back(
          {body.m_originalBody, body.m_deltaLinearVelocity, body.m_deltaAngularVelocity});
    }
    for (const Recovering& r : recovering_) {
      Point& point = points_[static_cast<std::size_t>(r.row)];
      point.inverse[0] = 1.0 / r.inverse_mass;
      point.softness = 0.0;
      point.rhs[0] = -r.speed * point.inverse[0];
    }
    for (int k = 0; k < kRelaxSweeps; ++k) {
      sweep();
      solve_groups();
    }
    for (int i = 0; i < m_tmpSolverBodyPool.size(); ++i) {
      const btSolverBody& body = m_tmpSolverBodyPool[i];
      Displacement& d = displacement_[static_cast<std::size_t>(i)];
      d.v -= body.m_deltaLinearVelocity;
      d.w -= body.m_deltaAngularVelocity;
    }
  }

  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int body_count,
                                         const btContactSolverInfo& info) override {
    solve_groups();
    relax();
    unpack();
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
      btSolverConstraint& row =
          m_tmpSolverContactFrictionConstraintPool[normal.m_frictionIndex + k];
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

  void adjust(int index, double dt) {
    btSolverConstraint& row = m_tmpSolverContactConstraintPool[index];
    const auto& point = *static_cast<const btManifoldPoint*>(row.m_originalContactPoint);
    const bool spring =
        (point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING) != 0;
    const double e = point.m_combinedRestitution;
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
    const double inverse_mass = (1.0 - row.m_cfm) / row.m_jacDiagABInv;
    if (spring) {
      const double stiffness = point.m_combinedContactStiffness1;
      const double damping = 2.0 * damping_ratio(e) * std::sqrt(stiffness / inverse_mass);
      soften(row, inverse_mass, stiffness, damping, gap, speed + gained, kNever, dt);
      return;
    }
    if (e > 0.0 && speed < -settings_.bounce_threshold && gap + (speed + gained) * dt < kReached) {
      const double wanted = rebound(gap, -speed, -gained / dt, e, dt);
      if (wanted > 0.0) {
        row.m_rhs = (wanted - speed - gained) * row.m_jacDiagABInv;
        return;
      }
    }
    if (gap > kReached) return;
    if (speed + gained < -kImpactSpeed) {
      // Stop it dead: softness is for loads.
      row.m_rhs = -(speed + gained) * row.m_jacDiagABInv;
      impacts_.push_back(index);
      return;
    }
    const double rate = kContactRate / dt;
    // What the load of the last steps accounts for is no overlap to recover from.
    const double sunk = point.m_prevRHS / dt * inverse_mass / (rate * rate);
    if (-gap > kRestingShare * sunk + kNoOverlap) {
      recovering_.push_back({index, inverse_mass, speed + gained});
    }
    soften(row, inverse_mass, rate * rate / inverse_mass,
           2.0 * kContactDamping * rate / inverse_mass, gap, speed + gained, kFastestRecovery, dt);
  }

  /// Damping ratio of a free linear oscillator that leaves with e times the speed it came with.
  static double damping_ratio(double e) {
    if (e <= 0.0) return 1.0;
    const double log_e = std::log(e);
    return -log_e / std::sqrt(kPi * kPi + log_e * log_e);
  }

  /// Makes a row  impulse = -dt (k (gap + dt u) + c u)  of the speed u at the end of the step,
  /// where it pushes.
  static void soften(btSolverConstraint& row, double inverse_mass, double stiffness, double damping,
                     double gap, double speed, double fastest_recovery, double dt) {
    const double compliance = 1.0 / (dt * (dt * stiffness + damping));
    const double wanted = std::min(-dt * stiffness * gap * compliance, fastest_recovery);
    row.m_jacDiagABInv = 1.0 / (inverse_mass + compliance);
    row.m_cfm = compliance * row.m_jacDiagABInv;
    row.m_rhs = (wanted - speed) * row.m_jacDiagABInv;
  }

  SolverSettings settings_;
  btContactSolverInfo info_;
  std::vector<std::unique_ptr<JointGroup>>* groups_ = nullptr;
  /// A row that may be driving bodies apart, and what it is without that.
  struct Recovering {
    int row;
    double inverse_mass, speed;
  };

  std::vector<Point> points_;
  std::vector<btVector3> old_friction_;
  std::vector<Recovering> recovering_;
  std::vector<int> impacts_;
  std::size_t point_index_ = 0;
};

}  // namespace

std::unique_ptr<StepSolver> make_solver(const SolverSettings& settings) {
  return std::make_unique<RigidSolver>(settings);
}

}  // namespace cogrsim::bullet
