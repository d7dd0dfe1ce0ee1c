#include "cogrsim/physics/coupled_efforts.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "cogrsim/physics/tree_dynamics.h"

namespace cogrsim {

namespace {

/// Share of an error that is taken back in a step. Stable where what stiffens the mechanism beyond
/// the mass matrix leaves at least b / (1 + b) of its mobility.
constexpr double kTakenBack = 0.1;
/// Steps of a millisecond or so in which no mechanism turns enough to change its mass matrix by 10 %.
constexpr int kRefresh = 10;
/// A speed source is as stiff as this many times the inertia of its axis.
constexpr double kSource = 1e6;
/// Drives come to their bounds and leave them one after the other.
constexpr int kMostTrials = 6;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

}  // namespace

/// What joints and couplings hold together, as a scene of its own.
struct CoupledEfforts::Tree {
  struct Term {
    int row, speed;  ///< of the tree
    double coefficient;
    int whole;  ///< speed of the whole scene
  };
  struct Driven {
    int motor, speed, position;
  };
  WorldState part_of(const SceneModel& model, const WorldState& state) const;
  Eigen::MatrixXd mass(const WorldState& part) const;
  Eigen::VectorXd speeds(const WorldState& part) const;
  Eigen::VectorXd errors(const SceneModel& model, const WorldState& state) const;

