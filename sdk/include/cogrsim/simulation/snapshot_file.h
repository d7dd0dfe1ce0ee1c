// Snapshot files: the state of a run in a file, from which the run can be continued later, on
// another machine, on another engine, or with a modified scene. docs/guide/snapshots.md lists what
// is transferred.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/core/result.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim {

/// Version of the file format that is written and read. 1: before CogRSim 0.2.
inline constexpr int kSnapshotVersion = 2;

/// Description of a snapshot file.
struct SnapshotInfo {
  std::string scene;  ///< name of the scene
  std::string backend, engine_version;
  std::uint64_t seed = 0;
  double time = 0.0;                              ///< simulated time [s]
  double step = 0.0;                              ///< time step [s]
  std::map<std::string, std::string> parameters;  ///< options `--set` of the run
  bool changed = false;  ///< elements had been added, removed or changed since the start
};

/// Writes the current state of a run to a file, atomically. Call it between steps. `parameters` are
/// stored as information only. Errors: those of write_output_file(), or save() of a controller
/// throws.
COGRSIM_API Result<> write_snapshot(const Simulation& simulation, const std::string& path,
                                    const std::map<std::string, std::string>& parameters = {},
                                    const OutputRules& rules = {});

/// The checked contents of a snapshot file; immutable and thread-safe.
class COGRSIM_API SnapshotFile {
 public:
  /// Reads and checks a file. Errors: the file does not exist, is not a snapshot, has a newer
  /// version, is damaged, or was edited.
  static Result<SnapshotFile> read(const std::string& path);

  const SnapshotInfo& info() const;

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<const Impl> impl_;
};

/// Result of resume().
struct Resumed {
  std::unique_ptr<Simulation> simulation;  ///< at the time of the snapshot
  /// Descriptions of what could not be transferred: new or missing elements, controllers without
  /// save(), and similar.
  std::vector<std::string> notes;
  bool same_scene = false;  ///< scene and backend are those of the snapshot
};

/// Creates a simulation of `scene` that continues from the snapshot. The scene may have been edited
/// or compiled with other parameters, and backend, step and seed may differ: the state is
/// transferred by the names of bodies, joints, motors, sensors and controllers. Errors: as
/// Simulation::create(), a scene with another name, or a state that the engine rejects.
COGRSIM_API tl::expected<Resumed, std::vector<Diagnostic>> resume(
    const SnapshotFile& snapshot, SceneModelPtr scene, const SimulationOptions& options,
    std::shared_ptr<PluginLoader> loader);

}  // namespace cogrsim
