// Recorded runs as messages of ROS 2, for its own tools: docs/guide/recording.md lists the topics.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/output_file.h"
#include "cogrsim/physics/frame.h"

namespace cogrsim {

/// Writes frames into an MCAP file with messages of ROS 2: encoding `cdr`, schemas `ros2msg`. Frames
/// come in the order of time.
class COGRSIM_API Ros2Writer {
 public:
  /// Starts a file beside `path`, which it replaces in finish(). Errors: those of check_output(), or
  /// of the operating system.
  static Result<std::unique_ptr<Ros2Writer>> create(const std::string& path,
                                                    const OutputRules& rules);
  ~Ros2Writer();  ///< without finish(): nothing is left

  /// The transforms, joints and clock of a frame, and the readings that are new in it. Errors: those
  /// of the disk.
  Result<> add(const Frame& frame);

  /// What was written, and what has no form in ROS.
  struct Summary {
    std::map<std::string, std::uint64_t> messages;  ///< by topic
    std::vector<std::string> left_out;              ///< sensors with their types, joints
  };
  /// Writes the end, and replaces the file. Errors: those of the disk.
  Result<Summary> finish();

 private:
  struct Impl;
  explicit Ros2Writer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim
