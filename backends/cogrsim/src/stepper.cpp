#include "stepper.h"

#include <algorithm>
#include <cmath>

namespace cogrsim::dynamics {
namespace {

// Stages of Runge-Kutta disagree that would change speeds by more than this share of them. Laws that
// are only just not stiff (kExplicitLimit in drives.cpp) reach 0.03.
constexpr double kDoubt = 0.05;

// A step after which a mechanism has more energy than before and than what acts on it gave, by more than this part of it, is
// taken again in halves, so many times at most: forces were those of the speeds before. Where a link turns
// by more than kWhip in the step [rad], also one in which an impact meets it; below kTurns none is.
constexpr double kTurns = 0.01, kGain = 1e-2;
constexpr double kWhip = 0.1, kWhipGain = 1e-5;
constexpr int kHalvings = 4;

// An overlap is left where a link would move by more than this times what the gap gains, and this [m].
constexpr double kMostTravel = 10.0, kLeastTravel = 1e-5;

// One tree on a free base, tied to nothing else.
bool is_free(const Mechanism& mechanism, const Component& c) {
  for (std::size_t i = 0; i < c.links.size(); ++i) {
    const PlannedLink& plan = mechanism.links()[std::size_t(c.links[i])].plan;
    if ((c.linkage->inboard[i] < 0) != (i == 0) || (i == 0 && plan.joint >= 0)) return false;
  }
  for (const Weld& weld : c.linkage->welds)
    if (c.find(weld.primary) < 0) return false;
  return true;
}

}  // namespace

Stepper::Stepper(Mechanism& mechanism, Detector& detector, const StepperOptions& options)
    : sleep(mechanism, detector),
      mechanism_(mechanism),
      contacts_(mechanism, detector, options.solver.tolerance, options.pool.get()),
      options_(options),
      model_(mechanism.model()),
      accelerations_(mechanism),
      laws_(make_laws(mechanism)),
      untouched_(mechanism.components().size(), 0) {
  for (std::size_t i = 0; i < mechanism.components().size(); ++i) {
    const Component& c = mechanism.components()[i];
    has_mechanisms_ = has_mechanisms_ || !c.is_free_body;
    if (c.is_free_body || !is_free(mechanism, c)) continue;
    momenta_.emplace_back();
    momenta_.back().component = int(i);
  }
  impulses.joints.assign(std::size_t(model_.joint_speeds), 0.0);
  impulses.motors.assign(model_.motors.size(), 0.0);
}

void Stepper::set(const Values& q, const Values& u) {
  mechanism_.state.change_q() = q;
  mechanism_.state.change_u() = u;
}

void Stepper::advance(double dt, const std::vector<Drive>& drives,
                      const std::vector<Twist>& twists) {
  drives_ = &drives;
  for (const Link& link : mechanism_.links()) {
    if (!link.kinematic) continue;
    const Twist& twist = twists[std::size_t(link.plan.body)];
    double* const u = &mechanism_.state.change_u()[link.first_u];
    for (int k = 0; k < 3; ++k) {
      u[k] = twist.angular[k];
      u[3 + k] = twist.linear[k];
    }
  }
  if (options_.sleep && !sleep.begin(drives, memory)) return;
  std::fill(impulses.joints.begin(), impulses.joints.end(), 0.0);
  std::fill(impulses.motors.begin(), impulses.motors.end(), 0.0);
  records.clear();
  if (mechanism_.state.nu() == 0) return;
  for (int i = 0; i < options_.substeps; ++i) pass(dt / options_.substeps, kHalvings);
  if (options_.sleep) add_sleeping();
  // They come in the order of the colliders; only where a step has parts may some be out of it.
  if (!std::is_sorted(records.begin(), records.end(), by_pair<ContactRecord>))
    std::stable_sort(records.begin(), records.end(), by_pair<ContactRecord>);
  if (options_.sleep) sleep.end(dt, contacts_, partition_, memory, records, impulses);
}

void Stepper::add_sleeping() {
  const SleepState& asleep = sleep.state();
  records.insert(records.end(), asleep.records.begin(), asleep.records.end());
  for (std::size_t i = 0; i < impulses.joints.size(); ++i)
    impulses.joints[i] += asleep.impulses.joints[i];
  for (std::size_t i = 0; i < impulses.motors.size(); ++i)
    impulses.motors[i] += asleep.impulses.motors[i];
}

void Stepper::sum_efforts(const Values& q, const Values& u, double weight, bool untouched) {
  for (const AxisLaw& law : laws_) {
    const std::size_t c = std::size_t(law.component);
    if (law.implicit || bool(untouched_[c]) != untouched || mechanism_.components()[c].asleep)
      continue;
    const double impulse = weight * law.effort_at(q, u);
    impulses.joints[std::size_t(law.effort)] += impulse;
    if (law.motor >= 0) impulses.motors[std::size_t(law.motor)] += impulse;
  }
}

bool Stepper::build_rows(double h) {
  context_.h = h;
  context_.bounce_threshold = model_.physics.bounce_threshold;
  context_.u = mechanism_.state.u().data();
  context_.start_udot = start_udot_->data();
  // With loops udot_ is found once more before the contacts' rows are made.
  if (mechanism_.has_loops()) row_udot_ = udot_;
  context_.udot = (mechanism_.has_loops() ? row_udot_ : udot_).data();
  context_.start_q = &q0_;
  context_.start_u = &u0_;
  joints_.clear();
  RowBuilder(mechanism_, joints_).add_joint_rows(context_, laws_);
  std::fill(untouched_.begin(), untouched_.end(), 1);
  for (const Row& row : joints_.rows) untouched_[std::size_t(row.component[0])] = 0;
  bool any = !joints_.rows.empty();
  for (const Manifold& manifold : contacts_.manifolds()) {
    bool is_free = false, is_untouched = false;
    for (const int c : manifold.component) {
      if (c < 0) continue;
      is_free = is_free || mechanism_.components()[std::size_t(c)].is_free_body;
      is_untouched = is_untouched || untouched_[std::size_t(c)];
    }
    if (!is_untouched || !(is_free || contacts_.can_yield(context_, manifold))) continue;
    any = true;
    for (const int c : manifold.component)
      if (c >= 0) untouched_[std::size_t(c)] = 0;
  }
  return any;
}

bool Stepper::find_whips(double h, int parts) {
  whips_.clear();
  const std::vector<LinkMotion>& motions = mechanism_.motions();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const int c = mechanism_.links()[i].component;
    if (c < 0 || mechanism_.components()[std::size_t(c)].is_free_body) continue;
    const double turn = parts * h * motions[i].angular.norm();
    if (!(turn > kTurns)) continue;
    if (whips_.empty() || whips_.back().component != c) whips_.push_back({c, false, 0.0, 0.0});
    whips_.back().is_fast = whips_.back().is_fast || turn > kWhip;
  }
  for (Whip& whip : whips_) measure_whip(h, whip);
  return !whips_.empty();
}

