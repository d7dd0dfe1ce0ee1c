// Runs one scene on several backends side by side, and compares after each step.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/plugin/loader.h"
#include "cogrsim/simulation/simulation.h"
#include "compare/compare.h"
#include "compare/convergence.h"
#include "render/trails.h"

namespace cogrsim::cli {

struct LockstepOptions {
  std::vector<std::string> backends;  ///< at least two; the first is the reference
  double step = 0.0;                  ///< [s]; 0: the scene's
  double duration = 10.0;             ///< [s]
  std::optional<std::uint64_t> seed;
  std::vector<std::string> without;  ///< see SimulationOptions
  double shake = 0.0;            ///< of the start, see shake(); 0: none [m, rad]
  std::uint64_t shake_seed = 0;  ///< of that
  /// One more run, the last: the reference's backend once more, its start shaken by this beyond
  /// what all are; 0: none [m, rad].
  double twin = 0.0;
  CompareOptions compare;
  /// Keeps the bodies' positions after every so many steps; 0: keeps none.
  std::uint64_t trajectory_every = 0;
  /// Keeps the frames that pictures need: where runs diverge, the last ones, and the robots' paths.
  bool keep_frames = false;
  std::function<void(double time)> on_step;  ///< may be empty
  std::function<bool()> interrupted;         ///< may be empty
};

/// How one backend's run ended.
struct RunEnd {
  std::string label;  ///< the backend as it was asked for, with its options; "bullet (2)" when one
                      ///< is asked for twice; "bullet, shaken by 1 nm" of a twin
  std::string backend;
  std::string engine_version;
  Provenance provenance;
  RunStatus status = RunStatus::running;
  double step = 0.0;  ///< [s]
  std::uint64_t steps = 0;
  double time = 0.0;       ///< [s]
  double wall_time = 0.0;  ///< spent in this backend's own steps [s]
  std::uint64_t hash = 0;  ///< state_hash at the end
  std::vector<RunMessage> messages;
};

struct LockstepResult {
  CompareResult comparison;
  std::vector<RunEnd> runs;
  std::vector<Trajectory> trajectories;       ///< one per run, when asked for
  std::vector<FramePtr> divergence;           ///< when the first threshold was passed; empty: never
  std::vector<FramePtr> last;                 ///< one per run, when frames were to be kept
  std::vector<std::vector<MapTrail>> trails;  ///< per run
  std::string ended_early;  ///< why not all the duration was compared; empty: it was
  bool failed = false;      ///< a run diverged or ended by a fault
};

/// Takes every backend one step, then compares; wall time is counted around the steps alone. Ends
/// for all when one ends. Errors: what Simulation::create found, with a note that names the
/// backend; nothing that could be shaken.
tl::expected<LockstepResult, std::vector<Diagnostic>> run_lockstep(
    const SceneModelPtr& scene, const LockstepOptions& options,
    const std::shared_ptr<PluginLoader>& loader);

}  // namespace cogrsim::cli
