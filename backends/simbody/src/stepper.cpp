#include "stepper.h"

#include <algorithm>
#include <cmath>

namespace cogrsim::simbody {
namespace {

// Two surfaces nearer than twice this are watched even when nothing moves [m].
constexpr double kWatch = 1e-4;
// In an impact, what is nearer than this takes part [m].
constexpr double kImpactGap = 1e-4;
constexpr int kMostSplits = 8;
// Contact points of successive steps that are nearer than this are the same point [m].
constexpr double kSamePoint = 0.02;

}  // namespace

void StepMemory::clear() {
  contacts.clear();
  efforts.clear();
  udot.clear();
  had_rows = false;
}

Stepper::Stepper(Mechanism& mechanism, Detector& detector, const StepperOptions& options)
    : mechanism_(mechanism),
      detector_(detector),
      options_(options),
      model_(mechanism.model()),
      accelerations_(mechanism),
      laws_(make_laws(mechanism)),
      margins_(mechanism.links().size(), 0.0) {
  for (const Link& link : mechanism.links())
    has_shapes_ = has_shapes_ || detector.reach(link.plan.body) > 0.0;
  const int n = int(model_.materials.size());
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) surfaces_.push_back(surface_pair(model_, a, b));
  impulses.joints.assign(std::size_t(model_.joint_speeds), 0.0);
  impulses.motors.assign(model_.motors.size(), 0.0);
}

void Stepper::set(const SimTK::Vector& q, const SimTK::Vector& u) {
  mechanism_.state.updQ() = q;
  mechanism_.state.updU() = u;
  for (Component& c : mechanism_.components()) c.current = false;
}

void Stepper::advance(double dt, const std::vector<Drive>& drives,
                      const std::vector<Twist>& twists) {
  drives_ = &drives;
  std::fill(impulses.joints.begin(), impulses.joints.end(), 0.0);
  std::fill(impulses.motors.begin(), impulses.motors.end(), 0.0);
  records.clear();
  for (const Link& link : mechanism_.links()) {
    if (!link.kinematic) continue;
    const Twist& twist = twists[std::size_t(link.plan.body)];
    double* const u = &mechanism_.state.updU()[link.first_u];
    for (int k = 0; k < 3; ++k) {
      u[k] = twist.angular[k];
      u[3 + k] = twist.linear[k];
    }
  }
  for (int i = 0; i < options_.substeps; ++i) {
    double rest = dt / options_.substeps;
    for (int split = 0; rest > 0.0; ++split) {
      const double done = move(rest, split < kMostSplits ? Impacts::split : Impacts::keep);
      if (done == rest) break;
      rest -= done;
    }
  }
  std::stable_sort(records.begin(), records.end(), [](const auto& a, const auto& b) {
    return a.collider_a != b.collider_a ? a.collider_a < b.collider_a
                                        : a.collider_b < b.collider_b;
  });
}

void Stepper::sum_efforts(const SimTK::Vector& q, const SimTK::Vector& u, double weight) {
  for (const AxisLaw& law : laws_) {
    if (law.implicit) continue;
    const double impulse = weight * law.effort_at(q, u);
    impulses.joints[std::size_t(law.effort)] += impulse;
    if (law.motor >= 0) impulses.motors[std::size_t(law.motor)] += impulse;
  }
}

// How far each body's surface may get in the time h, from speeds at the state.
void Stepper::measure_speeds(double h) {
  const double fall = 0.5 * h * h * model_.physics.gravity.norm();
  for (std::size_t i = 0; i < margins_.size(); ++i) {
    const Link& link = mechanism_.links()[i];
    const double reach = detector_.reach(link.plan.body);
    if (link.plan.ghost || reach == 0.0) continue;
    const SimTK::SpatialVec& V = link.mobod.getBodyVelocity(mechanism_.state);
    margins_[i] = kWatch + fall + h * (V[1].norm() + (std::isfinite(reach) ? reach * V[0].norm() : 0));
  }
}

