// The state of a run on file: to go on later, elsewhere, on another engine, or with something
// changed. What is carried over and what is not: docs/snapshots.md.
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

/// Version of the files that are written; older ones are read.
inline constexpr int kSnapshotVersion = 1;

struct SnapshotInfo {
  std::string scene;  ///< its name
  std::string backend, engine_version;
  std::uint64_t seed = 0;
  double time = 0.0;                              ///< [s]
  double step = 0.0;                              ///< [s]
  std::map<std::string, std::string> parameters;  ///< `--set` of the run it was taken from
  bool changed = false;  ///< things had come, gone or been changed since the start
};

/// Writes the present state of a run, whole or not at all; to be called between steps. `parameters`
/// are kept for the record. Errors: write_output_file()'s; a controller's save() throws.
COGRSIM_API Result<> write_snapshot(const Simulation& simulation, const std::string& path,
                                    const std::map<std::string, std::string>& parameters = {},
                                    const OutputRules& rules = {});

/// A snapshot, read and checked.
class COGRSIM_API SnapshotFile {
 public:
  /// Errors: not there, no snapshot, of a newer version, damaged or changed by hand.
  static Result<SnapshotFile> read(const std::string& path);

  const SnapshotInfo& info() const;

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<const Impl> impl_;
};

struct Resumed {
  std::unique_ptr<Simulation> simulation;  ///< at the snapshot's time
  /// In words what could not be carried over: elements that are new or missing, controllers without
  /// save(), and the like.
  std::vector<std::string> notes;
  bool same_scene = false;  ///< the scene is the one of then, and so is the backend
};

/// A simulation of `scene` that goes on from the snapshot. The scene may differ from that of then,
/// in parameters or by editing, and so may backend, step and seed: state is carried over by the
/// names of bodies, joints, motors, sensors and minds. Errors: as Simulation::create; another scene
/// by name; a state that the engine refuses.
COGRSIM_API tl::expected<Resumed, std::vector<Diagnostic>> resume(
    const SnapshotFile& snapshot, SceneModelPtr scene, const SimulationOptions& options,
    std::shared_ptr<PluginLoader> loader);

}  // namespace cogrsim
