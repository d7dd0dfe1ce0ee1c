// Frames, models, events and readings as protobuf messages (proto/cogrsim.proto) and back, to the
// last bit.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/sensing/sensor.h"

namespace cogrsim {

/// A frame as it is on file: readings and events are told by how many messages their topics had.
struct FrameRecord {
  Frame frame;  ///< without model, readings and events
  std::uint32_t model = 0;
  std::vector<std::uint64_t> readings;
  std::uint64_t events = 0;
  std::uint32_t new_events = 0;
  std::vector<double> controller_outputs;  ///< one after the other; see share_outputs()
  std::vector<double> supervisor_outputs;
};

/// Appends messages to strings; one object per thread, because it keeps its scratch memory.
class FrameEncoder {
 public:
  void frame(std::string& out, const Frame& frame, std::uint32_t model,
             const std::vector<std::uint64_t>& readings, std::uint64_t events, bool contacts);

 private:
  std::vector<double> numbers_;
};

Result<FrameRecord> take_frame(std::string_view bytes);
/// Refuses a frame whose arrays have other lengths than its model's, or that points outside it.
Result<> check_frame(const FrameRecord& record, const SceneModel& model);
/// Gives the minds of a frame what they had published by then; NaN: nothing, or an older file.
void share_outputs(const FrameRecord& record, const SceneModel& model, Frame& frame);

void put_model(std::string& out, const SceneModel& model, std::uint32_t index);
Result<std::shared_ptr<const SceneModel>> take_model(std::string_view bytes);

void put_event(std::string& out, const Event& event);
Result<Event> take_event(std::string_view bytes);

/// Where the parts of a reading's picture are: how many messages their topics had with it, 0: the
/// picture has no such part.
struct PicturePlaces {
  std::uint64_t color = 0, depth = 0, segmentation = 0;
};

/// Readings of a sensor have a schema of their own, in which every value is a field with its
/// channel's name: viewers plot by name. Beyond kNamedValues the values are a list.
struct ReadingSchema {
  static constexpr std::size_t kNamedValues = 256;
  std::string name;         ///< of the message type
  std::string descriptors;  ///< FileDescriptorSet
  bool named = true;
};
ReadingSchema reading_schema(const std::string& message_name, const std::vector<Channel>& channels);

void put_reading(std::string& out, const Reading& reading, const PicturePlaces& picture,
                 bool named);
/// `sensor` is left to the caller; a picture has only its size.
struct ReadingRecord {
  Reading reading;
  PicturePlaces picture;
  int width = 0, height = 0;  ///< of the picture; 0: there is none
};
Result<ReadingRecord> take_reading(std::string_view bytes);

}  // namespace cogrsim
