// Frames for the commands that draw: out of a recording, or out of a scene run for the purpose.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/sensing/sensor.h"
#include "common/options.h"

namespace cogrsim::cli {

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Opens a recording or compiles a scene and builds its world. Errors are printed; nullptr
  /// then, and `status` is the exit status.
  static std::unique_ptr<FrameSource> open(const FrameSourceOptions& options, int& status);

  virtual std::string name() const = 0;     ///< of the scene
  virtual std::string backend() const = 0;  ///< that moved it
  virtual double end() const = 0;           ///< of the recording, or the scene's duration [s]
  /// The last frame at or before `time` [s]. Times must not decrease from call to call. Errors: the
  /// recording is damaged there, or the run ended before.
  virtual Result<FramePtr> at(double time) = 0;
  /// The channels of readings, by sensor index.
  virtual const std::vector<Channel>& channels(int sensor) const = 0;
  virtual PluginLoader& loader() = 0;
};

/// Whether the file is a recording, by its name.
bool is_recording(const std::string& path);

}  // namespace cogrsim::cli
