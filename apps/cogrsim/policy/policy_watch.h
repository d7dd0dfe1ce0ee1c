// Watches a robot that a policy drives: whether it stands, how it walks, and what that costs.
#pragma once

#include <optional>
#include <vector>

#include "cogrsim/simulation/simulation.h"
#include "policy/policy_scene.h"

namespace cogrsim::cli {

/// Mean velocities count from here on [s]: before, the robot starts to walk.
inline constexpr double kSettled = 2.0;

/// How a robot did in a run. What is empty was not measured: the engine does not report it, or the robot
/// fell before.
struct PolicyResult {
  double time = 0.0;           ///< at the end [s]
  std::optional<double> fell;  ///< [s]
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();
  double heading = 0.0;  ///< turned since the start [rad]
  double path = 0.0;     ///< length of the way [m]
  /// Mean, forward, to the left [m/s] and turning [rad/s].
  Vec3 velocity = Vec3::Zero();
  std::optional<double> limited;  ///< share of time of the motors at their limits of effort
  /// That of the mean velocity from a command of three numbers: [m/s], [rad/s].
  std::optional<double> velocity_error, turning_error;
  std::optional<double> slip;  ///< mean speed along the ground of what touches it, by load [m/s]
  std::optional<double> mean_force, peak_force;  ///< on all that touches the ground together [N]
  std::optional<double> cost;  ///< of transport: motors' positive power over weight times speed
};

class PolicyWatch {
 public:
  PolicyWatch(const PolicyScene& scene, const Simulation& simulation, std::vector<double> command);
  /// What see() needs.
  static FrameContents contents() { return {.contacts = true}; }

  /// To be called with the first frame and after every step. True: the robot has just fallen.
  bool see(const Frame& frame);
  /// After the last.
  PolicyResult finish();

 private:
  void efforts(const Frame& frame, double dt);
  void contacts(const Frame& frame, double dt);

  const PolicyScene& scene_;
  std::vector<double> command_;
  bool has_forces_, has_efforts_;  // which the engine reports
  std::vector<bool> robot_;  // by body
  double mass_ = 0.0;
  PolicyResult result_;
  bool seen_ = false;
  double heading_ = 0.0, time_ = 0.0, settled_ = 0.0, samples_ = 0.0, at_limit_ = 0.0;
  double work_ = 0.0, impulse_ = 0.0, slid_ = 0.0, touched_ = 0.0, peak_ = 0.0;
  Vec3 last_ = Vec3::Zero(), sum_ = Vec3::Zero();
};

}  // namespace cogrsim::cli