  SceneModel scene;
  std::vector<int> bodies, joints, couplings;  ///< in the whole scene
  std::vector<Term> terms;
  std::vector<Driven> motors;
  std::vector<int> floating;  ///< of its bodies: those whose six speeds follow the joints'
};

struct CoupledEfforts::Past {
  Eigen::MatrixXd mass;
  Eigen::VectorXd speeds;  ///< at its start; none: nothing is known
  Eigen::VectorXd given;   ///< efforts of couplings and springs
};

WorldState CoupledEfforts::Tree::part_of(const SceneModel& model, const WorldState& state) const {
  WorldState part;
  for (const int b : bodies) {
    part.poses.push_back(state.poses[index(b)]);
    part.twists.push_back(state.twists[index(b)]);
  }
  const auto take = [](auto& to, const auto& from, int first, int count) {
    to.insert(to.end(), from.begin() + first, from.begin() + first + count);
  };
  for (const int j : joints) {
    const Joint& joint = model.joints[index(j)];
    take(part.joint_positions, state.joint_positions, joint.position_offset,
         position_count(joint.type));
    take(part.joint_velocities, state.joint_velocities, joint.speed_offset,
         speed_count(joint.type));
  }
  return part;
}

Eigen::MatrixXd CoupledEfforts::Tree::mass(const WorldState& part) const {
  Eigen::MatrixXd out = mass_matrix(scene, part);
  // A joint that closes a loop has no inertia there; too little is on the safe side.
  for (const Joint& joint : scene.joints) {
    if (!joint.closes_loop) continue;
    const Body& body = scene.bodies[index(std::max(joint.child, 0))];
    const double inertia = std::min(body.mass, body.inertia.diagonal().minCoeff());
    for (int k = 0; k < speed_count(joint.type); ++k)
      out(joint.speed_offset + k, joint.speed_offset + k) = inertia;
  }
  return out;
}

Eigen::VectorXd CoupledEfforts::Tree::speeds(const WorldState& part) const {
  Eigen::VectorXd out(scene.joint_speeds + 6 * Eigen::Index(floating.size()));
  std::copy(part.joint_velocities.begin(), part.joint_velocities.end(), out.begin());
  Eigen::Index first = scene.joint_speeds;
  for (const int b : floating) {
    out.segment<3>(first) = part.twists[index(b)].linear;
    out.segment<3>(first + 3) = part.twists[index(b)].angular;
    first += 6;
  }
  return out;
}

Eigen::VectorXd CoupledEfforts::Tree::errors(const SceneModel& model,
                                             const WorldState& state) const {
  Eigen::VectorXd out(Eigen::Index(couplings.size()));
  const auto q = [&](int j) {
    return state.joint_positions[index(model.joints[index(j)].position_offset)];
  };
  for (std::size_t row = 0; row < couplings.size(); ++row) {
    const Coupling& coupling = model.couplings[index(couplings[row])];
    double error = q(coupling.joint) - coupling.offset;
    for (const CouplingTerm& term : coupling.terms) error -= term.ratio * q(term.joint);
    out[Eigen::Index(row)] = error;
  }
  return out;
}

struct CoupledEfforts::Plan {
  SceneModelPtr model;
  std::vector<Tree> trees;
};

namespace {

/// Numbers of what is held together, by body; -1: none of its joints is coupled to any other.
std::vector<int> find_groups(const SceneModel& model) {
  std::vector<int> root(model.bodies.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int b) {
    while (root[index(b)] != b) b = root[index(b)];
    return b;
  };
  const auto is_mobile = [&](int b) {
    return b != kWorld && !model.bodies[index(b)].removed &&
           model.bodies[index(b)].kind == BodyKind::dynamic;
  };
  const auto join = [&](int a, int b) {
    if (is_mobile(a) && is_mobile(b))
      root[index(std::max(find(a), find(b)))] = std::min(find(a), find(b));
  };
  const auto mobile_end = [&](int j) {
    const Joint& joint = model.joints[index(j)];
    return is_mobile(joint.child) ? joint.child : joint.parent;
  };
  for (const Joint& joint : model.joints)
    if (!joint.removed) join(joint.parent, joint.child);
  for (const Coupling& coupling : model.couplings) {
    for (std::size_t t = 0; !coupling.removed && t < coupling.terms.size(); ++t)
      join(mobile_end(coupling.joint), mobile_end(coupling.terms[t].joint));
  }
  std::vector<int> out(root.size(), -1);
  std::vector<char> coupled(root.size());
  for (const Coupling& coupling : model.couplings) {
    if (!coupling.removed && is_mobile(mobile_end(coupling.joint)))
      coupled[index(find(mobile_end(coupling.joint)))] = 1;
  }
  for (std::size_t b = 0; b < out.size(); ++b) {
    const int group = find(static_cast<int>(b));
    if (is_mobile(static_cast<int>(b)) && coupled[index(group)]) out[b] = group;
  }
  return out;
}

}  // namespace

void CoupledEfforts::take_scene(const SceneModelPtr& model) {
  const bool any = std::any_of(model->couplings.begin(), model->couplings.end(),
                               [](const Coupling& coupling) { return !coupling.removed; });
  if (!any) {
    *this = {};
    return;
  }
  auto plan = std::make_shared<Plan>();
  plan->model = model;
  const std::vector<int> group = find_groups(*model);
  std::vector<int> roots = group;
  std::sort(roots.begin(), roots.end());
  roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
  for (const int root : roots) {
    if (root < 0) continue;
    Tree& tree = plan->trees.emplace_back();
    std::vector<int> body_of(model->bodies.size(), kWorld), speed_of(model->joints.size(), -1);
    tree.scene.physics.gravity = model->physics.gravity;
    const auto take_body = [&](int b) {
      if (b == kWorld || body_of[index(b)] != kWorld) return;
      body_of[index(b)] = static_cast<int>(tree.bodies.size());
      tree.bodies.push_back(b);
      tree.scene.bodies.push_back(model->bodies[index(b)]);
      tree.scene.bodies.back().shapes.clear();
    };
    for (std::size_t b = 0; b < group.size(); ++b)
      if (group[b] == root) take_body(static_cast<int>(b));
    for (std::size_t j = 0; j < model->joints.size(); ++j) {
      Joint joint = model->joints[j];
      const auto is_here = [&](int b) { return b != kWorld && group[index(b)] == root; };
      if (joint.removed || (!is_here(joint.parent) && !is_here(joint.child))) continue;
      take_body(joint.parent);
      take_body(joint.child);
      if (joint.parent != kWorld) joint.parent = body_of[index(joint.parent)];
      if (joint.child != kWorld) joint.child = body_of[index(joint.child)];
      joint.position_offset = tree.scene.joint_positions;
      joint.speed_offset = speed_of[j] = tree.scene.joint_speeds;
      tree.scene.joint_positions += position_count(joint.type);
      tree.scene.joint_speeds += speed_count(joint.type);
      tree.joints.push_back(static_cast<int>(j));
      tree.scene.joints.push_back(std::move(joint));
    }
    for (std::size_t c = 0; c < model->couplings.size(); ++c) {
      const Coupling& coupling = model->couplings[c];
      if (coupling.removed || speed_of[index(coupling.joint)] < 0) continue;
      const int row = static_cast<int>(tree.couplings.size());
      tree.couplings.push_back(static_cast<int>(c));
      const auto take_term = [&](int j, double coefficient) {
        if (speed_of[index(j)] >= 0)
          tree.terms.push_back(
              {row, speed_of[index(j)], coefficient, model->joints[index(j)].speed_offset});
      };
      take_term(coupling.joint, 1.0);
      for (const CouplingTerm& term : coupling.terms) take_term(term.joint, -term.ratio);
    }
    for (std::size_t m = 0; m < model->motors.size(); ++m) {
      const Motor& motor = model->motors[m];
      if (motor.removed || speed_of[index(motor.joint)] < 0) continue;
      const auto held = std::find(tree.joints.begin(), tree.joints.end(), motor.joint);
      const Joint& joint = tree.scene.joints[std::size_t(held - tree.joints.begin())];
      tree.motors.push_back({static_cast<int>(m), joint.speed_offset + motor.axis,
                             joint.position_offset + motor.axis});
    }
    tree.floating = floating_bases(tree.scene);
  }
  plan_ = std::move(plan);
  by_speed_.assign(index(model->joint_speeds), 0.0);
  forget();
}

void CoupledEfforts::forget() {
  past_.clear();
  age_ = 0;
  std::fill(by_speed_.begin(), by_speed_.end(), 0.0);
}

void CoupledEfforts::add_to(std::vector<double>& joint_efforts) const {
  for (std::size_t i = 0; i < by_speed_.size(); ++i) joint_efforts[i] += by_speed_[i];
}

void CoupledEfforts::find(double dt, const WorldState& state, const std::vector<Drive>& drives) {
  past_.resize(plan_->trees.size());
  std::fill(by_speed_.begin(), by_speed_.end(), 0.0);
  for (std::size_t k = 0; k < past_.size(); ++k) {
    auto next = past_[k] ? std::make_shared<Past>(*past_[k]) : std::make_shared<Past>();
    find(plan_->trees[k], *next, dt, state, drives);
    past_[k] = std::move(next);
  }
  age_ = (age_ + 1) % kRefresh;
}

void CoupledEfforts::find(const Tree& tree, Past& past, double dt, const WorldState& state,
                          const std::vector<Drive>& drives) {
  const SceneModel& scene = tree.scene;
  const WorldState part = tree.part_of(*plan_->model, state);
  if (past.mass.size() == 0 || age_ == 0) past.mass = tree.mass(part);
  const Eigen::MatrixXd& mass = past.mass;
  const Eigen::Index size = mass.rows();
  const Eigen::VectorXd now = tree.speeds(part);

  // Laws along speeds: gain (v - u+) with held = gain v; springs are known when the step begins.
  struct Law {
    int speed;
    double gain, held, most;
    int at_bound = 0;
  };
  std::vector<Law> laws;
  Eigen::VectorXd springs = Eigen::VectorXd::Zero(size), last = past.given;
  for (const Joint& joint : scene.joints) {
    for (std::size_t i = 0; i < joint.axes.size() && joint.type != JointType::ball; ++i) {
      const int speed = joint.speed_offset + static_cast<int>(i);
      const JointAxis& axis = joint.axes[i];
      if (axis.stiffness > 0.0) {
        const double q = part.joint_positions[index(joint.position_offset) + i];
        springs[speed] += axis.stiffness * (axis.rest - q);
      }
      if (axis.damping <= 0.0) continue;
      laws.push_back({speed, axis.damping, 0.0, std::numeric_limits<double>::infinity()});
      if (last.size() > 0) last[speed] -= axis.damping * now[speed];
    }
  }
  for (const Tree::Driven& driven : tree.motors) {
    const Drive& drive = drives[index(driven.motor)];
    const bool source = drive.is_speed_source();
    const double own = kSource * mass(driven.speed, driven.speed) / dt;
    const double q = part.joint_positions[index(driven.position)];
    laws.push_back({driven.speed, source ? own : drive.kd + dt * drive.kp,
                    source
                        ? own * drive.velocity
                        : drive.bias + drive.kp * (drive.position - q) + drive.kd * drive.velocity,
                    drive.max_effort});
    if (last.size() > 0) last[driven.speed] += state.motor_efforts[index(driven.motor)];
  }

  // h f: at first the weights and what turning makes of it.
  const Eigen::VectorXd other =
      past.speeds.size() == size
          ? Eigen::VectorXd(mass * (now - past.speeds) - dt * last)
          : Eigen::VectorXd(-dt * inverse_dynamics(scene, part, Eigen::VectorXd::Zero(size)));
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(size, Eigen::Index(tree.couplings.size()));
  for (const Tree::Term& term : tree.terms) rows(term.speed, term.row) += term.coefficient;
  Eigen::VectorXd wanted = tree.errors(*plan_->model, state) * (-kTakenBack / dt), efforts;
  for (int trial = 0; trial < kMostTrials; ++trial) {
    Eigen::MatrixXd held = mass;
    Eigen::VectorXd impulse = mass * now + other + dt * springs;
    for (const Law& law : laws) {
      if (law.at_bound == 0) held(law.speed, law.speed) += dt * law.gain;
      impulse[law.speed] += dt * (law.at_bound != 0 ? law.at_bound * law.most : law.held);
    }
    const Eigen::LDLT<Eigen::MatrixXd> solver(held);
    const Eigen::MatrixXd moved = solver.solve(rows);
    Eigen::VectorXd end = solver.solve(impulse);
    Eigen::MatrixXd mobility = rows.transpose() * moved;
    mobility.diagonal() *= 1.0 + 1e-9;  // two that say the same share the effort
    efforts = mobility.ldlt().solve(wanted - rows.transpose() * end) / dt;
    for (Eigen::Index row = 0; row < efforts.size(); ++row) {
      const double most =
          plan_->model->couplings[index(tree.couplings[std::size_t(row)])].max_effort;
      efforts[row] = std::clamp(efforts[row], -most, most);
    }
    end += dt * moved * efforts;
    bool changed = false;
    for (Law& law : laws) {
      const double effort = law.held - law.gain * end[law.speed];
      const int beyond = std::abs(effort) <= law.most ? 0 : effort > 0.0 ? 1 : -1;
      changed |= std::exchange(law.at_bound, beyond) != beyond;
    }
    if (!changed) break;
  }
  past.speeds = now;
  past.given = rows * efforts;
  for (const Tree::Term& term : tree.terms)
    by_speed_[index(term.whole)] += term.coefficient * efforts[term.row];
  past.given += springs;
}

}  // namespace cogrsim
