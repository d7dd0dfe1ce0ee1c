#include "compare/convergence.h"

#include <algorithm>
#include <cmath>

namespace cogrsim::cli {

void Trajectory::add(const Frame& frame) {
  std::map<std::string, Vec3> instant;
  for (std::size_t i = 0; i < frame.model->bodies.size(); ++i) {
    const Body& body = frame.model->bodies[i];
    if (!body.removed && body.kind != BodyKind::static_body)
      instant[body.name] = frame.state.poses[i].p;
  }
  instants_.push_back(std::move(instant));
}

std::optional<double> Trajectory::distance(const Trajectory& a, const Trajectory& b) {
  double sum = 0.0;
  std::size_t count = 0;
  const std::size_t shared = std::min(a.size(), b.size());
  for (std::size_t i = 0; i < shared; ++i) {
    for (const auto& [name, position] : a.instants_[i]) {
      const auto other = b.instants_[i].find(name);
      if (other == b.instants_[i].end()) continue;
      sum += (position - other->second).squaredNorm();
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(count));
}

std::optional<double> observed_order(double h1, double h2, double h3, double d12, double d23) {
  if (!(d12 > 0.0) || !(d23 > 0.0)) return std::nullopt;
  const double wanted = d12 / d23;
  const auto ratio = [&](double p) {
    return (std::pow(h1, p) - std::pow(h2, p)) / (std::pow(h2, p) - std::pow(h3, p));
  };
  // The ratio grows with p; no integrator has an order beyond ten.
  double low = 1e-3, high = 10.0;
  if (wanted < ratio(low) || wanted > ratio(high)) return std::nullopt;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (ratio(middle) < wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

std::vector<ConvergenceSeries> convergence(const std::vector<std::string>& backends,
                                           const std::vector<double>& steps,
                                           const std::vector<std::vector<Trajectory>>& runs) {
  std::vector<ConvergenceSeries> out;
  for (std::size_t b = 0; b < backends.size(); ++b) {
    ConvergenceSeries series{backends[b], false, {}};
    for (std::size_t i = 0; i < steps.size(); ++i) {
      ConvergencePoint point{steps[i], std::nullopt, std::nullopt};
      if (i + 1 < steps.size()) point.difference = Trajectory::distance(runs[i][b], runs[i + 1][b]);
      series.points.push_back(point);
    }
    for (std::size_t i = 0; i + 2 < steps.size(); ++i) {
      const auto &d12 = series.points[i].difference, &d23 = series.points[i + 1].difference;
      if (d12 && d23) {
        series.points[i].order = observed_order(steps[i], steps[i + 1], steps[i + 2], *d12, *d23);
      }
    }
    out.push_back(std::move(series));
  }
  for (std::size_t b = 1; b < backends.size(); ++b) {
    ConvergenceSeries series{backends[0] + " and " + backends[b], true, {}};
    for (std::size_t i = 0; i < steps.size(); ++i) {
      series.points.push_back(
          {steps[i], Trajectory::distance(runs[i][0], runs[i][b]), std::nullopt});
    }
    for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
      const auto &coarse = series.points[i].difference, &fine = series.points[i + 1].difference;
      if (!coarse || !fine || *coarse <= *fine || *fine <= 0.0) continue;
      series.points[i].order = std::log(*coarse / *fine) / std::log(steps[i] / steps[i + 1]);
    }
    out.push_back(std::move(series));
  }
  return out;
}

}  // namespace cogrsim::cli