void Stepper::measure_whip(double h, Whip& whip) const {
  whip.energy = whip.work = 0.0;
  for (const int i : mechanism_.components()[std::size_t(whip.component)].links) {
    const Link& link = mechanism_.links()[std::size_t(i)];
    const LinkMotion& motion = mechanism_.motions()[std::size_t(i)];
    const Vec3 v = motion.velocity_at(motion.X * link.com);
    const Vec3 spin = motion.X.R.transpose() * motion.angular;
    whip.energy += 0.5 * (link.mass * v.squaredNorm() + spin.dot(link.inertia * spin));
    const Wrench& load = mechanism_.loads()[std::size_t(i)];
    whip.work += h * (load.force.dot(v) + load.torque.dot(motion.angular));
  }
}

// A mechanism that whips and that an impact met, or that has more energy than its loads, springs and motors gave it. `start`: the efforts
// before the step.
bool Stepper::must_be_halved(double h, const EffortSums& start) const {
  if (hit_.empty()) return false;  // nothing touched anything
  for (const Whip& before : whips_) {
    if (before.is_fast && hit_[std::size_t(before.component)]) return true;
    if (untouched_[std::size_t(before.component)]) continue;
    Whip after = before;
    measure_whip(h, after);
    double allowed = before.energy * (1.0 + (before.is_fast ? kWhipGain : kGain)) +
                     0.5 * (before.work + after.work);
    for (const AxisLaw& law : laws_) {
      if (law.component != before.component) continue;
      const double spring = h * law.law.kp * (law.law.position - law.coordinate(q0_));
      const double impulse = law.motor < 0 ? spring
                                           : impulses.motors[std::size_t(law.motor)] -
                                                 start.motors[std::size_t(law.motor)];
      allowed += std::abs(impulse) *
                 std::max(std::abs(u0_[law.speed]), std::abs(mechanism_.state.u()[law.speed]));
    }
    if (!(after.energy <= allowed)) return true;
  }
  return false;
}

