#include "stepper.h"

#include <algorithm>
#include <cmath>

#include "collision/contact_rates.h"

namespace cogrsim::dynamics {
namespace {

// Speculative margin of a body at rest [m], but not more than half its thickness: what is thinner would touch
// with its far side, too.
constexpr double kRestMargin = 1e-4;

// A cylinder whose ends are less than this, and this much of its length, apart in height touches
// along its whole line: contact leaves gaps of up to 1e-5 m (kTouching in rows.cpp) [m], [rad].
constexpr double kFlush = 1e-5;
constexpr double kTilt = 1e-3;

// Stages of Runge-Kutta disagree that would change speeds by more than this share of them. Laws that
// are only just not stiff (kExplicitLimit in drives.cpp) reach 0.03.
constexpr double kDoubt = 0.05;

// An overlap is left where a link would move by more than this times what the gap gains.
constexpr double kMostTravel = 10.0;

// One tree on a free base, tied to nothing else.
bool is_free(const Mechanism& mechanism, const Component& c) {
  for (std::size_t i = 0; i < c.links.size(); ++i) {
    const PlannedLink& plan = mechanism.links()[std::size_t(c.links[i])].plan;
    if ((c.inboard[i] < 0) != (i == 0) || (i == 0 && plan.joint >= 0)) return false;
  }
  for (const Weld& weld : c.welds)
    if (c.find(weld.primary) < 0) return false;
  return true;
}

}  // namespace

void StepMemory::clear() {
  contacts.clear();
  efforts.clear();
  udot.resize(0);
  mean_udot.resize(0);
  had_rows = false;
}

Stepper::Stepper(Mechanism& mechanism, Detector& detector, const StepperOptions& options)
    : mechanism_(mechanism),
      detector_(detector),
      options_(options),
      model_(mechanism.model()),
      accelerations_(mechanism),
      solver_(options.solver, options.pool.get()),
      laws_(make_laws(mechanism)),
      untouched_(mechanism.components().size(), 0),
      margins_(mechanism.links().size(), 0.0) {
  for (std::size_t i = 0; i < mechanism.components().size(); ++i) {
    const Component& c = mechanism.components()[i];
    if (c.is_free_body || !is_free(mechanism, c)) continue;
    momenta_.emplace_back();
    momenta_.back().component = int(i);
  }
  for (const Link& link : mechanism.links())
    has_shapes_ = has_shapes_ || detector.bounding_radius(link.plan.body) > 0.0;
  const int n = int(model_.materials.size());
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) surfaces_.push_back(surface_pair(model_, a, b));
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
  std::fill(impulses.joints.begin(), impulses.joints.end(), 0.0);
  std::fill(impulses.motors.begin(), impulses.motors.end(), 0.0);
  records.clear();
  for (const Link& link : mechanism_.links()) {
    if (!link.kinematic) continue;
    const Twist& twist = twists[std::size_t(link.plan.body)];
    double* const u = &mechanism_.state.change_u()[link.first_u];
    for (int k = 0; k < 3; ++k) {
      u[k] = twist.angular[k];
      u[3 + k] = twist.linear[k];
    }
  }
  if (mechanism_.state.nu() == 0) return;
  for (int i = 0; i < options_.substeps; ++i) move(dt / options_.substeps);
  const auto by_pair = [](const ContactRecord& a, const ContactRecord& b) {
    return a.collider_a != b.collider_a ? a.collider_a < b.collider_a : a.collider_b < b.collider_b;
  };
  // They come in this order; only where a step has parts may some be out of it.
  if (std::is_sorted(records.begin(), records.end(), by_pair)) return;
  std::stable_sort(records.begin(), records.end(), by_pair);
}

