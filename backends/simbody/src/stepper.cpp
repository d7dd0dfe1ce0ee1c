#include "stepper.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cogrsim/physics/friction_share.h"

namespace cogrsim::simbody {
namespace {

// Two surfaces nearer than twice this are watched even when nothing moves [m].
constexpr double kWatch = 1e-4;
// Contact points of successive steps that are nearer than this are the same point [m].
constexpr double kSamePoint = 0.02;

// One tree on a free base, tied to nothing else.
bool is_free(const Mechanism& mechanism, const Component& c) {
  for (std::size_t i = 0; i < c.links.size(); ++i) {
    const PlannedLink& plan = mechanism.links()[std::size_t(c.links[i])].plan;
    if ((c.inboard[i] < 0) != (i == 0) || (i == 0 && plan.joint >= 0)) return false;
  }
  for (const Weld& weld : c.welds)
    if (c.find(weld.master) < 0) return false;
  return true;
}

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
      solver_(options.solver),
      laws_(make_laws(mechanism)),
      untouched_(mechanism.components().size(), 0),
      margins_(mechanism.links().size(), 0.0) {
  for (std::size_t i = 0; i < mechanism.components().size(); ++i) {
    const Component& c = mechanism.components()[i];
    if (c.lone || !is_free(mechanism, c)) continue;
    momenta_.emplace_back();
    momenta_.back().component = int(i);
  }
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
  if (mechanism_.state.getNU() == 0) return;
  for (int i = 0; i < options_.substeps; ++i) move(dt / options_.substeps);
  std::stable_sort(records.begin(), records.end(), [](const auto& a, const auto& b) {
    return a.collider_a != b.collider_a ? a.collider_a < b.collider_a : a.collider_b < b.collider_b;
  });
}

void Stepper::sum_efforts(const SimTK::Vector& q, const SimTK::Vector& u, double weight,
                          bool untouched) {
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
    const double reach = detector_.reach(link.plan.body);
    if (link.plan.ghost || reach == 0.0) continue;
    const LinkMotion& motion = motions[i];
    const double spin = std::isfinite(reach) ? reach * motion.angular.norm() : 0.0;
    margins_[i] = kWatch + fall + h * (motion.linear.norm() + spin);
  }
}

void Stepper::detect() {
  points_.clear();
  if (!has_shapes_) return;
  const std::vector<Link>& links = mechanism_.links();
  const std::vector<LinkMotion>& motions = mechanism_.motions();
  for (std::size_t i = 0; i < links.size(); ++i) {
    const int body = links[i].plan.body;
    if (links[i].plan.ghost || detector_.reach(body) == 0.0) continue;
    detector_.place(body, motions[i].X, margins_[i]);
  }
  detector_.detect(points_);
}

RowBuilder::Line Stepper::find_line(std::size_t index) const {
  const auto pair_with = [&](std::size_t other) {
    return other < points_.size() && points_[other].collider_a == points_[index].collider_a &&
           points_[other].collider_b == points_[index].collider_b;
  };
  const auto round = [&](int collider) {
    const ShapeType type = detector_.colliders()[std::size_t(collider)].type;
    return type == ShapeType::cylinder || type == ShapeType::capsule;
  };
  RowBuilder::Line line;
  if (!round(points_[index].collider_a) && !round(points_[index].collider_b)) return line;
  const bool before = pair_with(index - 1), after = pair_with(index + 1);
  if (before == after || (before && pair_with(index - 2)) || (after && pair_with(index + 2)))
    return line;
  // A line lies across the normal; two ends of a pair with different normals are no line.
  const ContactPoint& other = points_[before ? index - 1 : index + 1];
  if (other.normal.dot(points_[index].normal) < 0.9999) return line;
  line.other = &other;
  line.second = before;
  return line;
}

void Stepper::flatten(const SimTK::Vector& by_speed, std::vector<double>& out) const {
  const double* const in = by_speed.size() > 0 ? &by_speed[0] : nullptr;
  out.clear();
  for (const Component& c : mechanism_.components())
    for (int u : c.speeds) out.push_back(in[u]);
}

bool Stepper::build_rows(double h) {
  StepContext context;
  context.h = h;
  context.bounce_threshold = model_.physics.bounce_threshold;
  flatten(mechanism_.state.getU(), row_u_);
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
  const std::vector<Collider>& colliders = detector_.colliders();
  const std::size_t materials = model_.materials.size();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactPoint& point = points_[i];
    const Collider& a = colliders[std::size_t(point.collider_a)];
    const Collider& b = colliders[std::size_t(point.collider_b)];
    builder.add_contact(context, point, a.body, b.body,
                        surfaces_[std::size_t(a.material) * materials + std::size_t(b.material)],
                        find_line(i));
  }
  std::fill(untouched_.begin(), untouched_.end(), 1);
  for (const Row& row : set_.rows)
    for (int k = 0; k < row.sides; ++k) untouched_[std::size_t(row.side[k].component)] = 0;
  return !set_.empty();
}

