#include "sleep.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace cogrsim::dynamics {
namespace {

// A load or a motor's effort that differs by more than this part of it is another one, as is a target that differs by so
// much [rad], [m]: what still trembles does not wake itself, and what is ramped is compared with where it began.
constexpr double kSameLoad = 1e-3, kSameTarget = 1e-6;

bool same(const Drive& a, const Drive& b) {
  return std::abs(a.bias - b.bias) <= kSameLoad * std::abs(a.bias) && a.kp == b.kp &&
         std::abs(a.position - b.position) <= kSameTarget && a.kd == b.kd &&
         a.velocity == b.velocity && a.max_effort == b.max_effort;
}

bool same(const Wrench& a, const Wrench& b) {
  return (a.force - b.force).norm() <= kSameLoad * a.force.norm() &&
         (a.torque - b.torque).norm() <= kSameLoad * a.torque.norm();
}

// Those of `from` for which `moves` holds, to their places in `to`; both in the order of the colliders.
template <class T, class Moves>
void move_over(std::vector<T>& from, std::vector<T>& to, const Moves& moves) {
  const auto end =
      std::stable_partition(from.begin(), from.end(), [&](const T& item) { return !moves(item); });
  const std::ptrdiff_t middle = std::ptrdiff_t(to.size());
  to.insert(to.end(), end, from.end());
  from.erase(end, from.end());
  std::inplace_merge(to.begin(), to.begin() + middle, to.end(), by_pair<T>);
}

}  // namespace

Sleep::Sleep(Mechanism& mechanism, Detector& detector)
    : mechanism_(mechanism), detector_(detector) {
  const SceneModel& model = mechanism.model();
  by_speed_.assign(std::size_t(model.joint_speeds), -1);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed) continue;
    const int child = component_of(joint.child), parent = component_of(joint.parent);
    const int component = child >= 0 ? child : parent;
    for (int k = 0; k < speed_count(joint.type); ++k)
      by_speed_[std::size_t(joint.speed_offset + k)] = component;
    for (const int body : {joint.child, joint.parent}) {
      const int link = mechanism.body_link(body);
      if (component >= 0 && link >= 0 && mechanism.links()[std::size_t(link)].kinematic)
        ties_.push_back({link, component});
    }
  }
  for (const Motor& motor : model.motors)
    by_motor_.push_back(
        motor.removed || motor.joint < 0
            ? -1
            : by_speed_[std::size_t(model.joints[std::size_t(motor.joint)].speed_offset)]);
  for (std::size_t i = 0; i < mechanism.links().size(); ++i)
    if (mechanism.links()[i].kinematic) kinematic_.push_back(int(i));
  const std::size_t count = mechanism.components().size();
  state_.still.assign(count, 0.0);
  state_.group.assign(count, -1);
  state_.impulses.joints.assign(by_speed_.size(), 0.0);
  state_.impulses.motors.assign(by_motor_.size(), 0.0);
  awake_ = state_;
}

// -1: none that moves by itself.
int Sleep::component_of(int body) const {
  const int link = mechanism_.body_link(body);
  return link < 0 ? -1 : mechanism_.links()[std::size_t(link)].component;
}

void Sleep::set_state(const SleepState& state) {
  state_ = state;
  for (std::size_t c = 0; c < state_.group.size(); ++c) mark(c);
}

void Sleep::mark(std::size_t component) {
  Component& c = mechanism_.components()[component];
  c.asleep = state_.group[component] >= 0;
  for (const int link : c.links)
    detector_.set_moves(mechanism_.links()[std::size_t(link)].plan.body, !c.asleep);
}

bool Sleep::sleeps(int collider) const {
  const int c = component_of(detector_.colliders()[std::size_t(collider)].body);
  return c >= 0 && state_.group[std::size_t(c)] >= 0;
}

bool Sleep::is_kept_moving(std::size_t kinematic) const {
  const LinkMotion& motion = mechanism_.motions()[kinematic];
  return !motion.linear.isZero(0.0) || !motion.angular.isZero(0.0);
}

bool Sleep::begin(const std::vector<Drive>& drives, StepMemory& memory) {
  bool moves = false;
  for (const int i : kinematic_) {
    const bool moved = is_kept_moving(std::size_t(i));
    moves = moves || moved;
    detector_.set_moves(mechanism_.links()[std::size_t(i)].plan.body, moved);
  }
  for (const Tie& tie : ties_)
    if (is_kept_moving(std::size_t(tie.link))) disturb(tie.component, memory);
  state_.drives.resize(drives.size());
  for (std::size_t i = 0; i < drives.size(); ++i) {
    if (same(state_.drives[i], drives[i]) && drives[i].velocity == 0.0) continue;
    disturb(by_motor_[i], memory);
    state_.drives[i] = drives[i];
  }
  const std::vector<Wrench>& loads = mechanism_.loads();
  state_.loads.resize(loads.size());
  for (std::size_t i = 0; i < loads.size(); ++i) {
    if (same(state_.loads[i], loads[i])) continue;
    disturb(mechanism_.links()[i].component, memory);
    state_.loads[i] = loads[i];
  }
  for (const Component& c : mechanism_.components()) moves = moves || (!c.asleep && c.size() > 0);
  return moves;
}

void Sleep::disturb(int component, StepMemory& memory) {
  if (component < 0) return;
  state_.still[std::size_t(component)] = 0.0;
  if (state_.group[std::size_t(component)] >= 0) wake(state_.group[std::size_t(component)], memory);
}

