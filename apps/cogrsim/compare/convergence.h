// How a backend's own answer changes with smaller steps, and the order with which it does.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/physics/frame.h"

namespace cogrsim::cli {

/// Positions [m] of the bodies that can move, at instants that runs of different steps share.
class Trajectory {
 public:
  void add(const Frame& frame);
  std::size_t size() const { return instants_.size(); }

  /// Root mean square over instants and bodies of the distance between bodies of one name [m];
  /// empty when there is nothing in common.
  static std::optional<double> distance(const Trajectory& a, const Trajectory& b);

 private:
  std::vector<std::map<std::string, Vec3>> instants_;
};

/// One backend, or one pair of backends, at one step.
struct ConvergencePoint {
  double step = 0.0;  ///< [s]
  /// Of a backend: from its own run at the next smaller step; of a pair: between the two [m].
  std::optional<double> difference;
  /// Observed order; empty where there are not enough steps, or nothing converges.
  std::optional<double> order;
};

struct ConvergenceSeries {
  std::string name;  ///< "bullet" or "bullet and cogrsim"
  bool between = false;
  std::vector<ConvergencePoint> points;  ///< largest step first
};

/// The order p for which differences d12 between steps h1 > h2 and d23 between h2 > h3 behave as
/// C h^p: (h1^p - h2^p) / (h2^p - h3^p) = d12 / d23. For halved steps that is log2(d12 / d23), as
/// Richardson has it. Empty: the differences do not shrink, or are zero.
std::optional<double> observed_order(double h1, double h2, double h3, double d12, double d23);

/// `steps` [s], largest first; `runs[i]` the trajectories of all backends at steps[i].
std::vector<ConvergenceSeries> convergence(const std::vector<std::string>& backends,
                                           const std::vector<double>& steps,
                                           const std::vector<std::vector<Trajectory>>& runs);

}  // namespace cogrsim::cli