void Stepper::detect() {
  points_.clear();
  if (!has_shapes_) return;
  const std::vector<Link>& links = mechanism_.links();
  for (std::size_t i = 0; i < links.size(); ++i) {
    const int body = links[i].plan.body;
    if (links[i].plan.ghost || detector_.reach(body) == 0.0) continue;
    detector_.place(body, mechanism_.placement(links[i]), margins_[i]);
  }
  detector_.detect(points_);
}

bool Stepper::build_rows(double h, Impacts impacts) {
  StepContext context;
  context.h = h;
  context.bounce_threshold = model_.physics.bounce_threshold;
  context.start_udot = &start_udot_;
  context.udot = &udot_;
  context.start_q = &q0_;
  context.start_u = &u0_;
  set_.clear();
  RowBuilder builder(mechanism_, set_);
  builder.add_joint_rows(context, laws_);
  const std::vector<Collider>& colliders = detector_.colliders();
  const std::size_t materials = model_.materials.size();
  for (const ContactPoint& point : points_) {
    const Collider& a = colliders[std::size_t(point.collider_a)];
    const Collider& b = colliders[std::size_t(point.collider_b)];
    if (h == 0.0 && point.gap > kImpactGap) continue;
    const std::size_t before = set_.contacts.size();
    builder.add_contact(context, point, a.body, b.body,
                        surfaces_[std::size_t(a.material) * materials + std::size_t(b.material)]);
    if (set_.contacts.size() == before || impacts != Impacts::drop) continue;
    const ContactRows& added = set_.contacts.back();
    if (added.articulated && added.approach > context.bounce_threshold) {
      set_.rows.resize(std::size_t(added.first));
      set_.contacts.pop_back();
    }
  }
  return !set_.empty();
}

double Stepper::first_impact() const {
  double first = -1.0;
  for (const ContactRows& c : set_.contacts) {
    if (!c.articulated || c.approach <= model_.physics.bounce_threshold) continue;
    if (first < 0.0 || c.hit_time < first) first = c.hit_time;
  }
  return first;
}

double Stepper::move(double h, Impacts impacts) {
  Mechanism& m = mechanism_;
  m.realize_velocity();
  q0_ = m.state.getQ();
  u0_ = m.state.getU();
  qdot0_ = m.state.getQDot();
  for (Component& c : m.components()) c.current = false;
  classify_laws(m, *drives_, h, laws_);
  measure_speeds(h);

  // To the middle of the step: positions by the speeds at the start; speeds by the acceleration of
  // the last step where contact was on then, so that steps with contact cost one evaluation.
  const bool remembered = memory.had_rows && memory.udot.size() == u0_.size();
  if (remembered) {
    start_udot_ = memory.udot;
  } else {
    accelerations_.compute(laws_, start_udot_);
    k_[0] = start_udot_;
  }
  qm_ = q0_;
  qm_ += (0.5 * h) * qdot0_;
  um_ = u0_;
  um_ += (0.5 * h) * start_udot_;
  set(qm_, um_);
  accelerations_.compute(laws_, udot_);
  detect();
  const bool rows = build_rows(h, impacts);

  if (!rows && options_.scheme != Scheme::midpoint) {
    runge_kutta(h, !remembered);
    memory.clear();
    return h;
  }
  const double hit = impacts == Impacts::split ? first_impact() : -1.0;
  if (hit >= 0.0) {
    set(q0_, u0_);
    constexpr double kNoTime = 1e-3;  // of the step: not worth a step of its own
    double run = 0.0;
    if (hit > kNoTime * h) run = move(hit > (1.0 - kNoTime) * h ? h : hit, Impacts::drop);
    kick();
    return run;
  }
  finish_with_rows(h);
  return h;
}

