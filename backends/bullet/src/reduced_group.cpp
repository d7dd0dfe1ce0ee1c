#include "reduced_group.h"

#include <algorithm>
#include <cmath>

#include "convert.h"

namespace cogrsim::bullet {

namespace {

// Axes of one group are swept until none changes by more than this part, or so often.
constexpr double kAxisTolerance = 1e-12;
constexpr int kAxisSweeps = 30;

/// The lesser of two of one sign, else nothing.
double lesser(double a, double b) {
  if (a * b <= 0.0) return 0.0;
  return std::abs(a) < std::abs(b) ? a : b;
}

}  // namespace

ReducedGroup::ReducedGroup(const SceneModel& model, const std::vector<int>& joints,
                           std::vector<RigidBody>& bodies)
    : tree_(model, joints, bodies) {
  joint_indices_ = joints;
  body_indices_ = tree_.bodies();
  gravity_ = to_bt(model.physics.gravity);
  for (std::size_t k = 0; k < body_indices_.size(); ++k) {
    Member member;
    member.body = &bodies[static_cast<std::size_t>(body_indices_[k])];
    member.link = tree_.links()[k];
    members_.push_back(member);
  }
  for (const TreeJoint& joint : tree_.joints()) {
    JointSlot slot;
    slot.motors = motors_of(model, joint.joint);
    slots_.push_back(std::move(slot));
  }
  set_memory({});
}

LinkVector ReducedGroup::momentum(const Member& member, const LinkVector& v) const {
  const btMatrix3x3& R = tree_.frame(member.link).getBasis();
  const btVector3 in_body = (v.ang * R) * member.body->moments();
  return {v.lin * member.body->mass(), R * in_body};
}

void ReducedGroup::prepare(const SceneModel& model, double dt, const std::vector<Drive>& drives,
                           const std::vector<double>& q) {
  dt_ = dt;
  tree_.set_positions(q, members_.front().body->object().getWorldTransform());
  links_.assign(tree_.frame_count(), {});
  for (Member& member : members_) {
    const btRigidBody& object = member.body->object();
    links_[static_cast<std::size_t>(member.link + 1)] = {object.getLinearVelocity(),
                                                         object.getAngularVelocity()};
  }
  tree_.speeds(links_, u_start_);
  const std::size_t n = u_start_.size();
  work_.resize(n);
  tree_.accelerations(u_start_, free_);
  // What depends on velocities, once more for those half a step on.
  for (std::size_t k = 0; k < n; ++k) {
    work_[k] = u_start_[k] + 0.5 * dt * (free_[k] + lesser(past_[0][k], past_[1][k]));
  }
  tree_.bias(u_start_, impulses_);
  tree_.bias(work_, response_);
  for (std::size_t k = 0; k < n; ++k) impulses_[k] -= response_[k];
  tree_.respond(impulses_, response_);
  u_.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    free_[k] += response_[k];
    u_[k] = u_start_[k] + dt * free_[k];
  }
  for (Member& member : members_) {
    member.place = tree_.frame(member.link).getOrigin();
    member.before = momentum(member, links_[static_cast<std::size_t>(member.link + 1)]);
    member.blow = {};
  }
  for (std::size_t k = 0; k < slots_.size(); ++k) slots_[k].at = tree_.origin(tree_.joints()[k]);
  gather_axes(model, drives, q);
  for (std::size_t i = 0; i < axis_count_; ++i) {
    Axis& axis = axes_[i];
    impulses_.assign(n, 0.0);
    for (int k = 0; k < axis.count; ++k) {
      impulses_[static_cast<std::size_t>(axis.first + k)] = axis.weight[k];
    }
    tree_.respond(impulses_, axis.response);
    axis.inverse_inertia = along(axis, axis.response);
    fill_law(model, axis, dt, drives);
  }
}

double ReducedGroup::along(const Axis& axis, const std::vector<double>& u) const {
  double sum = 0.0;
  for (int k = 0; k < axis.count; ++k) {
    sum += axis.weight[k] * u[static_cast<std::size_t>(axis.first + k)];
  }
  return sum;
}

void ReducedGroup::bind(StepBodies& bodies) {
  solved_ = false;
  for (Member& member : members_) {
    member.index = StepBodies::index_of(member.body->object());
    bodies.hold(member.index);
    member.written = {};
    const StepBodies::Entry& entry = bodies.entry(member.index);
    member.start = {entry.lin, entry.ang};
  }
}