void Stepper::move(double h) {
  Mechanism& m = mechanism_;
  m.realize_velocity();
  q0_ = m.state.getQ();
  u0_ = m.state.getU();
  qdot0_ = m.state.getQDot();
  for (Component& c : m.components()) c.current = false;
  classify_laws(m, *drives_, h, laws_);
  measure_speeds(h);
  measure_momenta();

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
  const bool rows = build_rows(h);

  if (!rows && options_.scheme != Scheme::midpoint) {
    runge_kutta(h, !remembered);
    memory.clear();
    set(displaced_, stage_);
    m.project();
    return;
  }
  // Mechanisms that nothing concerns are integrated as if the rest were not there.
  bool apart = false;
  for (const Component& c : m.components())
    apart =
        apart || (untouched_[std::size_t(&c - m.components().data())] && !c.lone && c.size() > 0);
  apart = apart && options_.scheme != Scheme::midpoint;
  if (!apart) std::fill(untouched_.begin(), untouched_.end(), 0);
  solve_rows(h);
  if (apart) {
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
  sum_efforts(q0_, u0_, h / 6, true);
  sum_efforts(m.state.getQ(), m.state.getU(), h / 3, true);
  go_to(0.5 * h, 1);
  evaluate(2);
  sum_efforts(m.state.getQ(), m.state.getU(), h / 3, true);
  go_to(h, 2);
  evaluate(3);
  sum_efforts(m.state.getQ(), m.state.getU(), h / 6, true);

  displaced_ = q0_;
  stage_ = u0_;
  for (int i = 0; i < 4; ++i) {
    const double weight = (i == 0 || i == 3) ? h / 6 : h / 3;
    displaced_ += weight * qk_[i];
    stage_ += weight * k_[i];
  }
}

void Stepper::solve_rows(double h) {
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
  balance_pairs();
  solver_.solve_velocities(set_, dv_.data());
  solver_.solve_positions(set_, h, displacement_.data());
  sum_efforts(m.state.getQ(), m.state.getU(), h, false);

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
  contact_impulses_.clear();
  for (const ContactRows& contact : set_.contacts) contact_impulses_.push_back(impulse_of(contact));
  remember(h);
  report();
}

void Stepper::measure_momenta() {
  const Mechanism& m = mechanism_;
  if (momenta_.empty()) return;
  const std::vector<LinkMotion>& motions = m.motions();
  for (FreeMomentum& f : momenta_) {
    const Component& c = mechanism_.components()[std::size_t(f.component)];
    f.mass = 0.0;
    f.com = f.linear = f.angular = Vec3::Zero();
    Mat3 about_origin = Mat3::Zero();
    for (int index : c.links) {
      const Link& link = m.links()[std::size_t(index)];
      const LinkMotion& motion = motions[std::size_t(index)];
      const Placement& X = motion.X;
      const Vec3 p = X * link.com, omega = motion.angular;
      const Vec3 momentum = link.mass * motion.velocity_at(p);
      const Mat3 inertia = X.R * link.inertia * X.R.transpose();
      f.mass += link.mass;
      f.com += link.mass * p;
      f.linear += momentum;
      f.angular += inertia * omega + p.cross(momentum);
      about_origin +=
          inertia + link.mass * (p.squaredNorm() * Mat3::Identity() - p * p.transpose());
    }
    f.com /= f.mass;
    f.inertia = about_origin -
                f.mass * (f.com.squaredNorm() * Mat3::Identity() - f.com * f.com.transpose());
  }
}

void Stepper::conserve_momentum(double h) {
  Mechanism& m = mechanism_;
  if (momenta_.empty()) return;
  const std::vector<FreeMomentum> start = momenta_;
  m.realize_velocity();
  measure_momenta();
  // Impulses of contact, by component.
  struct Gain {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  };
  std::vector<Gain> gained(m.components().size());
  for (std::size_t index = 0; index < set_.contacts.size(); ++index) {
    const ContactRows& contact = set_.contacts[index];
    const int bodies[2] = {detector_.colliders()[std::size_t(contact.point.collider_a)].body,
                           detector_.colliders()[std::size_t(contact.point.collider_b)].body};
    for (int side = 0; side < 2; ++side) {
      const int link = m.body_link(bodies[side]);
      const int component = link < 0 ? -1 : m.links()[std::size_t(link)].component;
      if (component < 0) continue;
      const Vec3 impulse = (side == 0 ? -1.0 : 1.0) * contact_impulses_[index];
      gained[std::size_t(component)].linear += impulse;
      gained[std::size_t(component)].angular += contact.point.point.cross(impulse);
    }
  }
  const std::vector<LinkMotion>& motions = m.motions();
  for (std::size_t i = 0; i < momenta_.size(); ++i) {
    const FreeMomentum& end = momenta_[i];
    if (untouched_[std::size_t(end.component)]) continue;
    const Vec3 weight = h * end.mass * model_.physics.gravity;
    Vec3 linear = start[i].linear + weight - end.linear;
    Vec3 angular = start[i].angular + (0.5 * (start[i].com + end.com)).cross(weight) - end.angular;
    linear += gained[std::size_t(end.component)].linear;
    angular += gained[std::size_t(end.component)].angular;
    const Vec3 omega = end.inertia.inverse() * (angular - end.com.cross(linear));
    const int first = m.components()[std::size_t(end.component)].links[0];
    const Link& base = m.links()[std::size_t(first)];
    const Vec3 at = motions[std::size_t(first)].X * base.com;
    const Vec3 v = linear / end.mass + omega.cross(at - end.com);
    double* const u = &m.state.updU()[base.first_u];
    for (int k = 0; k < 3; ++k) {
      u[k] += omega[k];
      u[3 + k] += v[k];
    }
  }
}

Vec3 Stepper::impulse_of(const ContactRows& contact) const {
  const Row* const rows = &set_.rows[std::size_t(contact.first)];
  Vec3 impulse = rows[0].lambda * contact.point.normal;
  if (contact.friction <= 0.0) return impulse;
  if (contact.kind == FrictionKind::point)
    return impulse + rows[1].lambda * contact.tangent1 + rows[2].lambda * contact.tangent2;
  // Friction of a line as forces at its two ends: half of what slides each, and the twist as a
  // couple.
  const ContactRows& partner = set_.contacts[std::size_t(contact.partner)];
  const bool second = contact.kind == FrictionKind::twist;
  const ContactRows& patch = second ? partner : contact;
  const ContactRows& twist = second ? contact : partner;
  const Row* const slide = &set_.rows[std::size_t(patch.first)];
  impulse += 0.5 * (slide[1].lambda * patch.tangent1 + slide[2].lambda * patch.tangent2);
  const Vec3 r = contact.point.point - partner.point.point;
  const double couple = set_.rows[std::size_t(twist.first + 1)].lambda;
  return impulse + couple / std::max(r.squaredNorm(), 1e-18) * contact.point.normal.cross(r);
}

void Stepper::warm_start(double h) {
  if (!memory.had_rows) return;
  if (!memory.efforts.empty()) {
    for (Row& row : set_.rows)
      if (row.slot >= 0)
        row.lambda = std::clamp(h * memory.efforts[std::size_t(row.slot)], row.low, row.high);
  }
  warm_.assign(set_.contacts.size(), Vec3::Zero());
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
    warm_[std::size_t(&contact - set_.contacts.data())] = h * memory.contacts[best].force;
  }
  share_warm_friction();
  for (std::size_t i = 0; i < set_.contacts.size(); ++i) {
    const ContactRows& contact = set_.contacts[i];
    Row* const rows = &set_.rows[std::size_t(contact.first)];
    rows[0].lambda = std::max(warm_[i].dot(contact.point.normal), 0.0);
    if (contact.friction <= 0.0) continue;
    Vec3 impulse = warm_[i];
    if (contact.kind != FrictionKind::point) {
      const std::size_t partner = std::size_t(contact.partner);
      if (contact.kind == FrictionKind::twist) {
        const Vec3 arm = 0.5 * (contact.point.point - set_.contacts[partner].point.point);
        rows[1].lambda = contact.point.normal.dot(arm.cross(warm_[i] - warm_[partner]));
        continue;
      }
      impulse += warm_[partner];
    }
    rows[1].lambda = impulse.dot(contact.tangent1);
    rows[2].lambda = impulse.dot(contact.tangent2);
  }
}

