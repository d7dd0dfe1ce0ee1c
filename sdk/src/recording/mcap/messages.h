// Exact conversion of frames, models, events and readings to protobuf messages
// (proto/cogrsim.proto) and back.
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

/// A frame as stored in a file; readings and events are given by the numbers of messages of their
/// topics.
struct FrameRecord {
  Frame frame;  ///< without model, readings and events
  std::uint32_t model = 0;
  std::vector<std::uint64_t> readings;
  std::uint64_t events = 0;
  std::uint32_t new_events = 0;
  std::vector<double> controller_outputs;  ///< of all controllers; see share_outputs()
  std::vector<double> supervisor_outputs;
};

/// Appends messages to strings. Not thread-safe, because it reuses its working memory.
class FrameEncoder {
 public:
  void frame(std::string& out, const Frame& frame, std::uint32_t model,
             const std::vector<std::uint64_t>& readings, std::uint64_t events, bool contacts);

 private:
  std::vector<double> numbers_;
};

Result<FrameRecord> take_frame(std::string_view bytes);
/// Checks that the arrays and indices of a frame match its model.
Result<> check_frame(const FrameRecord& record, const SceneModel& model);
/// Distributes the outputs to the controllers of a frame; NaN: no output yet, or an older file.
void share_outputs(const FrameRecord& record, const SceneModel& model, Frame& frame);

void put_model(std::string& out, const SceneModel& model, std::uint32_t index);
Result<std::shared_ptr<const SceneModel>> take_model(std::string_view bytes);

void put_event(std::string& out, const Event& event);
Result<Event> take_event(std::string_view bytes);

/// Positions of the images of a reading: the number of messages of each topic including the image;
/// 0: no such image.
struct PictureLocations {
  std::uint64_t color = 0, depth = 0, segmentation = 0;
};

/// The readings of a sensor have their own schema, in which every value is a field with the name of
/// its channel, because viewers plot by name. Values beyond kNamedValues are a list.
struct ReadingSchema {
  static constexpr std::size_t kNamedValues = 256;
  std::string name;         ///< of the message type
  std::string descriptors;  ///< FileDescriptorSet
  bool named = true;
};
ReadingSchema reading_schema(const std::string& message_name, const std::vector<Channel>& channels);

void put_reading(std::string& out, const Reading& reading, const PictureLocations& picture,
                 bool named);
/// A decoded reading. The caller sets `sensor`; an image has only its size.
struct ReadingRecord {
  Reading reading;
  PictureLocations picture;
  int width = 0, height = 0;  ///< of the image [pixel]; 0: no image
};
Result<ReadingRecord> take_reading(std::string_view bytes);

}  // namespace cogrsim