void ReducedGroup::iterate(StepBodies& bodies) {
  // What contacts have done to the bodies since the last turn.
  bool touched = false;
  for (const Member& member : members_) {
    const DeltaVelocity& delta = bodies.delta(member.index);
    touched =
        touched || !(delta.lin() == member.written.lin) || !(delta.ang() == member.written.ang);
  }
  if (solved_ && !touched) return;
  solved_ = true;
  if (touched) {
    forces_.assign(links_.size(), {});
    for (Member& member : members_) {
      const DeltaVelocity& delta = bodies.delta(member.index);
      const LinkVector change{delta.lin() - member.written.lin, delta.ang() - member.written.ang};
      const LinkVector blow = momentum(member, change);
      member.blow.lin += blow.lin;
      member.blow.ang += blow.ang;
      forces_[static_cast<std::size_t>(member.link + 1)] = blow;
    }
    tree_.project(forces_, impulses_);
    tree_.respond(impulses_, response_);
    for (std::size_t k = 0; k < u_.size(); ++k) u_[k] += response_[k];
  }
  solve_axes();
  tree_.velocities(u_, links_);
  for (Member& member : members_) {
    const LinkVector& v = links_[static_cast<std::size_t>(member.link + 1)];
    member.written = {v.lin - member.start.lin, v.ang - member.start.ang};
    bodies.delta(member.index) = {member.written.lin, member.written.ang};
  }
}

void ReducedGroup::solve_axes() {
  for (int sweep = 0; sweep < kAxisSweeps; ++sweep) {
    bool settled = true;
    for (std::size_t i = 0; i < axis_count_; ++i) {
      Axis& axis = axes_[i];
      if (axis.inverse_inertia <= 0.0) continue;
      const double v = along(axis, u_) - axis.inverse_inertia * axis.impulse;
      const double impulse = axis.law.solve(v, axis.inverse_inertia);
      const double change = impulse - axis.impulse;
      if (std::abs(change) > kAxisTolerance * std::abs(impulse)) settled = false;
      axis.impulse = impulse;
      for (std::size_t k = 0; k < u_.size(); ++k) u_[k] += axis.response[k] * change;
    }
    if (settled || axis_count_ < 2) break;
  }
}

void ReducedGroup::move(double dt, const std::vector<std::pair<btVector3, btVector3>>& extra,
                        std::vector<double>& q) {
  work_ = u_;
  if (!extra.empty()) {
    bool any = false;
    forces_.assign(links_.size(), {});
    for (std::size_t k = 0; k < members_.size(); ++k) {
      const auto& e = extra[static_cast<std::size_t>(body_indices_[k])];
      forces_[static_cast<std::size_t>(members_[k].link + 1)] = {e.first, e.second};
      any = any || !e.first.isZero() || !e.second.isZero();
    }
    if (any) {
      tree_.speeds(forces_, response_);
      for (std::size_t k = 0; k < u_.size(); ++k) work_[k] += response_[k];
    }
  }
  btTransform base = tree_.frame(-1);
  tree_.advance(work_, dt, q, base);
  tree_.set_positions(q, base);
  tree_.velocities(u_, links_);
  if (tree_.floating()) keep_momentum();
  for (Member& member : members_) {
    const LinkVector& v = links_[static_cast<std::size_t>(member.link + 1)];
    member.body->set_principal({tree_.frame(member.link), v.lin, v.ang});
  }
}

void ReducedGroup::keep_momentum() {
  double mass = 0.0;
  btVector3 then(0, 0, 0), now(0, 0, 0);  // centres of mass
  for (const Member& member : members_) {
    const double m = member.body->mass();
    mass += m;
    then += member.place * m;
    now += tree_.frame(member.link).getOrigin() * m;
  }
  then /= mass;
  now /= mass;
  // About the centre of mass; what is missing, and the inertia of the whole as it stands.
  LinkVector missing{gravity_ * (mass * dt_), btVector3(0, 0, 0)};
  btMatrix3x3 inertia(0, 0, 0, 0, 0, 0, 0, 0, 0);
  for (const Member& member : members_) {
    const LinkVector after = momentum(member, links_[static_cast<std::size_t>(member.link + 1)]);
    const btTransform& X = tree_.frame(member.link);
    const btVector3 arm = X.getOrigin() - now;
    const btVector3 given = member.before.lin + member.blow.lin;
    missing.lin += given - after.lin;
    missing.ang += member.before.ang + member.blow.ang + (member.place - then).cross(given) -
                   after.ang - arm.cross(after.lin);
    const double m = member.body->mass();
    for (int k = 0; k < 3; ++k) {
      btVector3 unit(0, 0, 0);
      unit[k] = 1.0;
      const btVector3 column = arm.cross(unit.cross(arm)) * m +
                               X.getBasis() * ((unit * X.getBasis()) * member.body->moments());
      for (int r = 0; r < 3; ++r) inertia[r][k] += column[r];
    }
  }
  const btVector3 turn = inertia.inverse() * missing.ang, shift = missing.lin / mass;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const btVector3 arm = tree_.frame(static_cast<int>(i) - 1).getOrigin() - now;
    links_[i].ang += turn;
    links_[i].lin += shift + turn.cross(arm);
  }
}