void Sleep::wake(int group, StepMemory& memory) {
  for (std::size_t c = 0; c < state_.group.size(); ++c) {
    if (state_.group[c] != group) continue;
    state_.group[c] = -1;
    state_.still[c] = 0.0;
    mark(c);
  }
  const auto is_awake = [this](const auto& contact) {
    return !sleeps(contact.collider_a) && !sleeps(contact.collider_b);
  };
  move_over(state_.contacts, memory.contacts, is_awake);
  std::vector<ContactRecord> gone;
  move_over(state_.records, gone, is_awake);
  const auto forget = [this](const std::vector<int>& by, std::vector<double>& impulses) {
    for (std::size_t i = 0; i < by.size(); ++i)
      if (by[i] < 0 || state_.group[std::size_t(by[i])] < 0) impulses[i] = 0.0;
  };
  forget(by_speed_, state_.impulses.joints);
  forget(by_motor_, state_.impulses.motors);
}

bool Sleep::wake_touched(const std::vector<Manifold>& manifolds, StepMemory& memory) {
  bool any = false;
  for (const Manifold& m : manifolds)
    for (const int c : m.component) {
      if (c < 0 || state_.group[std::size_t(c)] < 0) continue;
      disturb(c, memory);
      any = true;
    }
  return any;
}

bool Sleep::stays_in_place(const Component& c) const {
  const double *const q = mechanism_.state.q().data(), *const before = state_.start_q.data();
  for (const int i : c.links) {
    const Link& link = mechanism_.links()[std::size_t(i)];
    for (int k = link.first_q; k < link.first_q + link.nq; ++k)
      if (!(std::abs(q[k] - before[k]) < kInPlace)) return false;
  }
  return true;
}

void Sleep::start_again(const Component& c) {
  for (const int i : c.links) {
    const Link& link = mechanism_.links()[std::size_t(i)];
    for (int k = link.first_q; k < link.first_q + link.nq; ++k)
      state_.start_q[k] = mechanism_.state.q()[k];
  }
}

void Sleep::end(double dt, const Contacts& contacts, Partition& partition, StepMemory& memory,
                const std::vector<ContactRecord>& records, const EffortSums& impulses) {
  const std::vector<Component>& components = mechanism_.components();
  std::vector<char> driven(components.size(), 0);  // a motor holds it
  for (std::size_t i = 0; i < by_motor_.size(); ++i)
    if (by_motor_[i] >= 0 && state_.drives[i].kp + state_.drives[i].kd > 0.0)
      driven[std::size_t(by_motor_[i])] = 1;
  if (state_.start_q.size() == 0) state_.start_q = mechanism_.state.q();
  for (std::size_t c = 0; c < components.size(); ++c) {
    if (components[c].asleep) continue;
    const bool held = (memory.had_rows && partition.has_rows(int(c))) || driven[c];
    state_.still[c] = held && stays_in_place(components[c]) ? state_.still[c] + dt : 0.0;
    if (state_.still[c] == 0.0) start_again(components[c]);
  }
  for (const Manifold& m : contacts.manifolds()) {
    bool moves = !detector_.surface_velocity(*m.first).isZero(0.0);
    for (const int link : m.link)
      moves = moves || (link >= 0 && mechanism_.links()[std::size_t(link)].kinematic &&
                        is_kept_moving(std::size_t(link)));
    for (int s = 0; s < 2 && moves; ++s)
      if (m.component[s] >= 0) state_.still[std::size_t(m.component[s])] = 0.0;
  }
  const auto first_of = [&](std::size_t c) {
    return std::size_t(memory.had_rows ? partition.first_of(int(c)) : int(c));
  };
  // Of each island the least.
  std::vector<double> still(components.size(), kStillTime);
  for (std::size_t c = 0; c < components.size(); ++c) {
    double& least = still[first_of(c)];
    least = std::min(least, state_.still[c]);
  }
  bool any = false;
  for (std::size_t c = 0; c < components.size(); ++c) {
    const std::size_t first = first_of(c);
    if (components[c].asleep || components[c].size() == 0 || still[first] < kStillTime) continue;
    any = true;
    state_.group[c] = int(first);
    mark(c);
    for (const int u : components[c].speeds) {
      mechanism_.state.change_u()[u] = 0.0;
      if (memory.udot.size() > 0) memory.udot[u] = 0.0;
      if (memory.mean_udot.size() > 0) memory.mean_udot[u] = 0.0;
    }
  }
  if (any) put_to_sleep(memory, records, impulses);
}

void Sleep::put_to_sleep(StepMemory& memory, const std::vector<ContactRecord>& records,
                         const EffortSums& impulses) {
  const auto is_asleep = [this](const auto& contact) {
    return sleeps(contact.collider_a) || sleeps(contact.collider_b);
  };
  move_over(memory.contacts, state_.contacts, is_asleep);
  state_.records.clear();
  std::copy_if(records.begin(), records.end(), std::back_inserter(state_.records), is_asleep);
  const auto keep = [this](const std::vector<int>& by, const std::vector<double>& from,
                           std::vector<double>& to) {
    for (std::size_t i = 0; i < by.size(); ++i)
      if (by[i] >= 0 && state_.group[std::size_t(by[i])] >= 0) to[i] = from[i];
  };
  keep(by_speed_, impulses.joints, state_.impulses.joints);
  keep(by_motor_, impulses.motors, state_.impulses.motors);
}

std::vector<WarmContact> Sleep::all_contacts(const StepMemory& memory) const {
  std::vector<WarmContact> all = memory.contacts, rest = state_.contacts;
  move_over(rest, all, [](const WarmContact&) { return true; });
  return all;
}

}  // namespace cogrsim::dynamics
