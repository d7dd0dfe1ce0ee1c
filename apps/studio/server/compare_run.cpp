#include "compare_run.h"

#include <cmath>
#include <map>

#include <fmt/format.h>

#include "compare/compare.h"

namespace cogrsim::studio {

namespace {

/// Two clocks count as equal up to this fraction of a tick.
constexpr double kSameTick = 1e-9;
constexpr int kMostSteps = 1000;

bool can_move(const Body& body) { return !body.removed && body.kind != BodyKind::static_body; }

}  // namespace

bool steps_meet(double a, double b) {
  const double small = std::min(a, b), large = std::max(a, b);
  // p large steps take as long as q small ones.
  for (int p = 1; p <= kMostSteps; ++p) {
    const double q = p * large / small;
    if (q > kMostSteps) return false;
    if (std::fabs(q - std::round(q)) <= kSameTick * q) return true;
  }
  return false;
}

std::optional<DivergenceDetector::Found> DivergenceDetector::look(const Frame& first,
                                                                  const Frame& second) {
  if (found_) return std::nullopt;
  if (models_[0] != first.model || models_[1] != second.model) {
    models_[0] = first.model;
    models_[1] = second.model;
    pairs_.clear();
    std::map<std::string, std::size_t> there;
    for (std::size_t i = 0; i < second.model->bodies.size(); ++i) {
      if (can_move(second.model->bodies[i])) there[second.model->bodies[i].name] = i;
    }
    for (std::size_t i = 0; i < first.model->bodies.size(); ++i) {
      const auto same = there.find(first.model->bodies[i].name);
      if (can_move(first.model->bodies[i]) && same != there.end()) {
        pairs_.emplace_back(i, same->second);
      }
    }
  }
  const cli::CompareOptions limits;
  Found worst;
  double excess = 1.0;
  for (const auto& [i, j] : pairs_) {
    const Pose &a = first.state.poses[i], &b = second.state.poses[j];
    const double distance = (a.p - b.p).norm(), angle = cli::angle_between(a.q, b.q);
    const double much =
        std::max(distance / limits.position_threshold, angle / limits.angle_threshold);
    if (!(much > excess)) continue;
    excess = much;
    worst = {first.time, first.model->bodies[i].name, distance, angle};
  }
  if (excess <= 1.0) return std::nullopt;
  found_ = true;
  return worst;
}

std::array<std::string, 2> labels_of(const Simulation& first, const Simulation& second) {
  std::string a = first.backend().name(), b = second.backend().name();
  if (first.dt() != second.dt()) {
    a += fmt::format(", {:.6g} ms", 1e3 * first.dt());
    b += fmt::format(", {:.6g} ms", 1e3 * second.dt());
  }
  if (a == b) b += " (2)";
  return {a, b};
}

}  // namespace cogrsim::studio
