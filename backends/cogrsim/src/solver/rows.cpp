#include "solver/rows.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "mechanism/loops.h"
#include "solver/products.h"

namespace cogrsim::dynamics {
namespace {

// A gap that closes to less than this by the end of the step counts as touching [m], [rad].
constexpr double kTouching = 1e-5;
// A contact point with less than this part of its bodies' own inverse mass is held by joints.
constexpr double kHeld = 1e-10;
// A contact that is slower than this, and opens or closes by less than kTouching in the step, is one that rests [m/s].
constexpr double kTouchingSpeed = 0.02;
// Slower than this, what lands needs no bilateral onto the surface [m/s].
constexpr double kLandingSpeed = 1e-3;

// Where and how fast it hits: gap + speed t + acceleration t^2 / 2 = 0.
struct Hit {
  double time = 0.0;
  double speed = 0.0;
};
Hit find_hit(const Approach& a, double h) {
  if (a.gap <= 0.0) return {0.0, a.speed};
  const double square = a.speed * a.speed - 2.0 * a.acceleration * a.gap;
  const double speed = -std::sqrt(std::max(square, 0.0));
  const double sum = a.speed + speed;
  const double time = sum < 0.0 ? std::min(-2.0 * a.gap / sum, h) : h;
  return {time, std::min(speed, 0.0)};
}

// A contact that yields: spring and dashpot solved at the time theta of the step.
void make_soft(const StepContext& context, const Approach& a, double stiffness, Row& row) {
  const double h = context.h;
  const double inverse_mass = row.diagonal;
  // Damping ratio of a linear spring-dashpot with this restitution (critical when it is 0).
  double ratio = 1.0;
  if (a.restitution > 0.0) {
    const double log_e = std::log(std::min(a.restitution, 1.0));
    ratio = -log_e / std::hypot(kPi, log_e);
  }
  const double c = 2.0 * ratio * std::sqrt(stiffness / std::max(inverse_mass, 1e-300));
  const double theta = fitted_theta((c * h + stiffness * h * h) * inverse_mass);
  const double K = 0.5 * theta * h * stiffness + theta * c;
  const double start = a.gap + 0.5 * theta * h * a.speed;
  row.target = (-stiffness * start - c * (1.0 - theta) * a.speed) / K;
  row.gamma = 1.0 / (h * K);
  row.has_gap = false;
}

}  // namespace

void aim_unilateral(const StepContext& context, const Approach& a, Row& row) {
  const double h = context.h;
  row.low = 0.0;
  row.has_gap = true;
  row.restitution = a.restitution;
  // g(h) = g(h/2) + h/2 J u1 + h^2/8 J' u, with g(0) likewise.
  row.gap = a.gap + 0.5 * h * (a.speed + row.now + 0.5 * h * a.turning);
  row.gap_target = 0.0;
  const double end_speed = a.speed + h * a.acceleration;
  const double end_gap = a.gap + 0.5 * h * (a.speed + end_speed);
  // What touches now stays: that it opens without impulses says nothing, friction may turn it down.
  // The step after a hit begins with what J' u made of it, see below.
  const double slow = std::min(kTouching / h, kTouchingSpeed) + h * std::abs(a.turning);
  const bool touches = a.gap <= kTouching && std::abs(a.speed) <= slow;
  if (end_gap > kTouching && !touches) {
    row.target = end_speed - 2.0 * end_gap / h - 0.5 * h * a.turning;
    if (a.restitution > 0.0) row.impact = Row::Impact::waits;
    return;
  }
  row.hits = -find_hit(a, h).speed > kLandingSpeed && !touches;
  // J(q1) u1 = (J + h/2 J') u1, J being that of the middle. An impact changes u, and J' u with it; it keeps the
  // energy, with e = 1, if J is the same before and after.
  Approach hitting = a;
  if (row.hits) {
    hitting.speed += 0.5 * h * a.turning;
    hitting.acceleration -= a.turning;
  } else {
    row.target = -0.5 * h * a.turning;
  }
  row.bilateral = row.hits;
  row.stays = true;
  const Hit hit = find_hit(hitting, h);
  if (row.hits && a.restitution > 0.0 && -hit.speed > context.bounce_threshold) {
    const double rest = h - hit.time, away = -a.restitution * hit.speed;
    row.target = std::max(away + hitting.acceleration * rest, 0.0);
    row.gap_target = std::max(away * rest + 0.5 * hitting.acceleration * rest * rest, 0.0);
    row.impact = Row::Impact::bounces;
    row.stays = row.target == 0.0;
  }
  if (a.gap < 0.0) {
    row.gap_target = std::min(row.gap_target, a.gap + (kRecoverySpeed + std::abs(a.speed)) * h);
    row.bilateral = false;
  }
}

void NumberPool::open_block(std::size_t least) {
  constexpr std::size_t kBlock = 4096;
  if (block_ < blocks_.size()) ++block_;
  used_ = 0;
  if (block_ == blocks_.size()) blocks_.emplace_back(std::max(kBlock, least));
}

void RowSet::clear() {
  rows.clear();
  scalars.clear();
  balls.clear();
  ball_limits.clear();
  contacts.clear();
  pool.clear();
}

int RowBuilder::slot_of(const SceneModel& model, SlotKind kind, int index) {
  if (kind == SlotKind::coupling)
    return slot_of(model, SlotKind::motor, int(model.motors.size()) + index);
  return int(kind) * model.joint_speeds + index;
}
int RowBuilder::slot_count(const SceneModel& model) {
  return slot_of(model, SlotKind::coupling, int(model.couplings.size()));
}

int RowBuilder::local_of(int component, int speed) const {
  return speed - mechanism_.components()[std::size_t(component)].speeds.first;
}

double RowBuilder::along(const Row& row, const double* v) const {
  double sum = 0.0;
  for (int s = 0; s < 2 && row.size[s] > 0; ++s) {
    const Component& c = mechanism_.components()[std::size_t(row.component[s])];
    if (!c.is_free_body) sum += product(row.j(s), v + c.speeds.first, row.size[s]);
  }
  return sum;
}

double RowBuilder::along(const Pair& pair, const Row& row, const Vec3& point, const Vec3& axis,
                         const double* v) const {
  double sum = row.free_bodies ? 0.0 : along(row, v);
  for (const Pair::Side& side : pair.side) {
    if (!side.component || !side.component->is_free_body) continue;
    const double* const x = v + side.component->speeds.first;
    const Eigen::Map<const Vec3> angular(x), linear(x + 3);
    sum += side.sign * axis.dot(linear + angular.cross(point - side.component->origin));
  }
  return sum;
}

// W of what is not a free body, whose closed form add_side() knows.
void RowBuilder::finish_row(Row& row) {
  for (int s = 0; s < 2 && row.size[s] > 0; ++s) {
    Component& c = mechanism_.components()[std::size_t(row.component[s])];
    const double* const j = row.j(s);
    double* const w = row.w(s);
    if (c.is_free_body) continue;
    solve_mass_often(c, j, w);
    close_loops(c, w);
    for (int k = 0; k < row.size[s]; ++k) row.diagonal += j[k] * w[k];
  }
}

RowBuilder::Pair RowBuilder::pair_of(const Manifold& manifold) {
  Pair pair;
  for (int i = 0; i < 2; ++i) {
    const int index = manifold.link[i];
    if (index < 0) continue;
    const Link& link = mechanism_.links()[std::size_t(index)];
    Pair::Side& side = pair.side[i];
    side.sign = i == 0 ? -1.0 : 1.0;
    side.motion = &motions_[std::size_t(index)];
    if (manifold.component[i] < 0) continue;
    Component& c = mechanism_.components()[std::size_t(manifold.component[i])];
    update_component(mechanism_, c);
    side.component = &c;
    side.position = c.is_free_body ? 0 : c.find(index);
    pair.inverse_mass += 1.0 / link.mass;
    // Two bodies of one component share a side.
    if (i == 1 && manifold.component[0] == manifold.component[1]) continue;
    const int s = pair.row.size[0] > 0 ? 1 : 0;
    pair.row.component[s] = manifold.component[i];
    pair.row.size[s] = c.size();
    pair.row.free_bodies = pair.row.free_bodies && c.is_free_body;
    pair.numbers += c.size();
  }
  if (!pair.row.free_bodies) pair.numbers *= 2;
  return pair;
}

Vec3 RowBuilder::Pair::velocity_at(const Vec3& point) const {
  Vec3 v = Vec3::Zero();
  for (const Side& s : side)
    if (s.motion) v += s.sign * s.motion->velocity_at(point);
  return v;
}

namespace {

// J root of a free body; returns its square, J M^-1 J'.
double fill_free_side(const Component& c, double sign, const Spatial& wrench, double* j) {
  const Vec3 angular = sign * (c.angular_root.transpose() * wrench.angular);
  const Vec3 linear = sign * c.linear_root * wrench.linear;
  for (int k = 0; k < 3; ++k) {
    j[k] = angular[k];
    j[3 + k] = linear[k];
  }
  return angular.squaredNorm() + linear.squaredNorm();
}

}  // namespace

Row& RowBuilder::add_pair_row(const Pair& pair, const Vec3& axis, const Vec3* point) {
  set_.rows.push_back(pair.row);
  Row& row = set_.rows.back();
  row.numbers = set_.pool.take(pair.numbers);
  if (!row.free_bodies) std::fill(row.numbers, row.numbers + pair.numbers, 0.0);
  bool second = false;
  for (int i = 0; i < 2; ++i) {
    const Pair::Side& side = pair.side[i];
    if (!side.component) continue;
    const Component& c = *side.component;
    const Spatial wrench = point ? Spatial{(*point - c.origin).cross(axis), axis}
                                 : Spatial{axis, Vec3::Zero()};
    double* const j = row.j(second && row.size[1] > 0 ? 1 : 0);
    second = true;
    if (c.is_free_body) {
      row.diagonal += fill_free_side(c, side.sign, wrench, j);
      if (!row.free_bodies) std::copy(j, j + 6, j + 6);
    } else {
      fill_row(c, side.position, wrench, side.sign, j);
    }
  }
  if (!row.free_bodies) finish_row(row);
  return row;
}

Row& RowBuilder::add_point_row(const Pair& pair, const Vec3& point, const Vec3& velocity,
                               const Vec3& direction) {
  Row& row = add_pair_row(pair, direction, &point);
  row.now = direction.dot(velocity);
  return row;
}

Row& RowBuilder::add_twist_row(const Pair& pair, const Vec3& axis) {
  Row& row = add_pair_row(pair, axis, nullptr);
  for (const Pair::Side& side : pair.side)
    if (side.motion) row.now += side.sign * axis.dot(side.motion->angular);
  row.inverse = row.diagonal > 0.0 ? 1.0 / row.diagonal : 0.0;
  return row;
}

Row& RowBuilder::add_axis_row(const StepContext& context, int component, int local, double sign) {
  Component& c = mechanism_.components()[std::size_t(component)];
  update_component(mechanism_, c);
  set_.scalars.push_back(int(set_.rows.size()));
  Row& row = next_row();
  row.component[0] = component;
  row.size[0] = c.size();
  row.free_bodies = false;
  row.numbers = set_.pool.take(2 * c.size());
  std::fill(row.numbers, row.numbers + 2 * c.size(), 0.0);
  if (local >= 0) {
    row.j(0)[local] = sign;
    row.effort_sign = sign;
    row.now = along(row, context.u);
    finish_row(row);
  }
  return row;
}

void RowBuilder::add_joint_rows(const StepContext& context, const std::vector<AxisLaw>& laws) {
  const SceneModel& model = mechanism_.model();
  const auto sleeps = [this](int component) {
    return component >= 0 && mechanism_.components()[std::size_t(component)].asleep;
  };
  const auto sleeps_at = [&](int joint) {
    const int link = mechanism_.joint_link(joint);
    return link >= 0 && sleeps(mechanism_.links()[std::size_t(link)].component);
  };
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed || mechanism_.joint_link(int(j)) < 0 || joint.axes.empty() ||
        sleeps_at(int(j)))
      continue;
    if (joint.type == JointType::ball)
      add_ball_limit(context, int(j));
    else
      add_limits(context, int(j));
    add_friction(context, int(j));
  }
  for (const AxisLaw& law : laws)
    if (law.implicit && !sleeps(law.component)) add_law(context, law);
  for (std::size_t i = 0; i < model.couplings.size(); ++i)
    if (!model.couplings[i].removed && !sleeps_at(model.couplings[i].joint)) add_coupling(context, int(i));
  for (int index : set_.scalars) {
    Row& row = set_.rows[std::size_t(index)];
    row.inverse = 1.0 / (row.diagonal + row.gamma);
  }
}

