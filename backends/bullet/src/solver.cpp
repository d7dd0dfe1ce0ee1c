#include "solver.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"

namespace cogrsim::bullet {

namespace {

// No bound on a speed [m/s].
constexpr double kNever = 1e30;

// Natural frequency times dt and damping ratio of a contact that carries.
constexpr double kContactRate = 1.0;
constexpr double kContactDamping = 1.0;
// Bodies that overlap are driven apart no faster than this [m/s].
constexpr double kFastestRecovery = 1.0;
constexpr int kRelaxSweeps = 2;
// Points that are swept to the end before the next ones are looked at: they fit a first-level cache of
// 32 kB.
constexpr std::size_t kRunLength = 32;
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

/// Damping ratio of a free linear oscillator that leaves with e times the speed it came with.
double damping_ratio(double e) {
  if (e <= 0.0) return 1.0;
  const double log_e = std::log(e);
  return -log_e / std::sqrt(kPi * kPi + log_e * log_e);
}

/// Makes a push  impulse = -dt (k (gap + dt u) + c u)  of the speed u at the end of the step, where
/// it pushes. `speed` is u without impulses.
void soften(ContactRows& rows, double inverse_mass, double stiffness, double damping, double gap,
            double speed, double fastest_recovery, double dt) {
  const double compliance = 1.0 / (dt * (dt * stiffness + damping));
  const double wanted = std::min(-dt * stiffness * gap * compliance, fastest_recovery);
  const double inverse = 1.0 / (inverse_mass + compliance);
  rows.inverse[0] = inverse;
  rows.keep = 1.0 - compliance * inverse;
  rows.rhs[0] = (wanted - speed) * inverse;
}

}  // namespace

void StepSolver::solve(const std::vector<btCollisionObject*>& moving,
                       btPersistentManifold** manifolds, int manifold_count,
                       std::vector<std::unique_ptr<JointGroup>>& groups, double dt) {
  bodies_.begin(moving, dt);
  make_rows(manifolds, manifold_count, dt);
  for (auto& group : groups) group->bind(bodies_);
  find_runs();
  sweep_loose(settings_.iterations);
  for (int i = 0; i < settings_.iterations; ++i) {
    // Groups are dear and warm-started contacts change little: they take every other turn.
    if (i % 2 == 0) solve_groups(groups);
    for (const Run& run : tied_) sweep(run);
  }
  solve_groups(groups);
  relax(groups);
  bodies_.end();
  write_impulses();
}

void StepSolver::solve_groups(std::vector<std::unique_ptr<JointGroup>>& groups) {
  for (auto& group : groups) group->iterate(bodies_);
}

void StepSolver::make_rows(btPersistentManifold** manifolds, int count, double dt) {
  recovering_.clear();
  displacements_.clear();
  sources_.clear();
  std::size_t most = 0;
  for (int i = 0; i < count; ++i) most += static_cast<std::size_t>(manifolds[i]->getNumContacts());
  points_.resize(most);
  const auto dynamic = [&](const btCollisionObject& object) {
    const int index = StepBodies::index_of(object);
    return index >= 0 && bodies_.entry(index).inverse_mass > 0.0;
  };
  for (int i = 0; i < count; ++i) {
    btPersistentManifold& manifold = *manifolds[i];
    const btCollisionObject& a = *manifold.getBody0();
    const btCollisionObject& b = *manifold.getBody1();
    if (!dynamic(a) && !dynamic(b)) continue;
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      btManifoldPoint& point = manifold.getContactPoint(k);
      const std::size_t index = sources_.size();
      const ContactCourse course = make_contact_rows(point, a, b, bodies_, dt, points_[index]);
      adjust(point, course, index, dt);
      sources_.push_back(&point);
    }
  }
  points_.resize(sources_.size());
}

void StepSolver::sweep_loose(int times) {
  for (const Run& run : loose_) {
    for (int i = 0; i < times; ++i) sweep(run);
  }
}

