// Conversion of the frames of a run to messages of an MCAP file, without threads and queues.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/recording/recording.h"
#include "recording/mcap/mcap_writer.h"
#include "recording/mcap/messages.h"

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

  /// Sets the model of the following frames.
  void model(const SceneModelPtr& model, const SensorChannels& channels, double time);
  /// Writes the new readings and events of a frame, and the frame itself if `keep` is set. `number`
  /// is the number of the frame among those to be recorded; dropped frames leave gaps.
  void frame(const Frame& frame, bool keep, std::uint64_t number);
  void message(const RunMessage& message);

  /// Size of the data in memory [byte].
  std::size_t pending() const { return mcap_.pending(); }
  Result<> flush() { return mcap_.flush(); }
  /// Writes the data in memory. Errors: those of the disk.
  Result<> finish(const std::map<std::string, std::string>& end);

  /// Number of frames in the file, without those in memory.
  std::uint64_t frames_on_file() const { return mcap_.messages_on_file(frame_topic_); }

 private:
  struct SensorTopics {
    std::string name;
    std::uint16_t reading = 0, color = 0, depth = 0, segmentation = 0, scan = 0;
    bool named = true;
    std::string channels;  // as JSON, to detect a change
    std::uint64_t readings = 0, colors = 0, depths = 0, segmentations = 0;
    // The last written data, to detect new ones.
    std::uint64_t sequence = 0;
    double time = 0.0;
    bool valid = false, enabled = true, any = false;
    const Picture* picture = nullptr;
    std::shared_ptr<const Picture> kept_picture;
    PictureLocations locations;
  };

  std::uint16_t topic(std::string name, std::uint16_t schema,
                      std::map<std::string, std::string> metadata = {});
  void sensor_topics(std::size_t index, const SensorModel& sensor,
                     const std::vector<Channel>& channels);
  std::uint16_t image_topic(std::size_t index, const SensorModel& sensor, const char* part,
                            std::uint16_t schema);
  void reading(std::size_t index, const Reading& reading, double time);
  PictureLocations picture(std::size_t index, const Picture& picture, std::uint64_t time);

  mcap::Writer mcap_;
  RecorderOptions options_;
  FrameEncoder encoder_;
  std::uint16_t frame_topic_ = 0, model_topic_ = 0, event_topic_ = 0, log_topic_ = 0,
                transform_topic_ = 0, scene_topic_ = 0;
  std::uint16_t raw_image_ = 0, compressed_image_ = 0, laser_scan_ = 0;
  std::map<std::string, std::pair<std::uint16_t, bool>> reading_schemas_;
  std::map<std::string, int> schema_names_;
  std::vector<SensorTopics> sensors_;
  std::vector<std::uint64_t> reading_counts_;
  SceneModelPtr model_;
  std::uint32_t models_ = 0;
  std::uint64_t events_ = 0;
  std::uint32_t logs_ = 0, transforms_ = 0, scenes_ = 0;
  double next_transform_ = 0.0, last_time_ = 0.0;
};

/// Simulated time in the unit of MCAP [ns].
std::uint64_t nanoseconds(double time);

}  // namespace cogrsim
