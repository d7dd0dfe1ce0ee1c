// A second run beside the first: another engine, or another step.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/simulation/simulation.h"
#include "run_status.h"

namespace cogrsim::studio {

struct CompareRequest {
  std::optional<std::string> backend;  ///< empty: the same
  std::optional<double> step;          ///< [s]; empty: the same
};

/// Whether multiples of the two meet at least every so many steps: only there can two runs be
/// compared.
bool steps_meet(double a, double b);

/// Detects the first time at which two runs diverge: a body by more than 1 cm or 1 degree.
class DivergenceDetector {
 public:
  struct Found {
    double time = 0.0;  ///< [s]
    std::string body;
    double distance = 0.0, angle = 0.0;  ///< [m], [rad]
  };
  /// The divergence, once: when these frames are the first that differ by so much.
  std::optional<Found> look(const Frame& first, const Frame& second);

 private:
  SceneModelPtr models_[2];  ///< for which pairs_ hold
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
  bool found_ = false;
};

/// The simulation of the second run, and its labels.
struct SecondRun {
  CompareRequest request;
  std::unique_ptr<Simulation> simulation;
  std::array<std::string, 2> labels;
  DivergenceDetector divergence;
  std::optional<double> first_over;  ///< [s]
};

/// "bullet" and "cogrsim"; "bullet 1 ms" and "bullet 0.5 ms"; …
std::array<std::string, 2> labels_of(const Simulation& first, const Simulation& second);

}  // namespace cogrsim::studio
