// The inside of a Recording.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/recording/recording.h"
#include "recording/mcap_reader.h"
#include "recording/messages.h"

namespace cogrsim {

/// The pictures a recording carries for materials whose files are not there any more; gone with the
/// object.
class TextureFolder {
 public:
  TextureFolder() = default;
  TextureFolder(const TextureFolder&) = delete;
  TextureFolder& operator=(const TextureFolder&) = delete;
  ~TextureFolder();
  /// Path of a file with this content. Errors: the system's.
  Result<std::string> put(const std::string& name, const std::string& data);

 private:
  std::string folder_;
  std::map<std::string, std::string> files_;
};

using MessagePlaces = std::vector<mcap::Reader::Place>;

/// The message with this sequence number; nullptr: it is not in the file.
const mcap::Reader::Place* find_place(const MessagePlaces& places, std::uint64_t sequence);

struct Recording::Impl {
  using Places = MessagePlaces;

  struct SensorTopics {
    Places readings, color, depth, segmentation;
    // The reading that was asked for last: many frames share it.
    std::uint64_t last = 0;
    Reading reading;
    std::shared_ptr<const Picture> picture;
    PicturePlaces picture_places;
  };

  std::unique_ptr<mcap::Reader> file;
  RecordingInfo info;
  bool every_step = false;
  bool contacts = true;
  Places frames, models, events, logs;
  bool in_order = true;  ///< times never go back
  std::vector<SensorTopics> sensors;
  std::shared_ptr<const SensorChannels> channels;
  std::map<std::uint32_t, SceneModelPtr> known_models;
  std::optional<std::vector<RunMessage>> messages;
  TextureFolder textures;

  Result<> read_info();
  void find_topics();
  std::size_t sensor_slot(const mcap::Channel& channel);

  /// Errors: the bytes are damaged.
  template <class Take>
  auto with_message(const mcap::Reader::Place& place, Take&& take)
      -> decltype(take(std::string_view())) {
    const auto chunk = file->chunk(place.chunk);
    if (!chunk) return tl::unexpected(chunk.error());
    const auto message = mcap::Reader::message_at(**chunk, place.offset);
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
