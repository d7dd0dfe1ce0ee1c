// Writes the messages of a run into an MCAP file, without threads and queues.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "cogrsim/recording/recording.h"
#include "recording/mcap/mcap_writer.h"
#include "recording/run_encoder.h"

namespace cogrsim {

/// Version of the topics and schemas; see docs/guide/recording.md.
inline constexpr int kFormatVersion = 1;

/// Names of metadata records.
inline constexpr const char* kRunMetadata = "cogrsim.run";
inline constexpr const char* kParameterMetadata = "cogrsim.parameters";
inline constexpr const char* kModelMetadata = "cogrsim.model";  ///< followed by " N"
inline constexpr const char* kEndMetadata = "cogrsim.end";

class RunWriter {
 public:
  RunWriter(std::unique_ptr<mcap::Sink> sink, const RecorderOptions& options);

  /// Writes header, metadata and attachments. Errors: those of the disk.
  Result<> start(const std::map<std::string, std::string>& about);
  /// Errors: those of the disk.
  Result<> attach(const Attachment& file) {
    return mcap_.attachment(file.name, file.media_type, file.data, 0);
  }
  /// Attaches the textures of the materials of `model` that can be read and are not too large.
  Result<> attach_textures(const SceneModel& model);

  /// As those of the encoder.
  void model(const SceneModelPtr& model, const SensorChannels& channels, double time);
  void frame(const Frame& frame, bool keep, std::uint64_t number) {
    encoder_.frame(frame, keep, number);
  }
  void message(const RunMessage& message) { encoder_.message(message); }

  /// Size of the data in memory [byte].
  std::size_t pending() const { return mcap_.pending(); }
  Result<> flush() { return mcap_.flush(); }
  /// Writes the data in memory. Errors: those of the disk.
  Result<> finish(const std::map<std::string, std::string>& end);

  /// Number of frames in the file, without those in memory.
  std::uint64_t frames_on_file() const { return mcap_.messages_on_file(encoder_.frame_topic()); }

 private:
  mcap::Writer mcap_;
  RunEncoder encoder_;
  RecorderOptions options_;
};

}  // namespace cogrsim