// What the sweeps leave of forces that only press the points of a face against each other would
// stay for ever: the start is made without it.
void Stepper::share_warm_friction() {
  constexpr double kSameNormal = 1.0 - 1e-6;  // cosine
  constexpr std::size_t kMost = 16;
  const std::vector<ContactRows>& contacts = set_.contacts;
  std::size_t end = 0;
  for (std::size_t first = 0; first < contacts.size(); first = end) {
    const ContactPoint& leader = contacts[first].point;
    bool flat = true;
    for (end = first; end < contacts.size(); ++end) {
      const ContactPoint& point = contacts[end].point;
      if (point.collider_a != leader.collider_a || point.collider_b != leader.collider_b) break;
      flat = flat && contacts[end].kind == FrictionKind::point &&
             point.normal.dot(leader.normal) > kSameNormal;
    }
    const std::size_t count = end - first;
    if (!flat || count < 2 || count > kMost || contacts[first].friction <= 0.0) continue;
    std::array<double, kMost> loads;
    std::array<Vec3, kMost> points, friction;
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3& impulse = warm_[first + k];
      loads[k] = std::max(impulse.dot(leader.normal), 0.0);
      points[k] = contacts[first + k].point.point;
      friction[k] = impulse - loads[k] * leader.normal;
    }
    share_friction(count, leader.normal, loads.data(), points.data(), friction.data());
    for (std::size_t k = 0; k < count; ++k) {
      warm_[first + k] = loads[k] * leader.normal + friction[k];
    }
  }
}