void RowBuilder::add_limits(const StepContext& context, int joint_index) {
  const Joint& joint = mechanism_.model().joints[std::size_t(joint_index)];
  const State& state = mechanism_.state;
  for (int a = 0; a < int(joint.axes.size()); ++a) {
    const JointAxis& axis = joint.axes[std::size_t(a)];
    if (!axis.has_limit()) continue;
    const double q = state.q()[mechanism_.axis_position(joint_index, a)];
    const int speed = mechanism_.axis_speed(joint_index, a);
    const double u = state.u()[speed];
    const double margin = kTouching * 10.0 + 2.0 * context.h * std::abs(u);
    for (int end = 0; end < 2; ++end) {
      const double gap = end == 0 ? q - axis.lower : axis.upper - q;
      if (!(gap < margin)) continue;
      const int component =
          mechanism_.links()[std::size_t(mechanism_.joint_link(joint_index))].component;
      Row& row =
          add_axis_row(context, component, local_of(component, speed), end == 0 ? 1.0 : -1.0);
      const double h = context.h;
      Approach approach;
      approach.speed = row.now - 0.5 * h * along(row, context.start_udot);
      approach.gap = gap - 0.5 * h * approach.speed;
      approach.acceleration = along(row, context.udot);
      aim_unilateral(context, approach, row);
      row.effort = joint.speed_offset + a;
      row.slot = slot_of(mechanism_.model(),
                         end == 0 ? SlotKind::lower_limit : SlotKind::upper_limit, row.effort);
      row.inverse = 1.0 / row.diagonal;
    }
  }
}

