// Repeated comparisons of one scene: mean, scatter and confidence of the differences.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/lockstep.h"

namespace cogrsim::cli {

/// Of n numbers: the mean, the standard deviation of one (with n - 1), and the interval in which
/// the mean of infinitely many lies with a confidence of 95 %, by Student's t with n - 1 degrees of
/// freedom (Student, Biometrika 6, 1908). For n = 1 deviation and interval are empty.
struct Estimate {
  std::size_t count = 0;
  double mean = 0.0;
  std::optional<double> deviation;
  std::optional<double> half_width;  ///< the interval is mean ± this
};
Estimate estimate_of(const std::vector<double>& numbers);

/// One body of one run against the reference, over all repetitions.
struct StudyRow {
  std::string body;
  std::string run;         ///< RunEnd::label
  Estimate max, rms, end;  ///< distance [m]
  Estimate angle_end;      ///< [rad]
  Estimate diverges_at;    ///< first time over a threshold [s], of those repetitions where it was
  double severity = 0.0;   ///< mean of the worst in thresholds
};

struct StudyRun {
  std::string run;
  std::size_t completed = 0;
  Estimate energy_drift;  ///< [J]
  Estimate penetration;   ///< deepest [m]
};

struct CompareStudy {
  std::vector<std::uint64_t> seeds;  ///< of the repetitions that are in
  double shake = 0.0;                ///< [m, rad]; 0: none
  std::vector<StudyRow> rows;        ///< worst first
  std::vector<StudyRun> runs;
};

class CompareStatistics {
 public:
  explicit CompareStatistics(double shake) { study_.shake = shake; }
  void add(std::uint64_t seed, const LockstepResult& result);
  CompareStudy finish() const;

 private:
  struct Numbers {
    std::string body, run;
    std::vector<double> max, rms, end, angle_end, diverges_at, severity;
  };
  struct RunNumbers {
    std::size_t completed = 0;
    std::vector<double> energy_drift, penetration;
  };
  CompareStudy study_;
  std::vector<Numbers> numbers_;
  std::vector<RunNumbers> runs_;
};

}  // namespace cogrsim::cli