void Stepper::runge_kutta(double h, bool have_first) {
  Mechanism& m = mechanism_;
  const auto evaluate = [&](int stage) {
    accelerations_.compute(laws_, k_[stage]);
    qk_[stage] = m.state.getQDot();
  };
  const auto go_to = [&](double step, int from) {
    displaced_ = q0_;
    displaced_ += step * qk_[from];
    stage_ = u0_;
    stage_ += step * k_[from];
    set(displaced_, stage_);
  };
  qk_[0] = qdot0_;
  if (have_first) {
    k_[1] = udot_;
    qk_[1] = m.state.getQDot();
  } else {
    set(q0_, u0_);
    evaluate(0);
    go_to(0.5 * h, 0);
    evaluate(1);
  }
  sum_efforts(q0_, u0_, h / 6);
  sum_efforts(m.state.getQ(), m.state.getU(), h / 3);
  go_to(0.5 * h, 1);
  evaluate(2);
  sum_efforts(m.state.getQ(), m.state.getU(), h / 3);
  go_to(h, 2);
  evaluate(3);
  sum_efforts(m.state.getQ(), m.state.getU(), h / 6);

  displaced_ = q0_;
  stage_ = u0_;
  for (int i = 0; i < 4; ++i) {
    const double weight = (i == 0 || i == 3) ? h / 6 : h / 3;
    displaced_ += weight * qk_[i];
    stage_ += weight * k_[i];
  }
  set(displaced_, stage_);
  m.project();
}

void Stepper::finish_with_rows(double h) {
  Mechanism& m = mechanism_;
  int speeds = 0;
  for (const Component& c : m.components()) speeds += c.size();
  dv_.assign(std::size_t(speeds), 0.0);
  displacement_.assign(std::size_t(speeds), 0.0);
  for (const Component& c : m.components())
    for (int k = 0; k < c.size(); ++k) {
      const int u = c.speeds[std::size_t(k)];
      dv_[std::size_t(c.offset + k)] = h * (udot_[u] - 0.5 * start_udot_[u]);
    }
  warm_start(h);
  solve_velocities(options_.solver, set_, dv_.data());
  solve_positions(options_.solver, set_, dv_.data(), h, displacement_.data());
  sum_efforts(m.state.getQ(), m.state.getU(), h);

  // u at the end; q over the second half with it, and the displacement of the position stage.
  end_u_ = u0_;
  stage_ = (0.5 * h) * u0_;
  for (const Component& c : m.components())
    for (int k = 0; k < c.size(); ++k) {
      const int u = c.speeds[std::size_t(k)];
      end_u_[u] = um_[u] + dv_[std::size_t(c.offset + k)];
      stage_[u] = 0.5 * h * end_u_[u] + displacement_[std::size_t(c.offset + k)];
    }
  m.matter.multiplyByN(m.state, false, stage_, displaced_);
  displaced_ += qm_;
  remember(h);
  report();
  set(displaced_, end_u_);
  m.project();
}

void Stepper::kick() {
  Mechanism& m = mechanism_;
  m.realize_velocity();
  um_ = m.state.getU();
  start_udot_ = um_;
  start_udot_ = 0.0;
  udot_ = start_udot_;
  std::fill(margins_.begin(), margins_.end(), kImpactGap);
  detect();
  memory.clear();
  if (!build_rows(0.0, Impacts::keep)) return;
  int speeds = 0;
  for (const Component& c : m.components()) speeds += c.size();
  dv_.assign(std::size_t(speeds), 0.0);
  solve_velocities(options_.solver, set_, dv_.data());
  report();
  SimTK::Vector& u = m.state.updU();
  for (const Component& c : m.components())
    for (int k = 0; k < c.size(); ++k)
      u[c.speeds[std::size_t(k)]] += dv_[std::size_t(c.offset + k)];
}

