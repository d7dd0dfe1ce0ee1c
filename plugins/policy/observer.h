// The observations of a policy: terms with noise, clip, scale, delay and history.
#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "cogrsim/core/types.h"
#include "cogrsim/policy/card.h"
#include "memory.h"

namespace policy_plugin {

/// The robot as the sensors have it.
struct Measured {
  cogrsim::Pose base;
  cogrsim::Twist twist;  ///< of the base's origin, world axes
  std::vector<double> positions, velocities;
};

class Observer {
 public:
  /// `step` [s]: of measure(). `uniform` draws from [low, high).
  Observer(const cogrsim::PolicyCard& card, double step,
           std::function<double(double, double)> uniform);

  /// To be called in every step, also between decisions: delayed terms remember what was.
  void measure(const Measured& now);
  /// The network's input. `raw` and `clipped` are the last actions.
  std::vector<float> decide(const std::vector<double>& command, const std::vector<double>& raw,
                            const std::vector<double>& clipped);

  void save(MemoryWriter& memory) const;
  void restore(MemoryReader& memory);

 private:
  struct Term {
    std::deque<std::vector<double>> late;     // measured values, the newest last
    std::deque<std::vector<double>> history;  // as the network is given them, the oldest first
    double phase = 0.0;                       // in turns
  };
  std::vector<double> measured(const cogrsim::PolicyObservation& o, const Measured& now) const;
  std::vector<double> phase(const cogrsim::PolicyObservation& o, Term& term,
                            const std::vector<double>& command) const;
  std::size_t steps_late(const cogrsim::PolicyObservation& o) const;
  double noise(const cogrsim::PolicyObservation& o) const;

  const cogrsim::PolicyCard& card_;
  double step_;
  std::function<double(double, double)> uniform_;
  std::vector<Term> terms_;
};

}  // namespace policy_plugin