void Stepper::sum_efforts(const Values& q, const Values& u, double weight, bool untouched) {
  for (const AxisLaw& law : laws_) {
    if (law.implicit || bool(untouched_[std::size_t(law.component)]) != untouched) continue;
    const double impulse = weight * law.effort_at(q, u);
    impulses.joints[std::size_t(law.effort)] += impulse;
    if (law.motor >= 0) impulses.motors[std::size_t(law.motor)] += impulse;
  }
}

// How far each body's surface may get in the time h, from speeds at the state.
void Stepper::measure_speeds(double h) {
  const double fall = 0.5 * h * h * model_.physics.gravity.norm();
  const std::vector<LinkMotion>& motions = mechanism_.motions();
  for (std::size_t i = 0; i < margins_.size(); ++i) {
    const Link& link = mechanism_.links()[i];
    const double radius = detector_.bounding_radius(link.plan.body);
    if (link.plan.shadow || radius == 0.0) continue;
    const LinkMotion& motion = motions[i];
    const double spin = std::isfinite(radius) ? radius * motion.angular.norm() : 0.0;
    const double rest = std::min(kRestMargin, detector_.thinness(link.plan.body));
    margins_[i] = rest + fall + h * (motion.linear.norm() + spin);
  }
}

void Stepper::detect(double h) {
  points_.clear();
  if (!has_shapes_) return;
  const std::vector<Link>& links = mechanism_.links();
  const std::vector<LinkMotion>& motions = mechanism_.motions();
  offsets_.clear();
  for (std::size_t i = 0; i < links.size(); ++i) {
    const int body = links[i].plan.body;
    if (links[i].plan.shadow || detector_.bounding_radius(body) == 0.0) continue;
    Placement X = motions[i].X;
    const Vec3 offset = 0.5 * h * motions[i].velocity_at(X * links[i].com);
    double rest = 0.5 * h;
    if (offset.norm() > detector_.thinness(body)) {
      offsets_.resize(model_.bodies.size(), Vec3::Zero());
      offsets_[std::size_t(body)] = offset;
      X.p -= offset;
      rest = h;
    }
    detector_.set_pose(body, X, margins_[i], rest * motions[i].linear, rest * motions[i].angular);
  }
  detector_.detect(points_, options_.pool.get());
  if (offsets_.empty()) return;
  const std::vector<Collider>& colliders = detector_.colliders();
  for (ContactPoint& point : points_) {
    const Vec3& a = offsets_[std::size_t(colliders[std::size_t(point.collider_a)].body)];
    const Vec3& b = offsets_[std::size_t(colliders[std::size_t(point.collider_b)].body)];
    point.gap += point.normal.dot(b - a);
    point.point += 0.5 * (a + b);
  }
}

bool Stepper::same_pair(std::size_t index, std::size_t other) const {
  return other < points_.size() && points_[other].collider_a == points_[index].collider_a &&
         points_[other].collider_b == points_[index].collider_b;
}

RowBuilder::ContactLine Stepper::find_contact_line(std::size_t index) const {
  const auto round = [&](int collider) {
    const ShapeType type = detector_.colliders()[std::size_t(collider)].type;
    return type == ShapeType::cylinder || type == ShapeType::capsule;
  };
  RowBuilder::ContactLine line;
  if (!round(points_[index].collider_a) && !round(points_[index].collider_b)) return line;
  const bool before = same_pair(index, index - 1), after = same_pair(index, index + 1);
  if (before == after || (before && same_pair(index, index - 2)) ||
      (after && same_pair(index, index + 2)))
    return line;
  // A line lies across the normal; two ends of a pair with different normals are no line, nor are
  // ends of which one is off the ground, as of a coin that leans.
  const ContactPoint& other = points_[before ? index - 1 : index + 1];
  if (other.normal.dot(points_[index].normal) < 0.9999) return line;
  const double length = (other.point - points_[index].point).norm();
  if (std::abs(other.gap - points_[index].gap) > kFlush + kTilt * length) return line;
  line.other = &other;
  line.second = before;
  return line;
}