void Stepper::pass(double h, int halvings) {
  if (!has_mechanisms_ || halvings == 0 || !find_whips(h, 1 << (kHalvings - halvings)))
    return move(h);
  const Values q = mechanism_.state.q(), u = mechanism_.state.u();
  const StepMemory start = memory;
  const EffortSums efforts = impulses;
  const std::vector<ContactRecord> reported = records;
  hit_.clear();
  move(h);
  if (!must_be_halved(h, efforts)) return;
  set(q, u);
  memory = start;
  impulses = efforts;
  records = reported;
  for (int i = 0; i < 2; ++i) pass(0.5 * h, halvings - 1);
}

void Stepper::move(double h) {
  Mechanism& m = mechanism_;
  q0_ = m.state.q();
  u0_ = m.state.u();
  m.calc_qdot(qk_[0]);
  classify_laws(m, *drives_, h, laws_);
  contacts_.measure_speeds(h);
  measure_momenta(false);

  // To the middle of the step: positions by the speeds at the start; speeds by the acceleration of
  // the last step where contact was on then, so that steps with contact cost one evaluation.
  const bool remembered = memory.had_rows && memory.udot.size() == u0_.size();
  accelerations_.with_rows = remembered;
  if (!remembered) accelerations_.compute(laws_, k_[0]);
  start_udot_ = remembered ? &memory.udot : &k_[0];
  m.state.change_q() = q0_ + (0.5 * h) * qk_[0];
  m.state.change_u() = u0_ + (0.5 * h) * *start_udot_;
  const Accelerations::Middle middle{h, start_udot_};
  const bool smooth = !remembered && options_.scheme != Scheme::midpoint;
  accelerations_.compute(laws_, udot_, smooth ? nullptr : &middle);
  contacts_.detect(h, memory.contacts);
  if (options_.sleep && sleep.wake_touched(contacts_.manifolds(), memory)) {
    set(q0_, u0_);
    return move(h);
  }
  const bool rows = build_rows(h);

  if (!rows && options_.scheme != Scheme::midpoint) {
    runge_kutta(h, !remembered);
    memory.clear();
    set(displaced_, stage_);
    m.project();
    return;
  }
  // Mechanisms that nothing concerns are integrated as if the rest were not there.
  bool separate = false;
  for (const Component& c : m.components())
    separate = separate || (untouched_[std::size_t(&c - m.components().data())] &&
                            !c.is_free_body && c.size() > 0 && !c.asleep);
  separate = separate && options_.scheme != Scheme::midpoint;
  if (!separate) std::fill(untouched_.begin(), untouched_.end(), 0);
  if (smooth && m.has_loops()) accelerations_.compute(laws_, udot_, &middle);
  solve_rows(h);
  if (separate) {
    smooth_q_ = displaced_;
    smooth_u_ = end_u_;
    runge_kutta(h, false);
    for (const Link& link : m.links()) {
      if (link.component < 0 || !untouched_[std::size_t(link.component)]) continue;
      for (int k = 0; k < link.nq; ++k) smooth_q_[link.first_q + k] = displaced_[link.first_q + k];
      for (int k = 0; k < link.nu; ++k) smooth_u_[link.first_u + k] = stage_[link.first_u + k];
    }
    set(smooth_q_, smooth_u_);
  } else {
    set(displaced_, end_u_);
  }
  m.project();
  conserve_momentum(h);
}