void StepSolver::find_runs() {
  loose_.clear();
  tied_.clear();
  last_.resize(bodies_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    last_[static_cast<std::size_t>(points_[i].a)] = i;
    if (points_[i].b >= 0) last_[static_cast<std::size_t>(points_[i].b)] = i;
  }
  const auto add = [](std::vector<Run>& runs, const Run& run, std::size_t longest) {
    if (!runs.empty() && runs.back().end == run.begin && run.end - runs.back().begin <= longest)
      runs.back().end = run.end;
    else
      runs.push_back(run);
  };
  std::size_t begin = 0, end = 0;
  bool held = false;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    for (const int body : {points_[i].a, points_[i].b}) {
      if (body < 0) continue;
      end = std::max(end, last_[static_cast<std::size_t>(body)]);
      held = held || bodies_.entry(body).held;
    }
    if (i < end) continue;
    if (held)
      add(tied_, {begin, i + 1}, points_.size());
    else
      add(loose_, {begin, i + 1}, kRunLength);
    begin = end = i + 1;
    held = false;
  }
}

void StepSolver::adjust(const btManifoldPoint& point, const ContactCourse& course,
                        std::size_t index, double dt) {
  ContactRows& rows = points_[index];
  const double e = point.m_combinedRestitution;
  const double speed = course.speed, gained = course.gained;
  const double gap = point.getDistance();
  const double inverse_mass = course.inverse_mass;
  if ((point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING) != 0) {
    const double stiffness = point.m_combinedContactStiffness1;
    const double damping = 2.0 * damping_ratio(e) * std::sqrt(stiffness / inverse_mass);
    soften(rows, inverse_mass, stiffness, damping, gap, speed + gained, kNever, dt);
    return;
  }
  if (e > 0.0 && speed < -settings_.bounce_threshold && gap + (speed + gained) * dt < kReached) {
    const double wanted = rebound(gap, -speed, -gained / dt, e, dt);
    if (wanted > 0.0) {
      rows.rhs[0] = (wanted - speed - gained) * rows.inverse[0];
      return;
    }
  }
  if (gap > kReached) return;
  if (speed + gained < -kImpactSpeed) {
    // Stop it dead: softness is for loads.
    rows.rhs[0] = -(speed + gained) * rows.inverse[0];
    return;
  }
  const double rate = kContactRate / dt;
  // What the load of the last steps accounts for is no overlap to recover from.
  const double sunk = point.m_prevRHS / dt * inverse_mass / (rate * rate);
  if (-gap > kRestingShare * sunk + kNoOverlap) {
    recovering_.push_back({index, inverse_mass, speed + gained});
  }
  soften(rows, inverse_mass, rate * rate / inverse_mass,
         2.0 * kContactDamping * rate / inverse_mass, gap, speed + gained, kFastestRecovery, dt);
}

void StepSolver::relax(std::vector<std::unique_ptr<JointGroup>>& groups) {
  if (recovering_.empty()) return;
  displacements_.resize(bodies_.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const DeltaVelocity& delta = bodies_.deltas()[i];
    displacements_[i] = {delta.lin(), delta.ang()};
  }
  for (const Recovering& r : recovering_) {
    ContactRows& point = points_[r.point];
    point.inverse[0] = 1.0 / r.inverse_mass;
    point.keep = 1.0;
    point.rhs[0] = -r.speed * point.inverse[0];
  }
  sweep_loose(kRelaxSweeps);
  for (int k = 0; k < kRelaxSweeps; ++k) {
    for (const Run& run : tied_) sweep(run);
    solve_groups(groups);
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const DeltaVelocity& delta = bodies_.deltas()[i];
    displacements_[i].v -= delta.lin();
    displacements_[i].w -= delta.ang();
  }
}

void StepSolver::write_impulses() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactRows& rows = points_[i];
    btManifoldPoint& point = *sources_[i];
    point.m_appliedImpulse = rows.impulse[0];
    point.m_appliedImpulseLateral1 = rows.impulse[1];
    point.m_appliedImpulseLateral2 = rows.impulse[2];
    // The smaller of two steps' pushes is the load: an impact lasts one. Kept in a field of the
    // point that Bullet carries along and has no use for itself.
    point.m_prevRHS = std::min(rows.impulse[0], rows.start);
  }
}

}  // namespace cogrsim::bullet