void Stepper::warm_start(double h) {
  if (!memory.had_rows) return;
  if (!memory.efforts.empty()) {
    for (Row& row : set_.rows)
      if (row.slot >= 0)
        row.lambda = std::clamp(h * memory.efforts[std::size_t(row.slot)], row.low, row.high);
  }
  std::size_t at = 0;
  static thread_local std::vector<char> taken;
  taken.assign(memory.contacts.size(), 0);
  for (const ContactRows& contact : set_.contacts) {
    const ContactPoint& point = contact.point;
    const auto before = [&](const StepMemory::WarmContact& w) {
      return w.collider_a != point.collider_a ? w.collider_a < point.collider_a
                                              : w.collider_b < point.collider_b;
    };
    while (at < memory.contacts.size() && before(memory.contacts[at])) ++at;
    const Placement& X_b = detector_.colliders()[std::size_t(point.collider_b)].X_WS;
    const Vec3 place = X_b.to_local(point.point);
    double nearest = kSamePoint * kSamePoint;
    std::size_t best = memory.contacts.size();
    for (std::size_t i = at; i < memory.contacts.size(); ++i) {
      const StepMemory::WarmContact& w = memory.contacts[i];
      if (w.collider_a != point.collider_a || w.collider_b != point.collider_b) break;
      const double d = (w.place - place).squaredNorm();
      if (!taken[i] && d < nearest) {
        nearest = d;
        best = i;
      }
    }
    if (best == memory.contacts.size()) continue;
    taken[best] = 1;
    const Vec3 impulse = h * memory.contacts[best].force;
    Row* const rows = &set_.rows[std::size_t(contact.first)];
    rows[0].lambda = std::max(impulse.dot(point.normal), 0.0);
    if (contact.friction <= 0.0) continue;
    rows[1].lambda = impulse.dot(contact.tangent1);
    rows[2].lambda = impulse.dot(contact.tangent2);
  }
}

void Stepper::remember(double h) {
  memory.contacts.clear();
  memory.efforts.assign(std::size_t(RowBuilder::slot_count(model_)), 0.0);
  for (const Row& row : set_.rows)
    if (row.slot >= 0) memory.efforts[std::size_t(row.slot)] = row.lambda / h;
  for (const ContactRows& contact : set_.contacts) {
    const Row* const rows = &set_.rows[std::size_t(contact.first)];
    if (rows[0].lambda <= 0.0) continue;
    StepMemory::WarmContact w;
    w.collider_a = contact.point.collider_a;
    w.collider_b = contact.point.collider_b;
    const Placement& X_b = detector_.colliders()[std::size_t(w.collider_b)].X_WS;
    w.place = X_b.to_local(contact.point.point);
    w.force = rows[0].lambda * contact.point.normal;
    if (contact.friction > 0.0)
      w.force += rows[1].lambda * contact.tangent1 + rows[2].lambda * contact.tangent2;
    w.force /= h;
    memory.contacts.push_back(w);
  }
  memory.udot = end_u_;
  memory.udot -= u0_;
  memory.udot *= 1.0 / h;
  memory.had_rows = true;
}

void Stepper::report() {
  for (const Row& row : set_.rows) {
    if (row.effort < 0) continue;
    impulses.joints[std::size_t(row.effort)] += row.effort_sign * row.lambda;
    if (row.motor >= 0) impulses.motors[std::size_t(row.motor)] += row.lambda;
  }
  for (const BallLimit& limit : set_.ball_limits)
    for (int k = 0; k < 3; ++k)
      impulses.joints[std::size_t(limit.effort + k)] +=
          limit.direction[k] * set_.rows[std::size_t(limit.row)].lambda;
  const std::size_t earlier = records.size();
  for (const ContactRows& contact : set_.contacts) {
    const Row* const rows = &set_.rows[std::size_t(contact.first)];
    Vec3 impulse = rows[0].lambda * contact.point.normal;
    if (contact.friction > 0.0)
      impulse += rows[1].lambda * contact.tangent1 + rows[2].lambda * contact.tangent2;
    if (rows[0].lambda <= 0.0 && contact.point.gap > 0.0) continue;
    // A step that was split touches the same point twice.
    ContactRecord* same = nullptr;
    for (std::size_t i = 0; i < earlier && !same; ++i) {
      ContactRecord& r = records[i];
      if (r.collider_a == contact.point.collider_a && r.collider_b == contact.point.collider_b &&
          (r.point - contact.point.point).norm() < kSamePoint)
        same = &r;
    }
    if (!same) {
      records.emplace_back();
      same = &records.back();
    }
    same->collider_a = contact.point.collider_a;
    same->collider_b = contact.point.collider_b;
    same->point = contact.point.point;
    same->normal = contact.point.normal;
    same->gap = rows[0].has_gap ? rows[0].gap + rows[0].settled : contact.point.gap;
    same->impulse += impulse;
  }
}

}  // namespace cogrsim::simbody