void Stepper::flatten(const Values& by_speed, std::vector<double>& out) const {
  const double* const in = by_speed.size() > 0 ? &by_speed[0] : nullptr;
  out.clear();
  for (const Component& c : mechanism_.components())
    for (int u : c.speeds) out.push_back(in[u]);
}

void Stepper::add_contact(const StepContext& context, std::size_t index,
                          RowBuilder& builder) const {
  const ContactPoint& point = points_[index];
  const Collider& a = detector_.colliders()[std::size_t(point.collider_a)];
  const Collider& b = detector_.colliders()[std::size_t(point.collider_b)];
  const RowBuilder::ContactLine line = find_contact_line(index);
  const Vec3 turning = turning_of(index, context.h);
  Vec3 friction_turning = turning;
  if (line.other)
    friction_turning =
        0.5 * (turning + turning_of(std::size_t(line.other - points_.data()), context.h));
  builder.add_contact(context, point, a.body, b.body, surface_of(point), line,
                      detector_.surface_velocity(point), turning, friction_turning);
}

Vec3 Stepper::convective_acceleration(int index, const Vec3& point) const {
  if (index < 0) return Vec3::Zero();
  const Link& link = mechanism_.links()[std::size_t(index)];
  const LinkMotion& motion = mechanism_.motions()[std::size_t(index)];
  const auto about = [&](const Vec3& centre) {
    return motion.angular.cross(motion.angular.cross(point - centre));
  };
  if (link.component < 0) return about(motion.X.p);
  const Component& c = mechanism_.components()[std::size_t(link.component)];
  if (c.is_free_body) return about(motion.X * link.com);
  return bias_at(c, c.find(index), motion, point);
}

Vec3 Stepper::turning_of(std::size_t index, double h) const {
  const ContactPoint& point = points_[index];
  const Collider& a = detector_.colliders()[std::size_t(point.collider_a)];
  const Collider& b = detector_.colliders()[std::size_t(point.collider_b)];
  const int link_a = mechanism_.body_link(a.body), link_b = mechanism_.body_link(b.body);
  static const LinkMotion rest;
  const std::vector<LinkMotion>& motions = mechanism_.motions();
  const LinkMotion& motion_a = link_a < 0 ? rest : motions[std::size_t(link_a)];
  const LinkMotion& motion_b = link_b < 0 ? rest : motions[std::size_t(link_b)];
  const Vec3& n = point.normal;
  const Vec3 v = motion_b.velocity_at(point.point) - motion_a.velocity_at(point.point);
  const Vec3 slip = v - n.dot(v) * n;
  const ContactRates rates =
      find_contact_rates(a, b, point, !same_pair(index, index - 1) && !same_pair(index, index + 1),
                         motion_a.angular, motion_b.angular, slip);
  const Vec3 turning = convective_acceleration(link_b, point.point) -
                       convective_acceleration(link_a, point.point) +
                       motion_b.angular.cross(rates.on_b) - motion_a.angular.cross(rates.on_a) +
                       rates.normal.dot(slip) * n;
  // A turn of more than a radian in a step is none that a derivative continues.
  const double turn = h * std::max(motion_a.angular.norm(), motion_b.angular.norm());
  const double share = 1.0 / (1.0 + turn * turn * turn * turn);
  return turning.allFinite() && std::isfinite(share) ? Vec3(share * turning) : Vec3::Zero();
}

const SurfacePair& Stepper::surface_of(const ContactPoint& point) const {
  const int a = detector_.colliders()[std::size_t(point.collider_a)].material;
  const int b = detector_.colliders()[std::size_t(point.collider_b)].material;
  return surfaces_[std::size_t(a) * model_.materials.size() + std::size_t(b)];
}

