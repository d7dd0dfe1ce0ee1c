#include "mechanism/mechanism.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mechanism/loops.h"

namespace cogrsim::dynamics {
namespace {

constexpr double kClosed = 1e-13;      // [m], [rad]: what project() brings closed loops to, and
constexpr int kMostProjections = 100;  // largest number of projections;
constexpr double kLeastShare = 1e-2;   // steps no shorter than this share of one of them;
constexpr double kCannotClose = 1e-6;  // what of a gap is then an error.

}  // namespace

Mechanism::Mechanism(SceneModelPtr model) : model_(std::move(model)), plan_(plan_tree(*model_)) {
  links_.reserve(plan_.links.size());
  int nq = 0, nu = 0;
  for (const PlannedLink& plan : plan_.links) {
    Link link = make_link(plan);
    link.first_q = nq;
    link.first_u = nu;
    nq += link.nq;
    nu += link.nu;
    if (link.has_quaternion) quaternions_.push_back(link.first_q);
    links_.push_back(std::move(link));
  }
  plan_.links = {};
  state = State(nq, nu);
  set_external({});
  make_components();
  for (const Link& link : links_) {
    if (link.plan.joint < 0) {
      const Body& body = model_->bodies[std::size_t(link.plan.body)];
      set_base(link, body.X_WB, body.V_WB);
    } else {
      const Joint& joint = model_->joints[std::size_t(link.plan.joint)];
      set_joint(link, joint.position.data(), joint.velocity.data());
    }
  }
  if (has_loops_) project();
}

Link Mechanism::make_link(const PlannedLink& plan) const {
  const Body& body = model_->bodies[std::size_t(plan.body)];
  Link link;
  link.plan = plan;
  if (plan.joint >= 0) link.mounting = std::make_unique<Mounting>(mount(*model_, plan));
  link.kinematic = body.kind == BodyKind::kinematic;
  link.component = plan.component;
  link.mass = plan.share * body.mass;
  link.com = body.com;
  link.inertia = plan.share * body.inertia;
  // With the inertia I = C C^T its inverse is C^-T C^-1.
  const Mat3 upper = link.inertia.llt().matrixU();
  link.root = upper.inverse();
  const JointType type =
      plan.joint < 0 ? JointType::free : model_->joints[std::size_t(plan.joint)].type;
  link.nq = position_count(type);
  link.nu = speed_count(type);
  link.has_quaternion = type == JointType::free || type == JointType::ball;
  if (type == JointType::free) {
    link.q_map = {4, 5, 6, 0, 1, 2, 3};
    link.u_map = {3, 4, 5, 0, 1, 2};
  }
  return link;
}

void Mechanism::make_components() {
  components_.reserve(std::size_t(links_.empty() ? 0 : links_.back().component + 1));
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    has_loops_ = has_loops_ || link.plan.shadow;
    if (link.component < 0) continue;
    if (link.component == int(components_.size())) {
      Component& c = components_.emplace_back();
      c.links.first = int(i);
      c.speeds.first = link.first_u;
    }
    Component& c = components_.back();
    ++c.links.count;
    c.speeds.count += link.nu;
  }
  for (Component& c : components_) {
    c.is_free_body = c.links.size() == 1 && links_[std::size_t(c.links[0])].plan.joint < 0;
    if (c.is_free_body) continue;
    c.linkage = std::make_unique<Linkage>();
    arrange(c);
    c.linkage->motion.resize(std::size_t(c.size()));
    add_rotors(c);
  }
}

void Mechanism::arrange(Component& c) const {
  for (const int i : c.links) {
    const Link& link = links_[std::size_t(i)];
    const int first = link.first_u - c.speeds.first;
    c.linkage->first.push_back(first);
    c.linkage->inboard.push_back(c.find(link.plan.parent));
    if (c.linkage->inboard.back() < 0) c.linkage->trees.push_back({first, first});
    c.linkage->tree.push_back(int(c.linkage->trees.size()) - 1);
    c.linkage->trees.back().end = first + link.nu;
  }
  for (int i : c.links) {
    const PlannedLink& plan = links_[std::size_t(i)].plan;
    if (!plan.shadow) continue;
    Weld weld;
    weld.shadow = i;
    weld.primary = body_link(plan.body);
    weld.shadow_at = c.find(weld.shadow);
    weld.primary_at = c.find(weld.primary);
    const Linkage::Range& a =
        c.linkage->trees[std::size_t(c.linkage->tree[std::size_t(weld.shadow_at)])];
    const Linkage::Range& b =
        c.linkage->trees[std::size_t(c.linkage->tree[std::size_t(weld.primary_at)])];
    weld.first = std::min(a.first, b.first);
    weld.end = std::max(a.end, b.end);
    c.linkage->welds.push_back(weld);
  }
}

void Mechanism::add_rotors(Component& c) const {
  for (std::size_t at = 0; at < c.links.size(); ++at) {
    const Link& link = links_[std::size_t(c.links[at])];
    if (link.plan.joint < 0) continue;
    const Joint& joint = model_->joints[std::size_t(link.plan.joint)];
    for (int k = 0; k < link.nu && !joint.axes.empty(); ++k) {
      const std::size_t axis = joint.type == JointType::ball ? 0 : std::size_t(k);
      const double rotor = joint.axes[axis].rotor_inertia;
      if (rotor <= 0.0) continue;
      c.linkage->rotors.resize(std::size_t(c.size()));
      c.linkage->rotors[std::size_t(c.linkage->first[at] + link.u_map[std::size_t(k)])] = rotor;
    }
  }
}