void RowBuilder::add_ball_limit(const StepContext& context, int joint_index) {
  const Joint& joint = mechanism_.model().joints[std::size_t(joint_index)];
  const JointAxis& axis = joint.axes[0];
  if (!std::isfinite(axis.upper)) return;
  const State& state = mechanism_.state;
  const Vec3 rotation = rotation_vector(state.q(), mechanism_.axis_position(joint_index, 0));
  const double angle = rotation.norm();
  const int first = mechanism_.axis_speed(joint_index, 0);
  const Vec3 u(state.u()[first], state.u()[first + 1], state.u()[first + 2]);
  const double gap = axis.upper - angle;
  if (gap > kTouching * 10.0 + 2.0 * context.h * u.norm() || angle < 1e-9) return;
  const Vec3 direction = -rotation / angle;
  const int component =
      mechanism_.links()[std::size_t(mechanism_.joint_link(joint_index))].component;
  Row& row = add_axis_row(context, component, -1, 1.0);
  const int local = local_of(component, first);
  for (int k = 0; k < 3; ++k) row.j(0)[local + k] = direction[k];
  row.now = along(row, context.u);
  finish_row(row);
  Approach approach;
  approach.speed = row.now - 0.5 * context.h * along(row, context.start_udot);
  approach.gap = gap - 0.5 * context.h * approach.speed;
  approach.acceleration = along(row, context.udot);
  aim_unilateral(context, approach, row);
  row.slot = slot_of(mechanism_.model(), SlotKind::upper_limit, joint.speed_offset);
  row.inverse = 1.0 / row.diagonal;
  set_.ball_limits.push_back({int(set_.rows.size()) - 1, joint.speed_offset, direction});
}