bool Stepper::add_free_contacts(const StepContext& context) {
  if (!options_.pool || points_.size() < 2 * kChunk) return false;
  const RowBuilder measure(mechanism_, set_);
  begins_.resize(points_.size());
  RowEnds end{set_.rows.size(), set_.pool.size(), set_.contacts.size()};
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const int a = detector_.colliders()[std::size_t(points_[i].collider_a)].body;
    const int b = detector_.colliders()[std::size_t(points_[i].collider_b)].body;
    const RowEnds size =
        measure.measure_contact(a, b, surface_of(points_[i]), find_contact_line(i));
    if (size.pool == 0 || measure.jointed(mechanism_.body_link(a)) ||
        measure.jointed(mechanism_.body_link(b)))
      return false;
    begins_[i] = end;
    end = {end.rows + size.rows, end.pool + size.pool, end.contacts + size.contacts};
  }
  set_.rows.resize(end.rows);
  set_.pool.resize(end.pool);
  set_.contacts.resize(end.contacts);
  options_.pool->run((points_.size() + kChunk - 1) / kChunk, [&](std::size_t number) {
    const std::size_t first = number * kChunk;
    RowBuilder builder(mechanism_, set_, begins_[first]);
    for (std::size_t i = first; i < std::min(first + kChunk, points_.size()); ++i)
      add_contact(context, i, builder);
  });
  return true;
}

bool Stepper::build_rows(double h) {
  StepContext context;
  context.h = h;
  context.bounce_threshold = model_.physics.bounce_threshold;
  flatten(mechanism_.state.u(), row_u_);
  flatten(start_udot_, row_start_);
  flatten(udot_, row_udot_);
  context.u = row_u_.data();
  context.start_udot = row_start_.data();
  context.udot = row_udot_.data();
  context.start_q = &q0_;
  context.start_u = &u0_;
  set_.clear();
  RowBuilder builder(mechanism_, set_);
  builder.add_joint_rows(context, laws_);
  if (!add_free_contacts(context))
    for (std::size_t i = 0; i < points_.size(); ++i) add_contact(context, i, builder);
  std::fill(untouched_.begin(), untouched_.end(), 1);
  const auto touch = [&](const Row& row) {
    for (int k = 0; k < row.sides; ++k) untouched_[std::size_t(row.side[k].component)] = 0;
  };
  for (std::size_t i = 0; i < set_.joint_rows(); ++i) touch(set_.rows[i]);
  for (const ContactRows& contact : set_.contacts) touch(set_.rows[std::size_t(contact.first)]);
  return !set_.empty();
}

void Stepper::move(double h) {
  Mechanism& m = mechanism_;
  q0_ = m.state.q();
  u0_ = m.state.u();
  m.calc_qdot(qdot0_);
  classify_laws(m, *drives_, h, laws_);
  measure_speeds(h);
  measure_momenta(false);

  // To the middle of the step: positions by the speeds at the start; speeds by the acceleration of
  // the last step where contact was on then, so that steps with contact cost one evaluation.
  const bool remembered = memory.had_rows && memory.udot.size() == u0_.size();
  accelerations_.with_rows = remembered;
  if (remembered) {
    start_udot_ = memory.udot;
  } else {
    accelerations_.compute(laws_, start_udot_);
    k_[0] = start_udot_;
  }
  qm_ = q0_ + (0.5 * h) * qdot0_;
  um_ = u0_ + (0.5 * h) * start_udot_;
  set(qm_, um_);
  const Accelerations::Middle middle{h, &start_udot_};
  const bool smooth = !remembered && options_.scheme != Scheme::midpoint;
  accelerations_.compute(laws_, udot_, smooth ? nullptr : &middle);
  detect(h);
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
                            !c.is_free_body && c.size() > 0);
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
  qk_[0] = qdot0_;
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
  if (c.welds.empty()) return false;
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
  displaced_ = q0_ + (0.5 * h) * qdot0_;
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

