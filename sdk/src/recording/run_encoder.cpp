#include "recording/run_encoder.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cogrsim/rendering/renderer.h"
#include "recording/mcap/scene_messages.h"
#include "recording/mcap/schemas.h"

namespace cogrsim {

namespace {

constexpr double kTransformPeriod = 1.0 / 30.0;  // of /tf in simulated time [s]

using Json = nlohmann::ordered_json;

std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string channels_json(const std::vector<Channel>& channels) {
  Json out = Json::array();
  for (const Channel& channel : channels) {
    out.push_back({{"name", channel.name}, {"unit", channel.unit}, {"noisy", channel.noisy}});
  }
  return dump(out);
}

// Names are separated by dots in a scene and by slashes in topics.
std::string topic_name(const std::string& sensor) {
  std::string out = "/sensors/" + sensor;
  std::replace(out.begin(), out.end(), '.', '/');
  return out;
}

}  // namespace

std::uint64_t nanoseconds(double time) {
  return time > 0.0 ? static_cast<std::uint64_t>(std::llround(time * 1e9)) : 0;
}

std::uint16_t RunEncoder::topic(std::string name, std::uint16_t schema,
                                std::map<std::string, std::string> metadata) {
  return sink_.add_channel(schema, std::move(name), "protobuf", std::move(metadata));
}

void RunEncoder::start() {
  const auto ours = [&](const char* name) {
    return sink_.add_schema(std::string("cogrsim.") + name, "protobuf",
                            std::string(cogrsim_schemas()));
  };
  const auto viewers = [&](const char* name) {
    return sink_.add_schema(std::string("foxglove.") + name, "protobuf",
                            std::string(foxglove_schemas()));
  };
  frame_topic_ = topic("/frame", ours("Frame"));
  model_topic_ = topic("/model", ours("Model"));
  event_topic_ = topic("/events", ours("Event"));
  log_topic_ = topic("/log", viewers("Log"));
  transform_topic_ = topic("/tf", viewers("FrameTransforms"));
  scene_topic_ = topic("/scene", viewers("SceneUpdate"));
  raw_image_ = viewers("RawImage");
  compressed_image_ = viewers("CompressedImage");
  laser_scan_ = viewers("LaserScan");
}

void RunEncoder::model(const SceneModelPtr& model, const SensorChannels& channels, double time) {
  model_ = model;
  const std::uint64_t now = nanoseconds(time);
  sink_.message(model_topic_, models_, now,
                [&](std::string& out) { put_model(out, *model, models_); });
  sink_.message(scene_topic_, scenes_++, now,
                [&](std::string& out) { put_scene(out, *model, now); });
  ++models_;
  sensors_.resize(std::max(sensors_.size(), model->sensors.size()));
  for (std::size_t i = 0; i < model->sensors.size(); ++i) {
    sensor_topics(i, model->sensors[i], *channels[i]);
  }
  next_transform_ = 0.0;
}

void RunEncoder::sensor_topics(std::size_t index, const SensorModel& sensor,
                               const std::vector<Channel>& channels) {
  SensorTopics& topics = sensors_[index];
  std::string json = channels_json(channels);
  // The channels of removed sensors are not known any more.
  if (topics.reading != 0 && topics.name == sensor.name &&
      (sensor.removed || topics.channels == json))
    return;
  // Sensors of one type with the same channels share a schema.
  const auto [known, is_new] = reading_schemas_.try_emplace(sensor.type + json);
  if (is_new) {
    const int count = ++schema_names_[sensor.type];
    const ReadingSchema schema = reading_schema(
        count == 1 ? sensor.type : fmt::format("{}_{}", sensor.type, count), channels);
    known->second = {sink_.add_schema(schema.name, "protobuf", schema.descriptors), schema.named};
  }
  const std::string name = topic_name(sensor.name);
  topics.name = sensor.name;
  topics.channels = json;
  topics.named = known->second.second;
  topics.color = topics.depth = topics.segmentation = topics.scan = 0;
  topics.reading = topic(name, known->second.first,
                         {{"sensor", std::to_string(index)},
                          {"name", sensor.name},
                          {"type", sensor.type},
                          {"part", "reading"},
                          {"channels", std::move(json)}});
  if (is_planar_scan(sensor)) topics.scan = image_topic(index, sensor, "scan", laser_scan_);
}

std::uint16_t RunEncoder::image_topic(std::size_t index, const SensorModel& sensor,
                                      const char* part, std::uint16_t schema) {
  return topic(topic_name(sensor.name) + "/" + part, schema,
               {{"sensor", std::to_string(index)}, {"name", sensor.name}, {"part", part}});
}

PictureLocations RunEncoder::picture(std::size_t index, const Picture& picture,
                                     std::uint64_t time) {
  SensorTopics& topics = sensors_[index];
  const SensorModel& sensor = model_->sensors[index];
  const std::string frame_id = sensor.name + "/optical";
  PictureLocations locations;
  if (!picture.color.data.empty()) {
    if (topics.color == 0) topics.color = image_topic(index, sensor, "color", compressed_image_);
    // Asked once: others subscribe meanwhile.
    const bool wanted = sink_.wants(topics.color);
    const auto data = !wanted         ? Result<std::string>(std::string())
                      : options_.jpeg ? encode_jpeg(picture.color)
                                      : encode_png(picture.color);
    if (data) {
      if (wanted)
        sink_.message(
            topics.color, static_cast<std::uint32_t>(topics.colors), time, [&](std::string& out) {
              put_compressed_image(out, frame_id, *data, options_.jpeg ? "jpeg" : "png", time);
            });
      locations.color = ++topics.colors;
    } else {
      message({static_cast<double>(time) / 1e9, Severity::error, sensor.name, data.error().text()});
    }
  }
  if (!picture.depth.empty()) {
    if (topics.depth == 0) topics.depth = image_topic(index, sensor, "depth", raw_image_);
    const std::string_view data(reinterpret_cast<const char*>(picture.depth.data()),
                                picture.depth.size() * sizeof(float));
    sink_.message(topics.depth, static_cast<std::uint32_t>(topics.depths), time,
                  [&](std::string& out) {
                    put_raw_image(out, frame_id, picture.width, picture.height, "32FC1",
                                  4 * picture.width, data, time);
                  });
    locations.depth = ++topics.depths;
  }
  if (!picture.bodies.empty()) {
    if (topics.segmentation == 0) {
      topics.segmentation = image_topic(index, sensor, "segmentation", raw_image_);
    }
    // Body index + 1 in 16 bits, which viewers can display; scenes with more bodies need 32 bits.
    const bool wide = model_->bodies.size() >= 65535;
    sink_.message(topics.segmentation, static_cast<std::uint32_t>(topics.segmentations), time,
                  [&](std::string& out) {
                    std::string data;
                    data.reserve(picture.bodies.size() * 4);
                    for (const std::int32_t body : picture.bodies) {
                      const auto label = static_cast<std::uint32_t>(body + 1);
                      data.append(reinterpret_cast<const char*>(&label), wide ? 4 : 2);
                    }
                    put_raw_image(out, frame_id, picture.width, picture.height,
                                  wide ? "32SC1" : "16UC1", (wide ? 4 : 2) * picture.width, data,
                                  time);
                  });
    locations.segmentation = ++topics.segmentations;
  }
  return locations;
}

void RunEncoder::reading(std::size_t index, const Reading& reading, double time) {
  SensorTopics& topics = sensors_[index];
  const bool same = topics.any && reading.sequence == topics.sequence &&
                    reading.time == topics.time && reading.valid == topics.valid &&
                    reading.enabled == topics.enabled && reading.picture.get() == topics.picture;
  // A sensor has no message before its first reading.
  if (same || (!topics.any && reading.sequence == 0 && reading.enabled)) return;
  // A measurement has the time of what it shows, so that viewers put it beside the poses of that
  // time. That the sensor was switched on or off is known from the time of the frame on.
  const bool measured = reading.sequence != topics.sequence;
  const std::uint64_t stamp = nanoseconds(measured ? reading.time : time);
  if (!options_.images) {
    topics.locations = {};
  } else if (reading.picture.get() != topics.picture) {
    topics.locations =
        reading.picture ? picture(index, *reading.picture, stamp) : PictureLocations{};
  }
  topics.any = true;
  topics.sequence = reading.sequence;
  topics.time = reading.time;
  topics.valid = reading.valid;
  topics.enabled = reading.enabled;
  topics.picture = reading.picture.get();
  topics.kept_picture = reading.picture;  // so that its address is not reused
  sink_.message(topics.reading, static_cast<std::uint32_t>(topics.readings), stamp,
                [&](std::string& out) {
                  if (options_.images || !reading.picture) {
                    put_reading(out, reading, topics.locations, topics.named);
                  } else {
                    Reading without = reading;
                    without.picture.reset();
                    put_reading(out, without, {}, topics.named);
                  }
                });
  ++topics.readings;
  if (topics.scan != 0 && reading.valid) {
    sink_.message(topics.scan, static_cast<std::uint32_t>(topics.readings - 1), stamp,
                  [&](std::string& out) {
                    put_scan(out, model_->sensors[index], reading, nanoseconds(reading.time));
                  });
  }
}

void RunEncoder::frame(const Frame& frame, bool keep, std::uint64_t number) {
  const std::size_t sensors = std::min(frame.readings.size(), sensors_.size());
  for (std::size_t i = 0; i < sensors; ++i) reading(i, frame.readings[i], frame.time);
  for (const Event& event : frame.events) {
    sink_.message(event_topic_, static_cast<std::uint32_t>(events_++), nanoseconds(event.time),
                  [&](std::string& out) { put_event(out, event); });
  }
  if (!keep) return;
  reading_counts_.resize(frame.readings.size());
  for (std::size_t i = 0; i < reading_counts_.size(); ++i) {
    reading_counts_[i] = sensors_[i].readings;
  }
  put_frame(frame, number);
  if (frame.time < last_time_) next_transform_ = 0.0;  // the run was restarted
  last_time_ = frame.time;
  // A tolerance of half a nanosecond, so that steps that divide the period evenly are on time.
  if (frame.time + 5e-10 >= next_transform_) {
    next_transform_ = (std::floor((frame.time + 5e-10) / kTransformPeriod) + 1) * kTransformPeriod;
    put_tf(frame);
  }
}

void RunEncoder::put_frame(const Frame& frame, std::uint64_t number) {
  sink_.message(frame_topic_, static_cast<std::uint32_t>(number), nanoseconds(frame.time),
                [&](std::string& out) {
                  encoder_.frame(out, frame, models_ - 1, reading_counts_, events_,
                                 options_.contacts);
                });
}

void RunEncoder::put_tf(const Frame& frame) {
  const std::uint64_t now = nanoseconds(frame.time);
  sink_.message(transform_topic_, transforms_++, now,
                [&](std::string& out) { put_transforms(out, frame, now); });
}

void RunEncoder::again(const Frame& frame, std::uint64_t number) {
  put_frame(frame, number);
  put_tf(frame);
}

void RunEncoder::message(const RunMessage& message) {
  const std::uint64_t now = nanoseconds(message.time);
  sink_.message(log_topic_, logs_++, now, [&](std::string& out) { put_log(out, message, now); });
}

}  // namespace cogrsim
