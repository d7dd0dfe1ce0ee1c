#include "cogrsim/physics/frame.h"

#include <cassert>
#include <cmath>

#include "cogrsim/core/random.h"

namespace cogrsim {
namespace {

/// Calls `use(body, pose, twist)` for every dynamic body that is not removed.
template <class Use>
void for_each_dynamic(const SceneModel& model, const WorldState& state, Use use) {
  assert(state.poses.size() == model.bodies.size() && state.twists.size() == model.bodies.size());
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    if (body.kind == BodyKind::dynamic && !body.removed) use(body, state.poses[i], state.twists[i]);
  }
}

double spring_energy(const Joint& joint, const double* q) {
  double energy = 0.0;
  for (std::size_t i = 0; i < joint.axes.size(); ++i) {
    const JointAxis& axis = joint.axes[i];
    if (axis.stiffness == 0.0) continue;
    const double stretch = joint.type == JointType::ball
                               ? 2 * std::atan2(std::hypot(q[1], q[2], q[3]), std::abs(q[0]))
                               : q[i] - axis.rest;
    energy += 0.5 * axis.stiffness * stretch * stretch;
  }
  return energy;
}

double rotor_energy(const Joint& joint, const double* u) {
  double energy = 0.0;
  for (std::size_t i = 0; i < joint.axes.size(); ++i) {
    // The one axis of a ball stands for its three speeds.
    const bool ball = joint.type == JointType::ball;
    const double square = ball ? Eigen::Map<const Vec3>(u).squaredNorm() : u[i] * u[i];
    energy += 0.5 * joint.axes[i].rotor_inertia * square;
  }
  return energy;
}

std::uint64_t hash_numbers(const double* numbers, std::size_t count, std::uint64_t hash) {
  return hash_bytes(numbers, count * sizeof(double), hash);
}

}  // namespace

bool covers(const FrameContents& has, const FrameContents& wanted) {
  return (has.contacts || !wanted.contacts) && (has.joint_reactions || !wanted.joint_reactions) &&
         (has.accelerations || !wanted.accelerations);
}

FrameContents operator|(const FrameContents& a, const FrameContents& b) {
  return {a.contacts || b.contacts, a.joint_reactions || b.joint_reactions,
          a.accelerations || b.accelerations, a.for_sensors || b.for_sensors};
}

Energy energy_of(const SceneModel& model, const WorldState& state) {
  Energy out;
  for_each_dynamic(model, state, [&](const Body& body, const Pose& X_WB, const Twist& V_WB) {
    const Vec3 to_com = X_WB.q * body.com;
    const Vec3 w_B = X_WB.q.conjugate() * V_WB.angular;
    out.kinetic +=
        0.5 * body.mass * V_WB.at(to_com).squaredNorm() + 0.5 * w_B.dot(body.inertia * w_B);
    out.potential -= body.gravity_scale * body.mass * model.physics.gravity.dot(X_WB.p + to_com);
  });
  assert(state.joint_positions.size() == static_cast<std::size_t>(model.joint_positions));
  for (const Joint& joint : model.joints) {
    if (joint.removed) continue;
    out.potential += spring_energy(joint, state.joint_positions.data() + joint.position_offset);
    out.kinetic += rotor_energy(joint, state.joint_velocities.data() + joint.speed_offset);
  }
  return out;
}

Momentum momentum_of(const SceneModel& model, const WorldState& state) {
  Momentum out;
  for_each_dynamic(model, state, [&](const Body& body, const Pose& X_WB, const Twist& V_WB) {
    const Vec3 to_com = X_WB.q * body.com;
    const Vec3 linear = body.mass * V_WB.at(to_com);
    const Vec3 spin = X_WB.q * (body.inertia * (X_WB.q.conjugate() * V_WB.angular));
    out.linear += linear;
    out.angular += spin + (X_WB.p + to_com).cross(linear);
  });
  return out;
}

std::uint64_t state_hash(const WorldState& state) {
  std::uint64_t hash = hash_bytes(nullptr, 0);
  for (const Pose& pose : state.poses) {
    hash = hash_numbers(pose.p.data(), 3, hash);
    hash = hash_numbers(pose.q.coeffs().data(), 4, hash);
  }
  for (const Twist& twist : state.twists) {
    hash = hash_numbers(twist.linear.data(), 3, hash);
    hash = hash_numbers(twist.angular.data(), 3, hash);
  }
  hash = hash_numbers(state.joint_positions.data(), state.joint_positions.size(), hash);
  return hash_numbers(state.joint_velocities.data(), state.joint_velocities.size(), hash);
}

}  // namespace cogrsim