void RowBuilder::add_friction(const StepContext& context, int joint_index) {
  const Joint& joint = mechanism_.model().joints[std::size_t(joint_index)];
  const bool ball = joint.type == JointType::ball;
  const int count = ball ? 3 : int(joint.axes.size());
  const int component =
      mechanism_.links()[std::size_t(mechanism_.joint_link(joint_index))].component;
  if (ball && joint.axes[0].friction > 0.0)
    set_.balls.push_back({int(set_.rows.size()), joint.axes[0].friction * context.h});
  for (int a = 0; a < count; ++a) {
    const double friction = joint.axes[std::size_t(ball ? 0 : a)].friction;
    if (friction <= 0.0) continue;
    Row& row = add_axis_row(context, component,
                            local_of(component, mechanism_.axis_speed(joint_index, a)), 1.0);
    if (ball) set_.scalars.pop_back();
    row.high = friction * context.h;
    row.low = -row.high;
    row.effort = joint.speed_offset + a;
    row.slot = slot_of(mechanism_.model(), SlotKind::friction, row.effort);
    row.inverse = 1.0 / row.diagonal;
  }
  if (!ball || joint.axes[0].friction <= 0.0) return;
  // One step length for all three: else the effort at the bound would not oppose the motion.
  Row* const rows = &set_.rows[set_.rows.size() - 3];
  const double most = std::max({rows[0].diagonal, rows[1].diagonal, rows[2].diagonal});
  for (int k = 0; k < 3; ++k) rows[k].inverse = 1.0 / most;
}

