#include "drives.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/model/joint_kinematics.h"

namespace cogrsim::simbody {

Drives::Drives(Mechanism& mechanism) : mechanism_(mechanism) {
  const SceneModel& model = mechanism.model();
  for (const Motor& motor : model.motors)
    if (!motor.removed)
      add(mechanism, motor.joint, motor.axis, int(&motor - model.motors.data()), 0.0);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed || joint.axes.empty()) continue;
    for (int i = 0; i < speed_count(joint.type); ++i) {
      const JointAxis& axis = axis_of_speed(joint, i);
      if (axis.friction > 0.0) add(mechanism, int(j), i, -1, axis.friction);
      if (axis.damping > 0.0) add(mechanism, int(j), i, kDamper, 0.0);
    }
  }
}

void Drives::add(Mechanism& mechanism, int joint, int axis, int motor, double friction) {
  const int index = mechanism.joint_link(joint);
  if (index < 0) return;
  const Link& link = mechanism.links()[index];
  Axis made;
  made.motor = motor;
  made.effort = mechanism.model().joints[joint].speed_offset + axis;
  made.q = link.q_map[axis];
  made.u = link.u_map[axis];
  made.link = index;
  made.tree = link.tree;
  made.friction = friction;
  made.ball = mechanism.model().joints[joint].type == JointType::ball;
  made.force = SimTK::Force::MobilityDiscreteForce(mechanism.forces, link.mobod,
                                                   SimTK::MobilizerUIndex(made.u));
  axes_.push_back(made);
}

void Drives::locate() {
  const auto is_soft = [&](const Axis& axis) {
    return axis.motor == kDamper && mechanism_.stiff_damping(axis.effort) == 0.0;
  };
  axes_.erase(std::remove_if(axes_.begin(), axes_.end(), is_soft), axes_.end());
  std::stable_sort(axes_.begin(), axes_.end(),
                   [](const Axis& a, const Axis& b) { return a.tree < b.tree; });
  for (std::size_t i = 0, first = 0; i < axes_.size(); ++i) {
    Axis& axis = axes_[i];
    if (axis.tree != axes_[first].tree) first = i;
    axis.first = first;
    axis.q += mechanism_.links()[axis.link].q;
    axis.u += mechanism_.links()[axis.link].u;
    axis.damping = mechanism_.stiff_damping(axis.effort);
    widest_ = std::max(widest_, i + 1 - first);
  }
  for (Axis& axis : axes_)
    for (std::size_t k = axis.first; k < axes_.size() && axes_[k].tree == axis.tree; ++k)
      if (axes_[k].motor == kDamper && axes_[k].u == axis.u) axis.damper = int(k);
  w_.resize(axes_.size() * widest_);
}

void Drives::find_mobility(const SimTK::State& state) {
  const SimTK::SimbodyMatterSubsystem& matter = mechanism_.matter;
  SimTK::Vector unit(state.getNU(), 0.0), column, held, bias, error, multipliers, f;
  SimTK::FactorQTZ projected;
  if (mechanism_.has_loops()) {
    SimTK::Matrix GMInvGt;
    matter.calcProjectedMInv(state, GMInvGt);
    projected.factor(GMInvGt, GMInvGt.nrow() * SimTK::SignificantReal);
    matter.calcBiasForMultiplyByG(state, bias);
  }
  // One axis of every tree at a time: trees are independent of each other.
  for (std::size_t k = 0; k < widest_; ++k) {
    unit = 0.0;
    for (std::size_t i = 0; i < axes_.size(); ++i)
      if (i - axes_[i].first == k) unit[axes_[i].u] = 1.0;
    matter.multiplyByMInv(state, unit, column);
    if (mechanism_.has_loops()) {
      matter.multiplyByG(state, column, bias, error);
      projected.solve(error, multipliers);
      matter.multiplyByGTranspose(state, multipliers, f);
      matter.multiplyByMInv(state, f, held);
      column -= held;
    }
    for (std::size_t i = 0; i < axes_.size(); ++i) w_[i * widest_ + k] = column[axes_[i].u];
  }
}

void Drives::set(SimTK::State& state, double dt, const std::vector<Drive>& drives) {
  for (Axis& axis : axes_) axis.force.setMobilityForce(state, 0.0);
  mechanism_.system.realize(state, SimTK::Stage::Acceleration);
  find_mobility(state);
  const SimTK::Vector &q = state.getQ(), &u = state.getU();
  const SimTK::Vector a = state.getUDot();
  // Against the angular velocity that a ball would have, none of its axes by itself.
  std::vector<double> share(axes_.size(), 1.0);
  for (std::size_t i = 0; i + 2 < axes_.size(); ++i) {
    if (!axes_[i].ball) continue;
    Vec3 free;
    for (int k = 0; k < 3; ++k) free[k] = u[axes_[i].u + k] + dt * a[axes_[i].u + k];
    for (int k = 0; k < 3; ++k) share[i++] = std::abs(free[k]) / std::max(free.norm(), 1e-300);
    --i;
  }
  constexpr int kSweeps = 50;
  constexpr double kSettled = 1e-12;  // of the largest effort
  for (Axis& axis : axes_) axis.now = 0.0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double change = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      Axis& axis = axes_[i];
      const double own = w(i, i);
      if (!(own > 0.0)) continue;                // held by a loop, or prescribed
      double free = u[axis.u] + dt * a[axis.u];  // speed at the end without this axis
      for (std::size_t k = axis.first; k < axes_.size() && axes_[k].tree == axis.tree; ++k)
        if (k != i && int(k) != axis.damper) free += dt * w(i, k) * axes_[k].now;
      // A stiff damper of the axis makes it heavier, u = (free + dt own effort) / give.
      const double give = 1.0 + dt * axis.damping * own, soft = own / give;
      free /= give;
      if (axis.motor == kDamper) {
        axis.now = -axis.damping * free;
        continue;
      }
      Drive law;
      law.kd = std::numeric_limits<double>::infinity();
      law.max_effort = axis.friction * share[i];
      if (axis.motor >= 0) law = drives[axis.motor];
      const double wanted = law.is_speed_source()
                                ? (law.velocity - free) / (dt * soft)
                                : (law.bias + law.kp * (law.position - q[axis.q] - dt * free) +
                                   law.kd * (law.velocity - free)) /
                                      (1.0 + (law.kd + law.kp * dt) * dt * soft);
      const double effort = std::clamp(wanted, -law.max_effort, law.max_effort);
      change = std::max(change, std::abs(effort - axis.now));
      largest = std::max(largest, std::abs(effort));
      axis.now = effort;
      if (axis.damper >= 0) axes_[axis.damper].now = -axis.damping * (free + dt * soft * effort);
    }
    if (change <= kSettled * largest) break;
  }
  for (const Axis& axis : axes_) axis.force.setMobilityForce(state, axis.now);
}

void Drives::get_efforts(const SimTK::State& state, std::vector<double>& joints,
                         std::vector<double>& motors) const {
  for (const Axis& axis : axes_) {
    const double effort = axis.force.getMobilityForce(state);
    joints[axis.effort] += effort;
    if (axis.motor >= 0) motors[axis.motor] = effort;
  }
}

}  // namespace cogrsim::simbody