void ReducedGroup::report(const SceneModel& model, double dt, JointReport& out) {
  past_[1].swap(past_[0]);
  for (std::size_t k = 0; k < u_.size(); ++k) past_[0][k] = (u_[k] - u_start_[k]) / dt - free_[k];
  for (const TreeJoint& t : tree_.joints()) {
    const Joint& joint = model.joints[static_cast<std::size_t>(t.joint)];
    for (int k = 0; k < speed_count(joint.type); ++k) {
      out.joint_efforts[static_cast<std::size_t>(joint.speed_offset + k)] = 0.0;
    }
  }
  for (std::size_t i = 0; i < axis_count_; ++i) {
    const Axis& axis = axes_[i];
    const double effort = axis.impulse / dt;
    const TreeJoint& t = tree_.joints()[static_cast<std::size_t>(axis.tree_joint)];
    const auto speed =
        static_cast<std::size_t>(model.joints[static_cast<std::size_t>(t.joint)].speed_offset);
    if (axis.part != AxisPart::whole) {
      for (int k = 0; k < 3; ++k) {
        out.joint_efforts[speed + static_cast<std::size_t>(k)] += axis.in_F[k] * effort;
      }
      continue;
    }
    out.joint_efforts[speed + static_cast<std::size_t>(axis.number)] += effort;
    for (std::size_t m = 0; m < axis.motors.size(); ++m) {
      out.motor_efforts[static_cast<std::size_t>(axis.motors[m])] = axis.law.impulse(m) / dt;
    }
  }
}

void ReducedGroup::find_reactions(const SceneModel& model, std::vector<Wrench>& out) const {
  if (dt_ <= 0.0) return;
  // What the change of each body's momentum leaves to its joints; then inwards, leaves first.
  const btVector3 gravity = to_bt(model.physics.gravity);
  std::vector<LinkVector> open(links_.size());
  std::vector<btVector3> place(links_.size(), btVector3(0, 0, 0));
  for (const Member& member : members_) {
    const auto link = static_cast<std::size_t>(member.link + 1);
    const LinkVector after = momentum(member, links_[link]);
    open[link].lin =
        (after.lin - member.before.lin - member.blow.lin) / dt_ - gravity * member.body->mass();
    open[link].ang = (after.ang - member.before.ang - member.blow.ang) / dt_;
    place[link] = member.place;
  }
  for (std::size_t k = slots_.size(); k-- > 0;) {
    const TreeJoint& t = tree_.joints()[k];
    const LinkVector& f = open[static_cast<std::size_t>(t.to + 1)];
    const btVector3& c = place[static_cast<std::size_t>(t.to + 1)];
    // On the body outwards, about M's origin.
    const btVector3 torque = f.ang + (c - slots_[k].at).cross(f.lin);
    const double sign = t.reversed ? -1.0 : 1.0;
    out[static_cast<std::size_t>(t.joint)] = {from_bt(f.lin * sign), from_bt(torque * sign)};
    LinkVector& inner = open[static_cast<std::size_t>(t.from + 1)];
    inner.lin += f.lin;
    inner.ang += f.ang + (c - place[static_cast<std::size_t>(t.from + 1)]).cross(f.lin);
  }
}

std::vector<double> ReducedGroup::memory() const {
  std::vector<double> out;
  for (const auto& part : past_) out.insert(out.end(), part.begin(), part.end());
  return out;
}

void ReducedGroup::set_memory(const std::vector<double>& memory) {
  const auto n = static_cast<std::size_t>(tree_.speed_count());
  for (std::size_t i = 0; i < past_.size(); ++i) {
    past_[i].assign(n, 0.0);
    if (memory.size() != past_.size() * n) continue;
    std::copy_n(memory.begin() + static_cast<std::ptrdiff_t>(i * n), n, past_[i].begin());
  }
}

}  // namespace cogrsim::bullet
