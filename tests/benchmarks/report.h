// What was measured: for the terminal, as JSON, and as docs/dev/benchmarks.md with pictures.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "measure.h"
#include "studies.h"

namespace cogrsim::bench {

/// Where and when a run was made.
struct Machine {
  std::string cpu, system, compiler, date, commit;
  int cores = 0;
  double memory = 0;  ///< [byte]
};
Machine this_machine(const std::string& repository);

struct Results {
  Machine machine;
  bool quick = false;
  std::vector<Row> table;  ///< engines and scenes
  std::vector<Row> growth_boxes, growth_robots;
  std::vector<PrecisionPoint> precision;
  std::vector<CompilePoint> compiling;
  std::vector<AllocationRow> allocations;
  nlohmann::json rays, cameras;  ///< as their programs print them; null
  std::string rays_missing, cameras_missing;
};

/// An aim of the project and what became of it.
struct Claim {
  std::string what, measured;
  enum { reached, missed, unknown } state = unknown;
};
std::vector<Claim> claims_of(const Results& results);

/// How the cost of a step grows with the number: the slope of log time over log number, between the
/// last points from `from` on; NaN when there are fewer than two.
double growth_exponent(const std::vector<Row>& rows, const std::string& engine, int from);

/// One scene of the table.
void print_scene(const std::vector<Row>& rows);
void print_rest(const Results& results);
void print_allocations(const std::vector<AllocationRow>& rows, int sites);

/// One object per engine and scene; docs/dev/benchmarks.md says what the keys mean.
nlohmann::json to_json(const Results& results);

/// Writes the page, and the pictures into `pictures`. Throws std::runtime_error.
void write_markdown(const Results& results, const std::string& path, const std::string& pictures);

}  // namespace cogrsim::bench