void Mechanism::set_external(const std::vector<Wrench>& forces) {
  loads_.resize(links_.size());
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    Wrench& load = loads_[i];
    load = {};
    if (link.kinematic) continue;
    load.force = model_->bodies[std::size_t(link.plan.body)].gravity_scale * link.mass *
                 model_->physics.gravity;
    if (forces.empty()) continue;
    // A body that was cut to open a loop shares them as it shares its mass.
    const Wrench& external = forces[std::size_t(link.plan.body)];
    load.force += link.plan.share * external.force;
    load.torque += link.plan.share * external.torque;
  }
}

int Mechanism::axis_speed(int joint, int axis) const {
  const int index = joint_link(joint);
  if (index < 0) return -1;
  const Link& link = links_[std::size_t(index)];
  return link.first_u + link.u_map[std::size_t(axis)];
}

int Mechanism::axis_position(int joint, int axis) const {
  const int index = joint_link(joint);
  if (index < 0) return -1;
  const Link& link = links_[std::size_t(index)];
  return link.first_q + link.q_map[std::size_t(axis)];
}

const std::vector<LinkMotion>& Mechanism::motions() const {
  const std::int64_t q = state.q_version(), u = state.u_version();
  if (q == q_version_ && u == u_version_) return motions_;
  const double* const coordinates = state.q().data();
  if (q != q_version_) find_poses(*model_, links_, coordinates, motions_);
  find_velocities(*model_, links_, coordinates, state.u().data(), motions_);
  q_version_ = q;
  u_version_ = u;
  return motions_;
}

void Mechanism::multiply_by_n(const Values& u, Values& out) const {
  if (out.size() != state.nq()) out.resize(state.nq());
  find_rates(links_, state.q().data(), u.data(), out.data());
}

void Mechanism::normalize_quaternions() {
  Values& q = state.change_q();
  for (int first : quaternions_) {
    double* const p = &q[first];
    const double norm = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
    for (int k = 0; k < 4; ++k) p[k] /= norm;
  }
}

void Mechanism::project() {
  normalize_quaternions();
  if (!has_loops_) return;
  close_coordinates();
  project_speeds();
}

void Mechanism::close_coordinates() {
  static thread_local std::vector<double> gaps, change;
  Values from, shift(state.nu()), rates;
  double before = std::numeric_limits<double>::infinity(), share = 1.0;
  const auto measure = [&](Component& c) {
    gaps.resize(6 * c.linkage->welds.size());
    return find_loop_gaps(*this, c, gaps.data());
  };
  for (int count = 0; count < kMostProjections; ++count) {
    double most = 0.0;
    for (Component& c : components_)
      if (c.has_loops()) most = std::max(most, measure(c));
    // What is left does not get less: rounding.
    if (most <= kClosed || (most < kCannotClose && most > 0.5 * before)) return;
    if (most < before || share < kLeastShare) {
      share = 1.0;
      before = most;
      shift.setZero();
      for (Component& c : components_) {
        if (!c.has_loops() || !(measure(c) > kClosed)) continue;
        update_component(*this, c);
        change.assign(std::size_t(c.size()), 0.0);
        for (double& e : gaps) e = -e;
        close_loops(c, change.data(), gaps.data());
        for (int k = 0; k < c.size(); ++k) shift[c.speeds[std::size_t(k)]] = change[std::size_t(k)];
      }
      from = state.q();
      multiply_by_n(shift, rates);
    } else {
      share *= 0.5;  // too far for a straight path
    }
    state.change_q() = from + share * rates;
    normalize_quaternions();
  }
  if (!(before < kCannotClose))
    throw std::runtime_error("joints that close a loop cannot all be satisfied");
}

void Mechanism::project_speeds() {
  static thread_local std::vector<double> wanted, change;
  Values projected = state.u();
  for (Component& c : components_) {
    if (!c.has_loops()) continue;
    update_component(*this, c);
    wanted.resize(6 * c.linkage->welds.size());
    find_loop_speeds(*this, c, wanted.data());
    for (double& e : wanted) e = -e;
    change.assign(std::size_t(c.size()), 0.0);
    close_loops(c, change.data(), wanted.data());
    for (int k = 0; k < c.size(); ++k)
      projected[c.speeds[std::size_t(k)]] += change[std::size_t(k)];
  }
  state.change_u() = projected;
}

void Mechanism::set_base(const Link& link, const Pose& X_WB, const Twist& V_WB) {
  Values& q = state.change_q();
  Values& u = state.change_u();
  const Vec3 r = link.kinematic ? Vec3::Zero() : Vec3(X_WB.q * link.com);
  const Vec3 p = X_WB.p + r, v = V_WB.at(r);
  q[link.first_q] = X_WB.q.w();
  for (int k = 0; k < 3; ++k) {
    q[link.first_q + 1 + k] = X_WB.q.vec()[k];
    q[link.first_q + 4 + k] = p[k];
    u[link.first_u + k] = V_WB.angular[k];
    u[link.first_u + 3 + k] = v[k];
  }
}

void Mechanism::set_joint(const Link& link, const double* q, const double* u) {
  Values& all_q = state.change_q();
  Values& all_u = state.change_u();
  for (int k = 0; k < link.nq; ++k) all_q[link.first_q + link.q_map[std::size_t(k)]] = q[k];
  for (int k = 0; k < link.nu; ++k) all_u[link.first_u + link.u_map[std::size_t(k)]] = u[k];
}

void Mechanism::get_joint(const Link& link, double* q, double* u) const {
  const Values& all_q = state.q();
  const Values& all_u = state.u();
  for (int k = 0; k < link.nq; ++k) q[k] = all_q[link.first_q + link.q_map[std::size_t(k)]];
  for (int k = 0; k < link.nu; ++k) u[k] = all_u[link.first_u + link.u_map[std::size_t(k)]];
}

}  // namespace cogrsim::dynamics