void RowBuilder::add_law(const StepContext& context, const AxisLaw& law) {
  const double h = context.h;
  Row& row = add_axis_row(context, law.component, law.local, 1.0);
  row.effort = law.effort;
  row.motor = law.motor;
  row.slot = law.motor >= 0 ? slot_of(mechanism_.model(), SlotKind::motor, law.motor)
                            : slot_of(mechanism_.model(), SlotKind::passive, law.effort);
  row.high = law.law.max_effort * h;
  row.low = -row.high;
  if (law.law.is_speed_source()) {
    row.target = law.law.velocity;
    return;
  }
  // effort = bias + kp (position - q_theta) + kd (velocity - u_theta), with u_theta between the
  // speeds at start and end, and q_theta between the coordinates, the step being a trapezoid.
  const double theta = law.theta, kp = law.law.kp, kd = law.law.kd;
  const double q0 = law.coordinate(*context.start_q);
  const double u0 = (*context.start_u)[law.speed];
  const double K = theta * (0.5 * h * kp + kd);
  const double at_rest = law.law.bias + kp * (law.law.position - q0 - 0.5 * theta * h * u0) +
                         kd * (law.law.velocity - (1.0 - theta) * u0);
  row.target = at_rest / K;
  row.gamma = 1.0 / (h * K);
}

// q - offset - sum of ratio q_i = 0, to the end of the step: its rate is brought to 0, and the position
// stage closes what is left.
void RowBuilder::add_coupling(const StepContext& context, int index) {
  const Coupling& coupling = mechanism_.model().couplings[std::size_t(index)];
  const int link = mechanism_.joint_link(coupling.joint);
  const int component = link < 0 ? -1 : mechanism_.links()[std::size_t(link)].component;
  if (component < 0) return;
  Row& row = add_axis_row(context, component, -1, 1.0);
  double gap = -coupling.offset;
  const auto add = [&](int joint, double factor) {
    const int speed = mechanism_.axis_speed(joint, 0);
    if (speed < 0) return;
    row.j(0)[local_of(component, speed)] += factor;
    gap += factor * mechanism_.state.q()[mechanism_.axis_position(joint, 0)];
  };
  add(coupling.joint, 1.0);
  for (const CouplingTerm& term : coupling.terms) add(term.joint, -term.ratio);
  row.now = along(row, context.u);
  finish_row(row);
  row.coupling = index;
  row.slot = slot_of(mechanism_.model(), SlotKind::coupling, index);
  row.high = coupling.max_effort * context.h;
  row.low = -row.high;
  row.has_gap = row.equality = true;
  row.gap = gap + 0.5 * context.h * row.now;
}

// One step length for two rows of a disc: else the impulse at the bound would not oppose the motion.
void RowBuilder::share_step_length(int first) {
  Row* const rows = &set_.rows[std::size_t(first)];
  const double most = std::max(rows[0].diagonal, rows[1].diagonal);
  rows[0].inverse = rows[1].inverse = most > 0.0 ? 1.0 / most : 0.0;
}

void RowBuilder::add_contacts(const StepContext& context, const Manifold& manifold,
                              const ContactMotion* motions) {
  const Pair pair = pair_of(manifold);
  const std::size_t rows = set_.rows.size(), before = set_.contacts.size();
  for (const ContactPoint* point = manifold.first; point != manifold.end; ++point)
    if (add_contact(context, manifold, pair, *point, motions))
      set_.contacts.back().in_pair = int(set_.contacts.size() - before) - 1;
  if (!manifold.is_line || set_.contacts.size() != before + 1) return;
  // One end of the line is held: the other is a point.
  set_.rows.resize(rows);
  set_.contacts.resize(before);
  Manifold points = manifold;
  points.is_line = false;
  add_contacts(context, points, motions);
}

