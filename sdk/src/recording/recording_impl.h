// Implementation of Recording.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/recording/recording.h"
#include "recording/mcap/mcap_reader.h"
#include "recording/mcap/messages.h"

namespace cogrsim {

/// Temporary files with the textures in a recording whose original files do not exist any more;
/// they are removed with the object.
class TextureFolder {
 public:
  TextureFolder() = default;
  TextureFolder(const TextureFolder&) = delete;
  TextureFolder& operator=(const TextureFolder&) = delete;
  ~TextureFolder();
  /// Path of a file with this content. Errors: those of the operating system.
  Result<std::string> put(const std::string& name, const std::string& data);

 private:
  std::string folder_;
  std::map<std::string, std::string> files_;
};

using MessageLocations = std::vector<mcap::Reader::Location>;

/// The message with this sequence number, or nullptr if it is not in the file.
const mcap::Reader::Location* find_location(const MessageLocations& locations,
                                            std::uint64_t sequence);

struct Recording::Impl {
  using Locations = MessageLocations;

  struct SensorTopics {
    Locations readings, color, depth, segmentation;
    // The last decoded reading, which many frames share.
    std::uint64_t last = 0;
    Reading reading;
    std::shared_ptr<const Picture> picture;
    PictureLocations picture_locations;
  };

  std::unique_ptr<mcap::Reader> file;
  RecordingInfo info;
  bool every_step = false;
  bool contacts = true;
  Locations frames, models, events, logs;
  bool in_order = true;  ///< the times are ascending
  std::vector<SensorTopics> sensors;
  std::shared_ptr<const SensorChannels> channels;
  std::map<std::uint32_t, SceneModelPtr> known_models;
  std::optional<std::vector<RunMessage>> messages;
  TextureFolder textures;

  Result<> read_info();
  void find_topics();
  std::size_t sensor_slot(const mcap::Channel& channel);

  /// Decodes a frame. Errors: the bytes are damaged.
  template <class Take>
  auto with_message(const mcap::Reader::Location& location, Take&& take)
      -> decltype(take(std::string_view())) {
    const auto chunk = file->chunk(location.chunk);
    if (!chunk) return tl::unexpected(chunk.error());
    const auto message = mcap::Reader::message_at(**chunk, location.offset);
    if (!message) return tl::unexpected(message.error());
    return take(message->data);
  }

  Result<FrameRecord> record(std::size_t index);
  Result<SceneModelPtr> model(std::uint32_t index);
  Result<std::shared_ptr<Frame>> frame(std::size_t index);
  Reading reading(std::size_t sensor, std::uint64_t count, const SceneModel& model);
  std::shared_ptr<const Picture> picture(SensorTopics& topics, const ReadingRecord& record);
};

}  // namespace cogrsim
