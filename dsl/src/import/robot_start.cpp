// Where the joints and links of an imported robot start: positions within limits, couplings, loops.
#include "import/robot_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace cogrsim::dsl::import {

Pose travel(const RobotJoint& j, double q, const Quat& turn_of_ball) {
  using Type = RobotJoint::Type;
  if (j.type == Type::hinge) {
    const Quat turn(Eigen::AngleAxisd(q, j.axis));
    return {j.anchor - turn * j.anchor, turn};
  }
  if (j.type == Type::slider) return {q * j.axis, Quat::Identity()};
  if (j.type == Type::ball || j.type == Type::gimbal)
    return {j.anchor - turn_of_ball * j.anchor, turn_of_ball};
  return {};
}

namespace {

/// Where it starts: its position, or the limit nearest to it.
double start_of(const RobotJoint& j) { return std::clamp(j.position, j.lower, j.upper); }

}  // namespace

RobotStart::RobotStart(Context& context, const RobotModel& robot)
    : context_(context), robot_(robot), inboard_(robot.links.size(), nullptr) {
  find_couplings();
  for (const RobotJoint& j : robot_.joints) inboard_[j.child] = &j;
  poses_ = find_poses([this](const RobotJoint& j) { return travel(j, position(j), j.turn); });
  zero_poses_ = find_poses([](const RobotJoint&) { return Pose(); });
  for (std::size_t i = 0; i < poses_.size(); ++i)
    moved_ |= (poses_[i].p - zero_poses_[i].p).norm() > 1e-9 ||
              poses_[i].q.angularDistance(zero_poses_[i].q) > 1e-9;
}

std::vector<Pose> RobotStart::poses_at_rest() const {
  return find_poses([](const RobotJoint& j) { return travel(j, j.rest, Quat::Identity()); });
}

const RobotJoint* RobotStart::coupled_above(int link) const {
  while (link >= 0) {
    const RobotJoint* const j = inboard_[link];
    if (j == nullptr) return nullptr;
    const auto start = followers_.find(j);
    if (start != followers_.end() && start->second != 0.0) return j;
    link = j->parent;
  }
  return nullptr;
}

bool RobotStart::closes(const RobotJoint& j) {
  const auto left_out = [&](std::string why) {
    context_.left_out(j.at, fmt::format("loop '{}'", j.name), std::move(why));
    return false;
  };
  if (j.parent == j.child || (robot_.stands(j.parent) && robot_.stands(j.child)))
    return left_out("joins what does not move");
  if (!followers_.empty() && coupled_above(j.parent) != coupled_above(j.child))
    return left_out("a coupling with an offset moves a joint of it at the start");
  // A loop's first joint attaches a free tree, which then moves about it.
  const auto end = [&](int link) {
    while (link >= 0 && inboard_[link] != nullptr && inboard_[link]->type != RobotJoint::Type::free)
      link = inboard_[link]->parent;
    for (auto on = attached_.find(link); on != attached_.end(); on = attached_.find(link))
      link = on->second;
    return robot_.stands(link) ? -1 : link;
  };
  const int a = end(j.parent), b = end(j.child);
  if (a != b)
    attached_[std::max(a, b)] = std::min(a, b);
  else if (!attached_.empty() && moved_)
    return left_out("another one holds the robot, whose joints do not start at their zeros");
  if (j.parent < 0) return true;
  const Vec3 in_parent = zero_poses_[j.parent].inverse() * (zero_poses_[j.child] * j.anchor);
  const double gap = (poses_[j.parent] * in_parent - poses_[j.child] * j.anchor).norm();
  if (gap < 1e-4) return true;
  return left_out(
      fmt::format("is open by {:.3g} m at the start, which is not at the joints' zeros", gap));
}

std::vector<Pose> RobotStart::find_poses(
    const std::function<Pose(const RobotJoint&)>& moved_by) const {
  std::vector<Pose> out;
  for (const RobotLink& l : robot_.links) out.push_back(l.X);
  std::vector<bool> known(robot_.links.size(), true);
  for (const RobotJoint& j : robot_.joints) known[j.child] = false;
  bool moved = true;
  while (moved) {
    moved = false;
    for (const RobotJoint& j : robot_.joints) {
      const auto child = static_cast<std::size_t>(j.child);
      if (known[child] || (j.parent >= 0 && !known[j.parent])) continue;
      const Pose parent = j.parent < 0 ? Pose() : out[j.parent];
      out[child] = parent * j.X_PC * moved_by(j);
      known[child] = true;
      moved = true;
    }
  }
  return out;
}

void RobotStart::find_couplings() {
  std::unordered_map<std::string, const RobotJoint*> named;
  for (const RobotJoint& j : robot_.joints) named.emplace(j.name, &j);
  std::unordered_map<const RobotJoint*, std::vector<const RobotJoint*>> followers;
  std::unordered_map<const RobotJoint*, std::size_t> waits_for;
  std::vector<const RobotJoint*> ready;
  for (const RobotJoint& j : robot_.joints) {
    if (!j.coupling) {
      ready.push_back(&j);
      continue;
    }
    for (const RobotCoupling::Term& t : j.coupling->terms)
      followers[named.at(t.joint)].push_back(&j);
    waits_for[&j] = j.coupling->terms.size();
  }
  for (std::size_t i = 0; i < ready.size(); ++i) {
    if (ready[i]->coupling) couple(*ready[i], named);
    for (const RobotJoint* const j : followers[ready[i]])
      if (--waits_for[j] == 0) ready.push_back(j);
  }
  for (const RobotJoint& j : robot_.joints)
    if (waits_for[&j] > 0)
      uncoupled_[&j] = j.coupling->terms.size() == 1 && j.coupling->terms[0].joint == j.name
                           ? "it is coupled to itself"
                           : "the couplings form a cycle";
}

void RobotStart::couple(const RobotJoint& j,
                        const std::unordered_map<std::string, const RobotJoint*>& named) {
  constexpr double kOff = 1e-6;
  double start = j.coupling->offset;
  bool one_axis = j.has_one_axis();
  for (const RobotCoupling::Term& t : j.coupling->terms) {
    const RobotJoint& other = *named.at(t.joint);
    start += t.ratio * position(other);
    one_axis = one_axis && other.has_one_axis();
  }
  std::string& why = uncoupled_[&j];
  if (!one_axis) {
    why = "only joints with one axis are coupled";
  } else if (!std::isfinite(start)) {
    why = "it would start at infinity";
  } else if (start < j.lower - kOff || start > j.upper + kOff) {
    why = fmt::format("it would start at {}, beyond its limits", start);
  } else {
    uncoupled_.erase(&j);
    if (j.position != 0.0 && std::abs(start - j.position) > kOff)
      context_.approximate(
          j.at, fmt::format("joint '{}'", j.name),
          fmt::format("its coupling puts it at {} at the start, not at {}", start, j.position));
    followers_.emplace(&j, start);
    coupled_.push_back(&j);
  }
}

double RobotStart::position(const RobotJoint& j) const {
  const auto found = followers_.find(&j);
  return found == followers_.end() ? start_of(j) : found->second;
}

}  // namespace cogrsim::dsl::import