void Stepper::runge_kutta(double h, bool have_first) {
  Mechanism& m = mechanism_;
  accelerations_.with_rows = false;
  const auto evaluate = [&](int stage) {
    accelerations_.compute(laws_, k_[stage]);
    m.calc_qdot(qk_[stage]);
  };
  const auto go_to = [&](double step, int from) {
    displaced_ = q0_ + step * qk_[from];
    stage_ = u0_ + step * k_[from];
    set(displaced_, stage_);
  };
  EffortSums before;
  if (m.has_loops()) before = impulses;
  if (have_first) {
    k_[1] = udot_;
    m.calc_qdot(qk_[1]);
  } else {
    set(q0_, u0_);
    evaluate(0);
    go_to(0.5 * h, 0);
    evaluate(1);
  }
  sum_efforts(q0_, u0_, h / 6, true);
  sum_efforts(m.state.q(), m.state.u(), h / 3, true);
  go_to(0.5 * h, 1);
  evaluate(2);
  sum_efforts(m.state.q(), m.state.u(), h / 3, true);
  go_to(h, 2);
  evaluate(3);
  sum_efforts(m.state.q(), m.state.u(), h / 6, true);

  displaced_ = q0_;
  stage_ = u0_;
  for (int i = 0; i < 4; ++i) {
    const double weight = (i == 0 || i == 3) ? h / 6 : h / 3;
    displaced_ = displaced_ + weight * qk_[i];
    stage_ = stage_ + weight * k_[i];
  }
  if (!m.has_loops()) return;
  doubtful_.assign(m.components().size(), 0);
  for (std::size_t i = 0; i < m.components().size(); ++i)
    doubtful_[i] = untouched_[i] && disagree(m.components()[i], h);
  if (std::count(doubtful_.begin(), doubtful_.end(), 1) > 0) pass_singular(h, before);
}

bool Stepper::disagree(const Component& c, double h) const {
  if (!c.has_loops()) return false;
  double middle = 0.0, ends = 0.0, size = 0.0, speed = 0.0;
  for (int u : c.speeds) {
    const double a = k_[0][u], b = k_[1][u], d = k_[2][u], e = k_[3][u];
    middle += (d - b) * (d - b);
    ends += (a - b - d + e) * (a - b - d + e);
    size += b * b;
    speed += u0_[u] * u0_[u];
  }
  // Written so that a NaN disagrees.
  return !(h * std::sqrt(std::max(middle, ends)) <=
           kDoubt * (std::sqrt(speed) + h * std::sqrt(size)));
}

void Stepper::pass_singular(double h, const EffortSums& efforts) {
  Mechanism& m = mechanism_;
  qk_[2] = displaced_;
  k_[2] = stage_;
  // um = P(qm) (u0 + h / 2 a) with `a` at the start, the loops ignored: P never enlarges it.
  set(q0_, u0_);
  accelerations_.compute_open(laws_, k_[0]);
  displaced_ = q0_ + (0.5 * h) * qk_[0];
  stage_ = u0_ + (0.5 * h) * k_[0];
  set(displaced_, stage_);
  m.project_speeds();
  k_[0] = m.state.u() - u0_;
  k_[0] *= 2.0 / h;
  const Accelerations::Middle middle{h, &k_[0]};
  accelerations_.compute(laws_, k_[1], &middle);
  stage_ = u0_ + h * k_[1];
  m.multiply_by_n(stage_, qk_[1]);
  displaced_ = displaced_ + (0.5 * h) * qk_[1];
  for (const AxisLaw& law : laws_) {
    if (law.implicit || !doubtful_[std::size_t(law.component)]) continue;
    const double impulse = h * law.effort_at(m.state.q(), m.state.u());
    impulses.joints[std::size_t(law.effort)] = efforts.joints[std::size_t(law.effort)] + impulse;
    if (law.motor >= 0)
      impulses.motors[std::size_t(law.motor)] = efforts.motors[std::size_t(law.motor)] + impulse;
  }
  for (const Link& link : m.links()) {
    if (link.component >= 0 && doubtful_[std::size_t(link.component)]) continue;
    for (int k = 0; k < link.nq; ++k) displaced_[link.first_q + k] = qk_[2][link.first_q + k];
    for (int k = 0; k < link.nu; ++k) stage_[link.first_u + k] = k_[2][link.first_u + k];
  }
}

void Stepper::limit_displacements(double h, Island& island) {
  bool limited = false;
  for (const Component* c : island.components) {
    if (c->is_free_body) continue;
    const int index = int(c - mechanism_.components().data());
    double gained = -1.0;  // most by which a gap of the component opens [m]
    for (const ContactRows& contact : island.contacts) {
      const Row& row = island.rows[std::size_t(contact.first)];
      if (row.deep && (row.component[0] == index || row.component[1] == index))
        gained = std::max({gained, row.gap_change, 0.0});
    }
    if (gained < 0.0) continue;
    limited = true;
    const double share = allowed_share(*c, h, gained);
    for (const int u : c->speeds) displacement_[u] *= share;
  }
  if (limited) island.measure_gap_changes(displacement_.data());
}

