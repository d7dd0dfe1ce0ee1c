// The observations of a policy: terms with noise, clip, scale, delay and history.
#pragma once

#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/types.h"
#include "cogrsim/policy/card.h"
#include "cogrsim/policy/memory_text.h"

namespace cogrsim {

/// The robot as the sensors have it.
struct PolicyMeasured {
  Pose base;
  Twist twist;  ///< of the base's origin, world axes
  std::vector<double> positions, velocities;
};

class COGRSIM_API PolicyObserver {
 public:
  /// `card` outlives it. `step` [s]: of measure(). `uniform` draws from [low, high).
  PolicyObserver(const PolicyCard& card, double step,
                 std::function<double(double, double)> uniform);

  /// To be called in every step, also between decisions: delayed terms remember what was.
  void measure(const PolicyMeasured& now);
  /// The network's input. `raw` and `clipped` are the last actions.
  std::vector<float> decide(const std::vector<double>& command, const std::vector<double>& raw,
                            const std::vector<double>& clipped);

  void save(PolicyMemoryWriter& memory) const;
  void restore(PolicyMemoryReader& memory);

 private:
  struct Term {
    std::deque<std::vector<double>> late;     // measured values, the newest last
    std::deque<std::vector<double>> history;  // as the network is given them, the oldest first
    double phase = 0.0;                       // in turns
  };
  std::vector<double> measured(const PolicyObservation& o, const PolicyMeasured& now) const;
  std::vector<double> phase(const PolicyObservation& o, Term& term,
                            const std::vector<double>& command) const;
  std::size_t steps_late(const PolicyObservation& o) const;
  double noise(const PolicyObservation& o) const;

  const PolicyCard& card_;
  double step_;
  std::function<double(double, double)> uniform_;
  std::vector<Term> terms_;
};

/// Which of a network's inputs and outputs are what the card says.
struct PolicyPorts {
  std::size_t observed = 0, acting = 0;  ///< input of the observations, output of the actions
  std::vector<std::pair<std::size_t, std::size_t>>
      feedback;  ///< inputs of the state, and the outputs that they have in the next decision
};

/// Precondition: check_policy_network() has no errors.
COGRSIM_API PolicyPorts policy_ports(const PolicyCard& card, const PolicyNetwork& network);

}  // namespace cogrsim
