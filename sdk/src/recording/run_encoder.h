// Conversion of the frames of a run to messages, without threads, queues and files.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/recording/run_stream.h"
#include "cogrsim/simulation/simulation.h"
#include "recording/mcap/messages.h"

namespace cogrsim {

class RunEncoder {
 public:
  struct Options {
    bool contacts = true, images = true, jpeg = false;
  };
  RunEncoder(TopicSink& sink, const Options& options) : sink_(sink), options_(options) {}

  /// Adds the topics that every run has.
  void start();
  /// Sets the model of the following frames.
  void model(const SceneModelPtr& model, const SensorChannels& channels, double time);
  /// Gives the new readings and events of a frame, and the frame itself if `keep` is set. `number`
  /// is the number of the frame among those to be recorded; dropped frames leave gaps.
  void frame(const Frame& frame, bool keep, std::uint64_t number);
  void message(const RunMessage& message);
  /// The frame that was given last, once more, with its transforms.
  void again(const Frame& frame, std::uint64_t number);

  std::uint16_t frame_topic() const { return frame_topic_; }
  std::uint32_t models() const { return models_; }

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
  void put_frame(const Frame& frame, std::uint64_t number);
  void put_tf(const Frame& frame);
  void reading(std::size_t index, const Reading& reading, double time);
  PictureLocations picture(std::size_t index, const Picture& picture, std::uint64_t time);

  TopicSink& sink_;
  Options options_;
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