bool RowBuilder::add_contact(const StepContext& context, const Manifold& manifold, const Pair& pair,
                             const ContactPoint& point, const ContactMotion* motions) {
  const SurfacePair& surface = *manifold.surface;
  if (surface.stiffness && *surface.stiffness <= 0.0) return false;  // it presses with nothing
  const int first = int(set_.rows.size());
  const Vec3& n = point.normal;
  const int at = int(&point - manifold.first);
  const ContactMotion& motion = motions[at];
  Row& row = add_point_row(pair, point.point, motion.velocity, n);
  // Joints may hold a body such that it cannot yield: what remains is rounding, not a mass.
  if (row.diagonal <= kHeld * pair.inverse_mass) {
    set_.rows.pop_back();
    return false;
  }
  const Vec3& turning = motion.turning;
  Approach approach;
  const double h = context.h;
  row.deep = point.gap < -kTouching && !row.free_bodies;
  approach.restitution = surface.restitution;
  approach.turning = turning.dot(n);
  approach.speed = row.now - 0.5 * h * (along(pair, row, point.point, n, context.start_udot) + approach.turning);
  approach.gap = point.gap - 0.5 * h * (approach.speed + 0.25 * h * approach.turning);
  approach.acceleration = along(pair, row, point.point, n, context.udot) + approach.turning;
  aim_unilateral(context, approach, row);
  if (surface.stiffness) make_soft(context, approach, *surface.stiffness, row);
  row.inverse = 1.0 / (row.diagonal + row.gamma);
  const double along_turn = row.hits ? 0.0 : 0.5 * h;

  const int index = int(set_.contacts.size());
  ContactRows& contact = set_.contacts.emplace_back();
  contact.first = first;
  contact.point = &point;
  contact.friction = surface.friction;
  contact.rolling = surface.rolling_friction;
  contact.spinning = surface.spinning_friction;
  // Tangents depend on the normal alone.
  if (index > 0 && set_.contacts[std::size_t(index - 1)].point->normal == n) {
    contact.tangent1 = set_.contacts[std::size_t(index - 1)].tangent1;
    contact.tangent2 = set_.contacts[std::size_t(index - 1)].tangent2;
  } else {
    const Vec3 least = std::abs(n[0]) < 0.6 ? Vec3::UnitX() : Vec3::UnitY();
    contact.tangent1 = (least - n * n.dot(least)).normalized();
    contact.tangent2 = n.cross(contact.tangent1);
  }
  // Friction acts where the surfaces meet in the impact. If one of the
  // two yields to no force, that is the surface of the other; if both yield, it is halfway between,
  // which conserves angular momentum.
  Vec3 where = point.point, friction_turning = turning;
  bool moved = false;
  if (pair.yields(0) != pair.yields(1)) {
    where += (pair.yields(1) ? 0.5 : -0.5) * point.gap * n;
    moved = true;
  }
  if (manifold.is_line) {
    const ContactPoint& other = manifold.first[1 - at];
    contact.kind = at == 1 ? FrictionKind::twist : FrictionKind::patch;
    contact.partner = index + (at == 1 ? -1 : 1);
    where += 0.5 * (other.point - point.point);
    friction_turning = 0.5 * (turning + motions[1 - at].turning);
    moved = true;
    // A load spread evenly along the line: the mean distance from its middle.
    contact.lever = 0.25 * (point.point - other.point).norm();
  }
  if (contact.friction > 0.0 && contact.kind == FrictionKind::twist) {
    add_twist_row(pair, n);
  } else if (contact.friction > 0.0) {
    const Vec3 there = moved ? pair.velocity_at(where) : motion.velocity;
    const Vec3 against = motion.surface + along_turn * friction_turning;
    for (const Vec3& t : {contact.tangent1, contact.tangent2})
      add_point_row(pair, where, there, t).target = -t.dot(against);
    share_step_length(first + 1);
  }
  for (int i = 0; i < contact.turning_rows(); ++i) add_twist_row(pair, contact.turning_axis(i));
  if (contact.rolling > 0.0) share_step_length(contact.first_turning());
  return true;
}

}  // namespace cogrsim::dynamics