void Stepper::balance_pairs() {
  constexpr double kYield = 5e-3;  // of the inverse mass that the point feels
  std::vector<ContactRows>& contacts = set_.contacts;
  for (std::size_t first = 0, end = 0; first < contacts.size(); first = end) {
    double sum = 0.0;
    int resting = 0;
    const auto row_of = [&](std::size_t i) -> Row& {
      return set_.rows[std::size_t(contacts[i].first)];
    };
    const auto rests = [&](std::size_t i) {
      const Row& row = row_of(i);
      return row.has_gap && row.target == 0.0 && !row.pull;
    };
    for (end = first; end < contacts.size() &&
                      contacts[end].point.collider_a == contacts[first].point.collider_a &&
                      contacts[end].point.collider_b == contacts[first].point.collider_b;
         ++end) {
      if (!rests(end)) continue;
      sum += row_of(end).lambda;
      ++resting;
    }
    if (resting < 2) continue;
    for (std::size_t i = first; i < end; ++i) {
      if (!rests(i)) continue;
      Row& row = row_of(i);
      row.gamma = kYield * row.diagonal;
      row.target = row.gamma * sum / resting;
      row.inverse_diagonal = 1.0 / (row.diagonal + row.gamma);
    }
  }
}

void Stepper::remember(double h) {
  memory.contacts.clear();
  memory.efforts.assign(std::size_t(RowBuilder::slot_count(model_)), 0.0);
  for (const Row& row : set_.rows)
    if (row.slot >= 0) memory.efforts[std::size_t(row.slot)] = row.lambda / h;
  for (const ContactRows& contact : set_.contacts) {
    const Row* const rows = &set_.rows[std::size_t(contact.first)];
    if (rows[0].lambda <= 0.0 && contact.kind == FrictionKind::point) continue;
    StepMemory::WarmContact w;
    w.collider_a = contact.point.collider_a;
    w.collider_b = contact.point.collider_b;
    const Placement& X_b = detector_.colliders()[std::size_t(w.collider_b)].X_WS;
    w.place = X_b.to_local(contact.point.point);
    w.force = contact_impulses_[std::size_t(&contact - set_.contacts.data())] / h;
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
    const Vec3 impulse = contact_impulses_[std::size_t(&contact - set_.contacts.data())];
    if (rows[0].lambda <= 0.0 && contact.point.gap > 0.0) continue;
    // A step in parts touches the same point several times.
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
