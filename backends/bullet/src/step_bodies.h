// What the bodies of a step move by while it is being solved, in one piece of memory.
#pragma once

#include <vector>

#include <BulletDynamics/Dynamics/btRigidBody.h>

namespace cogrsim::bullet {

/// Two figures that are worked on at once, an extension of GCC and Clang. Every processor that runs
/// 64-bit code has such registers.
using Pair = double __attribute__((vector_size(16)));

/// Six figures, linear and angular, of a body: a velocity or a row of J on it; world axes.
struct Six {
  Pair p[3] = {};

  Six() = default;
  Six(const btVector3& lin, const btVector3& ang)
      : p{{lin.x(), lin.y()}, {lin.z(), ang.x()}, {ang.y(), ang.z()}} {}
  btVector3 lin() const { return {p[0][0], p[0][1], p[1][0]}; }
  btVector3 ang() const { return {p[1][1], p[2][0], p[2][1]}; }
};

inline Six& operator+=(Six& x, const Six& y) {
  for (int i = 0; i < 3; ++i) x.p[i] += y.p[i];
  return x;
}
inline Six operator+(Six x, const Six& y) { return x += y; }
inline Six operator-(Six x, const Six& y) {
  for (int i = 0; i < 3; ++i) x.p[i] -= y.p[i];
  return x;
}
/// x += y factor.
inline void add_scaled(Six& x, const Six& y, double factor) {
  for (int i = 0; i < 3; ++i) x.p[i] += y.p[i] * factor;
}

/// Sum of products, not yet of the two lanes.
inline Pair product(const Six& x, const Six& y) {
  return x.p[0] * y.p[0] + (x.p[1] * y.p[1] + x.p[2] * y.p[2]);
}
inline double sum(const Pair& x) { return x[0] + x[1]; }

/// Change of a body's velocity by impulses; a cache line of its own.
struct alignas(64) DeltaVelocity : Six {
  using Six::Six;
};

/// The bodies that may move, dynamic and kinematic, in the order in which the step was given them.
class StepBodies {
 public:
  struct Entry {
    btRigidBody* body = nullptr;
    btVector3 start_lin, gained_lin;  ///< velocity at the start, and what outer forces add to it
    btVector3 lin, ang;               ///< velocity with outer forces, without impulses
    double inverse_mass = 0.0;
    bool held = false;  ///< by joints
  };

  /// Takes over their velocities and outer forces. Tells each its index (btCollisionObject's
  /// companion id); what is not among them must have -1 there.
  void begin(const std::vector<btCollisionObject*>& moving, double dt) {
    entries_.resize(moving.size());
    deltas_.assign(moving.size(), DeltaVelocity{});
    for (std::size_t i = 0; i < moving.size(); ++i) {
      Entry& e = entries_[i];
      e.body = static_cast<btRigidBody*>(moving[i]);
      e.body->setCompanionId(static_cast<int>(i));
      e.inverse_mass = e.body->getInvMass();
      e.held = false;
      e.start_lin = e.body->getLinearVelocity();
      e.gained_lin = e.body->getTotalForce() * e.inverse_mass * dt;
      e.lin = e.start_lin + e.gained_lin;
      e.ang = e.body->getAngularVelocity();
    }
  }
  /// Gives the bodies the velocities found.
  void end() {
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      const Entry& e = entries_[i];
      if (e.inverse_mass == 0.0) continue;
      e.body->setLinearVelocity(e.start_lin + deltas_[i].lin() + e.gained_lin);
      e.body->setAngularVelocity(e.ang + deltas_[i].ang());
    }
  }

  /// Notes that joints act on the body.
  void hold(int index) { entries_[static_cast<std::size_t>(index)].held = true; }

  /// -1: does not move.
  static int index_of(const btCollisionObject& body) { return body.getCompanionId(); }
  std::size_t size() const { return entries_.size(); }
  const Entry& entry(int index) const { return entries_[static_cast<std::size_t>(index)]; }
  DeltaVelocity& delta(int index) { return deltas_[static_cast<std::size_t>(index)]; }
  const DeltaVelocity& delta(int index) const { return deltas_[static_cast<std::size_t>(index)]; }
  const std::vector<DeltaVelocity>& deltas() const { return deltas_; }
  DeltaVelocity* data() { return deltas_.data(); }

 private:
  std::vector<Entry> entries_;
  std::vector<DeltaVelocity> deltas_;
};

}  // namespace cogrsim::bullet