// Of a component's displacement, such that no link moves by more, root mean square over its mass, than
// its own speed and that of recovery make in a step. None at all where a link would move by much more
// than any gap gains: joints hold it there, and motors would be wound up in vain.
double Stepper::allowed_share(const Component& c, double h, double gained) const {
  static thread_local std::vector<Spatial> moves;
  moves.assign(c.links.size(), Spatial());
  double share = 1.0;
  for (std::size_t i = 0; i < c.links.size(); ++i) {
    const std::size_t index = std::size_t(c.links[i]);
    const Link& link = mechanism_.links()[index];
    const LinkMotion& motion = mechanism_.motions()[index];
    Spatial& move = moves[i];
    if (c.linkage->inboard[i] >= 0) move = moves[std::size_t(c.linkage->inboard[i])];
    for (int k = c.linkage->first[i]; k < c.linkage->first[i] + link.nu; ++k) {
      const double d = displacement_[c.speeds[std::size_t(k)]];
      move.angular += d * c.linkage->motion[std::size_t(k)].angular;
      move.linear += d * c.linkage->motion[std::size_t(k)].linear;
    }
    const Placement& X = motion.X;
    const Vec3 com = X * link.com;
    const auto mean = [&](const Vec3& turn, const Vec3& shift) {
      const Vec3 local = X.R.transpose() * turn;
      return std::sqrt(shift.squaredNorm() + local.dot(link.inertia * local) / link.mass);
    };
    const double travel = mean(move.angular, move.linear + move.angular.cross(com - c.origin));
    const double most = h * (kRecoverySpeed + mean(motion.angular, motion.velocity_at(com)));
    if (travel > kLeastTravel + kMostTravel * gained) return 0.0;
    if (travel > most) share = std::min(share, most / travel);
  }
  return share;
}

void Stepper::warm_start_joints(double h) {
  if (!memory.had_rows || memory.efforts.empty()) return;
  for (Row& row : joints_.rows)
    if (row.slot >= 0)
      row.lambda = std::clamp(h * memory.efforts[std::size_t(row.slot)], row.low, row.high);
}

void Stepper::solve_island(double h, std::size_t number, Island& island) {
  island.clear();
  for (const int i : partition_.scalars.of(number)) {
    island.scalars.push_back(int(island.rows.size()));
    island.rows.push_back(joints_.rows[std::size_t(joints_.scalars[std::size_t(i)])]);
  }
  for (const int i : partition_.balls.of(number)) {
    const BallFriction& ball = joints_.balls[std::size_t(i)];
    island.balls.push_back({int(island.rows.size()), ball.bound});
    for (int k = 0; k < 3; ++k) island.rows.push_back(joints_.rows[std::size_t(ball.first + k)]);
  }
  for (const int i : partition_.manifolds.of(number))
    contacts_.add_rows(context_, std::size_t(i), memory.contacts, island);
  island.place_rows(mechanism_.components(), start_);

  island.scale(end_u_.data(), island.v);
  island.solve_velocities(options_.solver, h);
  island.unscale(island.v, end_u_.data());
  island.solve_positions(options_.solver, h);
  if (!island.p.empty()) island.unscale(island.p, displacement_.data());
  limit_displacements(h, island);

  contacts_.take_outcomes(island);
  for (const Row& row : island.rows)
    for (int s = 0; row.hits && row.lambda > 0.0 && s < 2 && row.size[s] > 0; ++s)
      hit_[std::size_t(row.component[s])] = 1;
  std::size_t at = 0;
  for (const int i : partition_.scalars.of(number))
    joints_.rows[std::size_t(joints_.scalars[std::size_t(i)])].lambda = island.rows[at++].lambda;
  for (const int i : partition_.balls.of(number))
    for (int k = 0; k < 3; ++k)
      joints_.rows[std::size_t(joints_.balls[std::size_t(i)].first + k)].lambda =
          island.rows[at++].lambda;
}

