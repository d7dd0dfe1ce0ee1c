// Sequential impulses over contact points in turn with the joint groups, with our restitution.
#pragma once

#include <memory>
#include <vector>

#include "contact_rows.h"
#include "joint_group.h"

namespace cogrsim::bullet {

struct SolverSettings {
  int iterations = 10;
  double bounce_threshold = 0.05;  ///< [m/s]
};

/// One step's velocities: contacts by their rows, joints by their groups, in turn.
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
    btVector3 v, w;
  };

  explicit StepSolver(const SolverSettings& settings) : settings_(settings) {}

  /// Gives `moving` (all bodies that may move) the velocities of the end of the step, and the
  /// points of the manifolds their impulses.
  void solve(const std::vector<btCollisionObject*>& moving, btPersistentManifold** manifolds,
             int manifold_count, std::vector<std::unique_ptr<JointGroup>>& groups, double dt);
  /// One per body in the order of `moving`, or none at all when nothing moves beside its velocity.
  const std::vector<Displacement>& displacements() const { return displacements_; }

 private:
  /// A point that may be driving bodies apart, and what it is without that.
  struct Recovering {
    std::size_t point;
    double inverse_mass, speed;
  };

  /// Points from begin to before end that touch no body of any other run.
  struct Run {
    std::size_t begin, end;
  };

  void make_rows(btPersistentManifold** manifolds, int count, double dt);
  /// Parts the points into runs, after the groups were bound.
  void find_runs();
  void sweep(const Run& run) {
    sweep_contacts(points_.data() + run.begin, points_.data() + run.end, bodies_.data());
  }
  /// All sweeps of a run, then those of the next.
  void sweep_loose(int times);
  /// Makes a rigid push the one that this contact needs: soft, a bounce, a spring.
  void adjust(const btManifoldPoint& point, const ContactCourse& course, std::size_t index,
              double dt);
  void solve_groups(std::vector<std::unique_ptr<JointGroup>>& groups);
  /// The places at the end of the step follow from the velocities found so far. They contain what
  /// drives overlapping bodies apart, which must not stay in the bodies as momentum: a few more
  /// sweeps without it (the relaxing ones of Catto, "Solver2D", box2d.org, 2024).
  void relax(std::vector<std::unique_ptr<JointGroup>>& groups);
  /// Hands the impulses to the contact points, for reports and for the next step to begin with.
  void write_impulses();

  SolverSettings settings_;
  StepBodies bodies_;
  std::vector<ContactRows> points_;
  std::vector<btManifoldPoint*> sources_;  ///< of points_
  std::vector<Run> loose_;                 ///< of bodies without joints: solved one after the other
  std::vector<Run> tied_;                  ///< swept in turn with the groups
  std::vector<std::size_t> last_;          ///< point that touches the body, by body
  std::vector<Recovering> recovering_;
  std::vector<Displacement> displacements_;
};

}  // namespace cogrsim::bullet
