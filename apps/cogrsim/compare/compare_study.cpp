#include "compare/compare_study.h"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/students_t.hpp>

namespace cogrsim::cli {

Estimate estimate_of(const std::vector<double>& numbers) {
  Estimate out;
  out.count = numbers.size();
  if (numbers.empty()) return out;
  const double n = static_cast<double>(numbers.size());
  for (const double x : numbers) out.mean += x / n;
  if (numbers.size() < 2) return out;
  double squares = 0.0;
  for (const double x : numbers) squares += (x - out.mean) * (x - out.mean);
  out.deviation = std::sqrt(squares / (n - 1.0));
  const boost::math::students_t student(n - 1.0);
  out.half_width = boost::math::quantile(student, 0.975) * *out.deviation / std::sqrt(n);
  return out;
}

void CompareStatistics::add(std::uint64_t seed, const LockstepResult& result) {
  const CompareResult& comparison = result.comparison;
  study_.seeds.push_back(seed);
  if (study_.runs.empty()) {
    for (const RunEnd& run : result.runs) study_.runs.push_back({run.label, 0, {}, {}});
    runs_.resize(result.runs.size());
  }
  for (std::size_t i = 0; i < result.runs.size(); ++i) {
    const RunFigures& figures = comparison.figures[i];
    if (result.runs[i].status == RunStatus::completed) ++runs_[i].completed;
    runs_[i].energy_drift.push_back(figures.energy.end - figures.energy.start);
    runs_[i].penetration.push_back(figures.penetration.value);
  }
  for (const Difference& difference : comparison.bodies) {
    if (!difference.distance) continue;
    const std::string& run = comparison.runs[difference.run];
    auto found = std::find_if(numbers_.begin(), numbers_.end(), [&](const Numbers& one) {
      return one.body == difference.name && one.run == run;
    });
    if (found == numbers_.end()) {
      numbers_.push_back({});
      found = std::prev(numbers_.end());
      found->body = difference.name;
      found->run = run;
    }
    found->max.push_back(difference.distance->max);
    found->rms.push_back(difference.distance->rms);
    found->end.push_back(difference.distance->end);
    if (difference.angle) found->angle_end.push_back(difference.angle->end);
    if (difference.first_over) found->diverges_at.push_back(*difference.first_over);
    found->severity.push_back(difference.severity);
  }
}

CompareStudy CompareStatistics::finish() const {
  CompareStudy out = study_;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    out.runs[i].completed = runs_[i].completed;
    out.runs[i].energy_drift = estimate_of(runs_[i].energy_drift);
    out.runs[i].penetration = estimate_of(runs_[i].penetration);
  }
  for (const Numbers& one : numbers_) {
    StudyRow row;
    row.body = one.body;
    row.run = one.run;
    row.max = estimate_of(one.max);
    row.rms = estimate_of(one.rms);
    row.end = estimate_of(one.end);
    row.angle_end = estimate_of(one.angle_end);
    row.diverges_at = estimate_of(one.diverges_at);
    row.severity = estimate_of(one.severity).mean;
    out.rows.push_back(std::move(row));
  }
  std::stable_sort(out.rows.begin(), out.rows.end(),
                   [](const StudyRow& a, const StudyRow& b) { return a.severity > b.severity; });
  return out;
}

}  // namespace cogrsim::cli
