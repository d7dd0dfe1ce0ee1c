// What is measured beside the table of engines and scenes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "measure.h"

namespace cogrsim::bench {

/// Error against cost of one engine with one step size on the tumbling box.
struct PrecisionPoint {
  std::string engine;
  double dt = 0;             ///< [s]
  double cost = 0;           ///< [us] for a simulated second
  double error = 0;          ///< of the orientation after kPrecisionTime [rad]
  std::string missing = {};  ///< why there are no figures
};
inline constexpr double kPrecisionTime = 4.096;  ///< [s]
std::vector<PrecisionPoint> measure_precision(const std::vector<Engine>& engines, bool quick,
                                              const Progress& progress);

/// Time that a scene file of so many bodies takes to compile.
struct CompilePoint {
  int bodies = 0;
  double bytes = 0;
  Spread time;  ///< [us]
};
std::vector<CompilePoint> measure_compiling(const std::string& folder, bool quick,
                                            const Progress& progress);

/// Calls of the allocator in a step of ours, after warm-up.
struct AllocationRow {
  std::string engine, scene, layer;
  double ours = 0, engines = 0;  ///< per step
  nlohmann::json sites = {};     ///< of ours, most frequent first
  std::string missing = {};
};
std::vector<AllocationRow> count_allocations(const std::vector<Engine>& engines,
                                             const std::vector<std::string>& scenes, bool quick,
                                             const Progress& progress);

/// The programs on rays and pictures; what they print as JSON, or null with the reason in `missing`.
nlohmann::json measure_apart(const std::string& program, const std::vector<std::string>& options,
                             const std::string& package, double limit, std::string& missing);

}  // namespace cogrsim::bench