void Stepper::solve_islands(double h) {
  const std::size_t components = mechanism_.components().size();
  partition_.find(components, joints_, contacts_.manifolds());
  start_.assign(components, -1);
  hit_.assign(components, 0);
  const auto solve_one = [&](std::size_t i) {
    static thread_local Island island;  // so that small ones stay in the cache
    solve_island(h, i, island);
  };
  // Waking the others takes some 20 us, a point some 1 us.
  constexpr std::size_t kWorthWaking = 60;
  if (options_.pool && partition_.size() > 1 &&
      joints_.rows.size() + contacts_.points().size() > kWorthWaking) {
    options_.pool->run(partition_.size(), solve_one);
  } else {
    for (std::size_t i = 0; i < partition_.size(); ++i) solve_one(i);
  }
}

void Stepper::solve_rows(double h) {
  Mechanism& m = mechanism_;
  end_u_ = u0_;
  for (const Component& c : m.components())
    for (const int u : c.speeds) end_u_[u] = h * (udot_[u] - 0.5 * (*start_udot_)[u]);
  displacement_.setZero(m.state.nu());
  warm_start_joints(h);
  solve_islands(h);
  for (const Component& c : m.components())
    for (const int u : c.speeds) end_u_[u] += m.state.u()[u];
  sum_efforts(m.state.q(), m.state.u(), h, false);

  // q over the second half with u at the end, and the displacement of the position stage.
  displacement_ += 0.5 * h * end_u_;
  m.multiply_by_n(displacement_, displaced_);
  displaced_ += m.state.q();
  remember(h);
  report();
}

void Stepper::remember(double h) {
  memory.efforts.assign(std::size_t(RowBuilder::slot_count(model_)), 0.0);
  for (const Row& row : joints_.rows)
    if (row.slot >= 0) memory.efforts[std::size_t(row.slot)] = row.lambda / h;
  contacts_.remember(h, memory.contacts);
  predict_udot(h);
  // An impact's acceleration lasts no further step: what it met is carried to the next middle by the smooth
  // one, which has its gyroscopic terms.
  for (std::size_t i = 0; i < hit_.size(); ++i)
    if (hit_[i])
      for (int u : mechanism_.components()[i].speeds) memory.udot[u] = udot_[u];
  memory.had_rows = true;
}

// The first half of the next step takes the mean acceleration of the last, a, and, where the one before was near
// it, b, their line on to the middle of that half: a + 3/4 (a - b).
void Stepper::predict_udot(double h) {
  constexpr double kNear = 0.2;  // of a: as far as what turns by a fifth of a radian in a step
  const bool known = memory.mean_udot.size() == u0_.size();
  memory.udot = (1.0 / h) * (end_u_ - u0_);
  for (const Component& c : mechanism_.components()) {
    double change = 0.0, size = 0.0;
    for (std::size_t k = 0; known && k < c.speeds.size(); ++k) {
      const double a = memory.udot[c.speeds[k]], d = a - memory.mean_udot[c.speeds[k]];
      change += d * d;
      size += a * a;
    }
    if (change == 0.0 || change > kNear * kNear * size) continue;
    for (const int u : c.speeds) memory.udot[u] += 0.75 * (memory.udot[u] - memory.mean_udot[u]);
  }
  memory.mean_udot = (1.0 / h) * (end_u_ - u0_);
}

void Stepper::report() {
  for (const Row& row : joints_.rows) {
    if (row.coupling >= 0) {
      const Coupling& coupling = model_.couplings[std::size_t(row.coupling)];
      const auto add = [&](int joint, double factor) {
        impulses.joints[std::size_t(model_.joints[std::size_t(joint)].speed_offset)] +=
            factor * row.lambda;
      };
      add(coupling.joint, 1.0);
      for (const CouplingTerm& term : coupling.terms) add(term.joint, -term.ratio);
    }
    if (row.effort < 0) continue;
    impulses.joints[std::size_t(row.effort)] += row.effort_sign * row.lambda;
    if (row.motor >= 0) impulses.motors[std::size_t(row.motor)] += row.lambda;
  }
  for (const BallLimit& limit : joints_.ball_limits)
    for (int k = 0; k < 3; ++k)
      impulses.joints[std::size_t(limit.effort + k)] +=
          limit.direction[k] * joints_.rows[std::size_t(limit.row)].lambda;
  contacts_.report(records);
}

}  // namespace cogrsim::dynamics