void Stepper::limit_displacements(double h) {
  constexpr double kNone = -1.0;
  static thread_local std::vector<double> gained;  // most by which a gap of the component opens [m]
  gained.assign(mechanism_.components().size(), kNone);
  bool deep = false;
  for (const ContactRows& contact : set_.contacts) {
    const Row& row = set_.rows[std::size_t(contact.first)];
    for (int s = 0; row.deep && s < row.sides; ++s) {
      double& most = gained[std::size_t(row.side[s].component)];
      most = std::max({most, row.gap_change, 0.0});
      deep = true;
    }
  }
  if (!deep) return;
  for (const Component& c : mechanism_.components()) {
    const double gain = gained[std::size_t(&c - mechanism_.components().data())];
    if (gain < 0.0 || c.is_free_body) continue;
    const double share = allowed_share(c, h, gain);
    for (int k = 0; k < c.size(); ++k) displacement_[std::size_t(c.offset + k)] *= share;
  }
  for (Row& row : set_.rows)
    if (row.has_gap) row.gap_change = set_.along(row, displacement_.data());
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
    if (c.inboard[i] >= 0) move = moves[std::size_t(c.inboard[i])];
    for (int k = c.first[i]; k < c.first[i] + link.nu; ++k) {
      const double d = displacement_[std::size_t(c.offset + k)];
      move.angular += d * c.motion[std::size_t(k)].angular;
      move.linear += d * c.motion[std::size_t(k)].linear;
    }
    const Placement& X = motion.X;
    const Vec3 com = X * link.com;
    const auto mean = [&](const Vec3& turn, const Vec3& shift) {
      const Vec3 local = X.R.transpose() * turn;
      return std::sqrt(shift.squaredNorm() + local.dot(link.inertia * local) / link.mass);
    };
    const double travel = mean(move.angular, move.linear + move.angular.cross(com - c.origin));
    const double most = h * (kRecoverySpeed + mean(motion.angular, motion.velocity_at(com)));
    if (travel > kFlush + kMostTravel * gained) return 0.0;
    if (travel > most) share = std::min(share, most / travel);
  }
  return share;
}

void Stepper::solve_rows(double h) {
  Mechanism& m = mechanism_;
  int speeds = 0;
  for (const Component& c : m.components()) speeds += c.size();
  dv_.assign(std::size_t(speeds), 0.0);
  displacement_.assign(std::size_t(speeds), 0.0);
  const double* const udot = udot_.data();
  const double* const start_udot = start_udot_.data();
  for (const Component& c : m.components())
    for (int k = 0; k < c.size(); ++k) {
      const int u = c.speeds[std::size_t(k)];
      dv_[std::size_t(c.offset + k)] = h * (udot[u] - 0.5 * start_udot[u]);
    }
  warm_start(h);
  for_contact_chunks(
      [&](std::size_t, std::size_t first, std::size_t end) { balance_pairs(h, first, end); });
  solver_.solve(set_, m.components(), h, dv_.data(), displacement_.data());
  limit_displacements(h);
  sum_efforts(m.state.q(), m.state.u(), h, false);

  // u at the end; q over the second half with it, and the displacement of the position stage.
  end_u_ = u0_;
  stage_ = u0_;
  const double* const middle_u = um_.data();
  double* const end_u = end_u_.data();
  double* const second_half = stage_.data();
  stage_ *= 0.5 * h;
  for (const Component& c : m.components())
    for (int k = 0; k < c.size(); ++k) {
      const int u = c.speeds[std::size_t(k)];
      end_u[u] = middle_u[u] + dv_[std::size_t(c.offset + k)];
      second_half[u] = 0.5 * h * end_u[u] + displacement_[std::size_t(c.offset + k)];
    }
  m.multiply_by_n(stage_, displaced_);
  displaced_ = displaced_ + qm_;
  contact_impulses_.resize(set_.contacts.size());
  for_contact_chunks([&](std::size_t, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) contact_impulses_[i] = impulse_of(set_.contacts[i]);
  });
  remember(h);
  report();
}

}  // namespace cogrsim::dynamics
