// A parameter study: its runs, and its definition, which distinguishes it from other studies.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/dsl/study.h"
#include "common/json_text.h"
#include "common/options.h"

namespace cogrsim::cli {

/// More runs than this are refused.
inline constexpr std::size_t kMostRuns = 1000000;

/// A part of a study that is run by itself: of each `of` runs in a row the one of this number.
struct Shard {
  std::size_t number = 1, of = 0;  ///< of 0: the whole study
  std::string text() const;
};

/// The options of a study: from a study file, or from the command line.
struct SweepOptions {
  SceneOptions scene;  ///< `duration`: --until
  std::vector<dsl::Study::Variation> variations;
  std::vector<std::uint64_t> seeds;   ///< empty: the scene's
  std::vector<std::string> backends;  ///< empty: the scene's
  std::vector<dsl::Study::Measure> measures;
  double step = 0.0;  ///< [s]; 0: the scene's
  std::string output;
  int jobs = 0;                    ///< 0: one per core; with MPI: one per rank
  double timeout = 0.0;            ///< of one run, in wall-clock time [s]; 0: none
  std::uint64_t memory_limit = 0;  ///< of one run [byte]; 0: none
  Shard shard;
  std::vector<std::string> merged;  ///< tables of shards, which become one; nothing is run then
  bool dry_run = false;
  bool retry = false;  ///< runs that crashed, failed or ran out of something once more
};

/// One run of a study.
struct SweepCase {
  std::vector<std::size_t> values;  ///< by variation: which of its values
  std::uint64_t seed = 0;
  std::string backend;
};

struct SweepPlan {
  SweepOptions options;  ///< with seeds, backends and settings filled in
  std::string scene_name;
  std::vector<std::string> scene_measures;  ///< names of the scene's own
  std::uint64_t scene_hash = 0;             ///< of all files that make the scene
  std::vector<SweepCase> cases;
  std::uint64_t cases_hash = 0;  ///< of the cases of all shards; 0: of a whole study
  bool policy = false;  ///< the scene is a policy card, and the parameters are PolicySettings

  /// "r=3 cm, seed 7, bullet": for people, and unique within the study.
  std::string title(const SweepCase& one) const;
  /// The same for programs: values in SI units, so that 3 cm and 30 mm are one.
  std::string key(const SweepCase& one) const;
  /// The input of the child process.
  Json input(const SweepCase& one) const;
  /// All that must be the same for two sweeps to be about the same thing; of cases nothing.
  Json definition() const;
};

/// Compiles the scene for the first run and checks the options before anything runs.
/// Errors are printed; nullopt then.
std::optional<SweepPlan> make_plan(SweepOptions options);

/// All cases of the options' values, seeds and backends. False: there are more than kMostRuns.
bool add_cases(SweepPlan& plan);
/// Of the scene's files, meshes and height grids.
std::uint64_t hash_of_scene(const SceneModel& model);

/// The differences of `now` from `then`, as text; empty: none.
std::vector<std::string> definition_differences(const Json& then, const Json& now);

}  // namespace cogrsim::cli
