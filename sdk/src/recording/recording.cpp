#include "cogrsim/recording/recording.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cogrsim/rendering/renderer.h"
#include "recording/recording_impl.h"
#include "recording/run_writer.h"
#include "recording/mcap/scene_messages.h"

namespace cogrsim {

namespace {

using Locations = std::vector<mcap::Reader::Location>;
using Entries = std::map<std::string, std::string>;

std::string entry(const Entries& entries, const char* key) {
  const auto found = entries.find(key);
  return found == entries.end() ? std::string() : found->second;
}

template <class Number>
Number number_of(const std::string& text) {
  Number value{};
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::vector<Channel> channels_from(const std::string& text) {
  std::vector<Channel> out;
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_array()) return out;
  for (const auto& entry_json : json) {
    if (!entry_json.is_object()) continue;
    Channel channel;
    const auto text_at = [&](const char* key) {
      const auto found = entry_json.find(key);
      return found != entry_json.end() && found->is_string() ? found->get<std::string>() : "";
    };
    channel.name = text_at("name");
    channel.unit = text_at("unit");
    const auto noisy = entry_json.find("noisy");
    channel.noisy = noisy == entry_json.end() || !noisy->is_boolean() || noisy->get<bool>();
    out.push_back(std::move(channel));
  }
  return out;
}

// No scene has more sensors; a larger index is damaged.
constexpr std::size_t kMaxSensors = 1'000'000;

}  // namespace

TextureFolder::~TextureFolder() {
  std::error_code error;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, error);
}

Result<std::string> TextureFolder::put(const std::string& name, const std::string& data) {
  if (const auto known = files_.find(name); known != files_.end()) return known->second;
  if (folder_.empty()) {
    std::error_code error;
    std::filesystem::path root = std::filesystem::temp_directory_path(error);
    std::string wanted = (root / "cogrsim_textures_XXXXXX").string();
    if (error || ::mkdtemp(wanted.data()) == nullptr) {
      return fail("the recording's textures cannot be unpacked: no temporary folder");
    }
    folder_ = wanted;
  }
  const std::string path = fmt::format("{}/{}_{}", folder_, files_.size(),
                                       std::filesystem::path(name).filename().string());
  std::ofstream out(path, std::ios::binary);  // in a private folder
  out.write(data.data(), static_cast<std::streamsize>(data.size()));
  if (!out.flush())
    return fail(fmt::format("the recording's textures cannot be unpacked into '{}'", path));
  files_[name] = path;
  return path;
}

const mcap::Reader::Location* find_location(const Locations& locations, std::uint64_t sequence) {
  const auto found = std::lower_bound(
      locations.begin(), locations.end(), sequence,
      [](const mcap::Reader::Location& one, std::uint64_t s) { return one.sequence < s; });
  return found != locations.end() && found->sequence == sequence ? &*found : nullptr;
}

Recording::Recording(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Recording::~Recording() = default;

Result<std::unique_ptr<Recording>> Recording::open(const std::string& path) {
  auto file = mcap::Reader::open(path);
  if (!file) return tl::unexpected(file.error());
  auto impl = std::make_unique<Impl>();
  impl->file = std::move(*file);
  if (impl->file->profile() != "cogrsim") {
    return fail(
        fmt::format("'{}' is an MCAP file, but no recording of CogRSim (it was written by "
                    "'{}')",
                    path, impl->file->library()));
  }
  if (auto known = impl->read_info(); !known) {
    return fail(fmt::format("'{}': {}", path, known.error().message), "", known.error().hint);
  }
  impl->find_topics();
  if (impl->frames.empty() || impl->models.empty()) {
    const std::string& damage = impl->info.damage;
    return fail(fmt::format("'{}' holds nothing that can be shown{}{}", path,
                            damage.empty() ? "" : ": ", damage));
  }
  return std::unique_ptr<Recording>(new Recording(std::move(impl)));
}

Result<> Recording::Impl::read_info() {
  info.complete = file->complete();
  info.damage = file->damage();
  info.file_size = file->size();
  bool ours = false;
  for (const auto& [name, entries] : file->metadata()) {
    if (name == kRunMetadata) {
      ours = true;
      const int format = number_of<int>(entry(entries, "format"));
      if (format > kFormatVersion) {
        return fail(fmt::format("it is a recording of a newer version (format {}, written by "
                                "CogRSim {}); this program reads format {}",
                                format, entry(entries, "library_version"), kFormatVersion),
                    "", "open it with that version");
      }
      info.scene = entry(entries, "scene");
      info.backend = entry(entries, "backend");
      info.engine_version = entry(entries, "engine_version");
      info.library_version = entry(entries, "library_version");
      // Recordings of version 0.1 have no provenance; a damaged one is ignored.
      if (auto read = parse_provenance(entry(entries, "provenance"))) info.provenance = *read;
      info.seed = number_of<std::uint64_t>(entry(entries, "seed"));
      info.step = number_of<double>(entry(entries, "step"));
      every_step = number_of<double>(entry(entries, "every")) == 0.0;
      contacts = entry(entries, "contacts") != "false";
    } else if (name == kParameterMetadata) {
      info.parameters = entries;
    } else if (name == kEndMetadata) {
      info.status = entry(entries, "status");
      info.dropped = number_of<std::uint64_t>(entry(entries, "left_out"));
    }
  }
  if (!ours) {
    return fail(info.damage.empty() ? "it does not say what was recorded"
                                    : "nothing of it can be read: " + info.damage);
  }
  for (const mcap::AttachmentLocation& location : file->attachments()) {
    auto data = file->attachment(location);
    if (data) {
      info.attachments.push_back({location.name, location.media_type, std::move(*data)});
    } else {
      info.complete = false;
      info.damage += (info.damage.empty() ? "" : "; ") + data.error().message;
    }
  }
  return {};
}

std::size_t Recording::Impl::sensor_slot(const mcap::Channel& channel) {
  const auto found = channel.metadata.find("sensor");
  if (found == channel.metadata.end()) return kMaxSensors;
  const auto index = number_of<std::size_t>(found->second);
  if (index >= kMaxSensors) return kMaxSensors;
  if (sensors.size() <= index) sensors.resize(index + 1);
  return index;
}

void Recording::Impl::find_topics() {
  const auto none = std::make_shared<const std::vector<Channel>>();
  SensorChannels all;
  for (const auto& [id, channel] : file->channels()) {
    const Locations& locations = file->locations(id);
    RecordingInfo::Topic topic;
    topic.name = channel.topic;
    topic.encoding = channel.encoding;
    topic.messages = locations.size();
    const auto schema = file->schemas().find(channel.schema);
    if (schema != file->schemas().end()) topic.schema = schema->second.name;
    info.topics.push_back(std::move(topic));
    if (channel.topic == "/frame") frames = locations;
    if (channel.topic == "/model") models = locations;
    if (channel.topic == "/events") events = locations;
    if (channel.topic == "/log") logs = locations;
    const std::size_t slot = sensor_slot(channel);
    if (slot >= kMaxSensors) continue;
    SensorTopics& sensor = sensors[slot];
    const std::string part = entry(channel.metadata, "part");
    Locations* const list = part == "reading"        ? &sensor.readings
                         : part == "color"        ? &sensor.color
                         : part == "depth"        ? &sensor.depth
                         : part == "segmentation" ? &sensor.segmentation
                                                  : nullptr;
    if (list == nullptr) continue;
    list->insert(list->end(), locations.begin(), locations.end());
    if (part != "reading") continue;
    all.resize(sensors.size(), none);
    all[slot] = std::make_shared<const std::vector<Channel>>(
        channels_from(entry(channel.metadata, "channels")));
  }
  all.resize(sensors.size(), none);
  channels = std::make_shared<const SensorChannels>(std::move(all));
  // A sensor that replaced another one continues its count.
  for (SensorTopics& sensor : sensors) {
    for (Locations* list : {&sensor.readings, &sensor.color, &sensor.depth, &sensor.segmentation}) {
      std::sort(list->begin(), list->end(), [](const auto& a, const auto& b) {
        return std::pair(a.chunk, a.offset) < std::pair(b.chunk, b.offset);
      });
      if (!file->complete()) continue;
      for (std::size_t i = 0; i < list->size(); ++i) {
        (*list)[i].sequence = static_cast<std::uint32_t>(i);
      }
    }
  }
  info.frames = frames.size();
  if (frames.empty()) return;
  info.start = static_cast<double>(frames.front().time) / 1e9;
  info.end = static_cast<double>(frames.back().time) / 1e9;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    if (frames[i].time < frames[i - 1].time) in_order = false;
  }
  // Frames have the numbers of the run, so gaps are dropped frames. A complete file has their
  // number at its end, so that no chunk needs to be decompressed.
  if (file->complete()) return;
  const std::uint64_t shown = std::uint64_t{frames.back().sequence} + 1;
  if (shown > frames.size()) info.dropped = std::max(info.dropped, shown - frames.size());
}

const RecordingInfo& Recording::info() const { return impl_->info; }
std::size_t Recording::frame_count() const { return impl_->frames.size(); }

double Recording::time_of(std::size_t index) const {
  return static_cast<double>(impl_->frames[index].time) / 1e9;
}

std::size_t Recording::index_at(double time) const {
  const Locations& frames = impl_->frames;
  const std::uint64_t wanted = nanoseconds(time);
  if (impl_->in_order) {
    const auto after = std::upper_bound(
        frames.begin(), frames.end(), wanted,
        [](std::uint64_t t, const mcap::Reader::Location& location) { return t < location.time; });
    return after == frames.begin() ? 0 : static_cast<std::size_t>(after - frames.begin()) - 1;
  }
  for (std::size_t i = frames.size(); i > 0; --i) {
    if (frames[i - 1].time <= wanted) return i - 1;
  }
  return 0;
}

Result<FrameRecord> Recording::Impl::record(std::size_t index) {
  return with_message(frames[index], [](std::string_view bytes) { return take_frame(bytes); });
}

Result<SceneModelPtr> Recording::Impl::model(std::uint32_t index) {
  if (const auto known = known_models.find(index); known != known_models.end()) {
    return known->second;
  }
  const mcap::Reader::Location* location = find_location(models, index);
  if (location == nullptr) return fail(fmt::format("scene {} of the recording is lost", index));
  auto model = with_message(*location, [](std::string_view bytes) { return take_model(bytes); });
  if (!model) return tl::unexpected(model.error());
  SceneModelPtr out = *model;
  for (std::size_t i = 0; i < out->materials.size(); ++i) {
    const std::string& texture = (*model)->materials[i].texture;
    const auto attached =
        std::find_if(info.attachments.begin(), info.attachments.end(),
                     [&](const Attachment& file_there) { return file_there.name == texture; });
    if (texture.empty()) continue;
    // The file with this name is never read: a recording from another source could name any file.
    auto path = attached == info.attachments.end() ? Result<std::string>("")
                                                   : textures.put(texture, attached->data);
    if (!path) return tl::unexpected(path.error());
    auto changed = std::make_shared<SceneModel>(*out);
    changed->materials[i].texture = std::move(*path);
    out = std::move(changed);
  }
  known_models[index] = out;
  return out;
}

std::shared_ptr<const Picture> Recording::Impl::picture(SensorTopics& topics,
                                                        const ReadingRecord& record) {
  if (record.width == 0 || record.height == 0) return nullptr;
  const auto same = [](const PictureLocations& a, const PictureLocations& b) {
    return a.color == b.color && a.depth == b.depth && a.segmentation == b.segmentation;
  };
  if (topics.picture && same(topics.picture_locations, record.picture)) return topics.picture;
  auto out = std::make_shared<Picture>();
  out->width = record.width;
  out->height = record.height;
  const std::size_t pixels =
      static_cast<std::size_t>(out->width) * static_cast<std::size_t>(out->height);
  const auto image = [&](const Locations& locations, std::uint64_t count, auto take) {
    const mcap::Reader::Location* location =
        count == 0 ? nullptr : find_location(locations, count - 1);
    if (location == nullptr) return ImageRecord();
    return with_message(*location,
                        [&](std::string_view bytes) -> Result<ImageRecord> { return take(bytes); })
        .value_or(ImageRecord());
  };
  const ImageRecord color = image(topics.color, record.picture.color, take_compressed_image);
  if (!color.data.empty()) {
    auto decoded = decode_image(color.data);
    if (decoded && decoded->width == out->width && decoded->height == out->height) {
      out->color = std::move(*decoded);
    }
  }
  const ImageRecord depth = image(topics.depth, record.picture.depth, take_raw_image);
  if (depth.encoding == "32FC1" && depth.data.size() == 4 * pixels) {
    out->depth.resize(pixels);
    std::memcpy(out->depth.data(), depth.data.data(), depth.data.size());
  }
  const ImageRecord labels =
      image(topics.segmentation, record.picture.segmentation, take_raw_image);
  const std::size_t width = labels.encoding == "16UC1" ? 2 : labels.encoding == "32SC1" ? 4 : 0;
  if (width > 0 && labels.data.size() == width * pixels) {
    out->bodies.resize(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
      std::uint32_t label = 0;
      std::memcpy(&label, &labels.data[i * width], width);
      out->bodies[i] = static_cast<std::int32_t>(label) - 1;
    }
  }
  topics.picture = out;
  topics.picture_locations = record.picture;
  return out;
}

Reading Recording::Impl::reading(std::size_t sensor, std::uint64_t count, const SceneModel& model) {
  Reading none;
  none.sensor = static_cast<int>(sensor);
  none.enabled = model.sensors[sensor].enabled;
  if (count == 0 || sensor >= sensors.size()) return none;
  SensorTopics& topics = sensors[sensor];
  if (topics.last == count) return topics.reading;
  const mcap::Reader::Location* location = find_location(topics.readings, count - 1);
  if (location == nullptr) return none;  // lost with a damaged part of the file
  auto record = with_message(*location, [](std::string_view bytes) { return take_reading(bytes); });
  if (!record) return none;
  topics.reading = std::move(record->reading);
  topics.reading.sensor = none.sensor;
  topics.reading.picture = picture(topics, *record);
  topics.last = count;
  return topics.reading;
}

Result<std::shared_ptr<Frame>> Recording::Impl::frame(std::size_t index) {
  if (index >= frames.size()) {
    return fail(
        fmt::format("the recording has {} frames, there is no frame {}", frames.size(), index));
  }
  auto known = record(index);
  if (!known) return tl::unexpected(known.error());
  auto scene = model(known->model);
  if (!scene) return tl::unexpected(scene.error());
  if (auto good = check_frame(*known, **scene); !good) return tl::unexpected(good.error());
  auto out = std::make_shared<Frame>(std::move(known->frame));
  out->model = *scene;
  out->contents.contacts = contacts;
  out->contents.accelerations = !out->accelerations.empty() || out->dt == 0.0;
  out->contents.joint_reactions = !out->joint_reactions.empty();
  out->channels = channels;
  share_outputs(*known, **scene, *out);
  out->readings.reserve(known->readings.size());
  for (std::size_t i = 0; i < known->readings.size(); ++i) {
    out->readings.push_back(reading(i, known->readings[i], **scene));
  }
  const std::uint64_t last = std::min<std::uint64_t>(known->events, std::uint64_t{1} << 32);
  for (std::uint64_t i = last - std::min<std::uint64_t>(known->new_events, last); i < last; ++i) {
    const mcap::Reader::Location* location = find_location(events, i);
    if (location == nullptr) break;  // lost with a damaged part of the file
    auto event = with_message(*location, [](std::string_view bytes) { return take_event(bytes); });
    if (event) out->events.push_back(std::move(*event));
  }
  return out;
}

Result<FramePtr> Recording::frame(std::size_t index) {
  auto out = impl_->frame(index);
  if (!out) return tl::unexpected(out.error());
  return FramePtr(std::move(*out));
}

const std::vector<RunMessage>& Recording::messages() const {
  if (!impl_->messages) {
    impl_->messages.emplace();
    for (const mcap::Reader::Location& location : impl_->logs) {
      auto message = impl_->with_message(
          location, [](std::string_view bytes) -> Result<RunMessage> { return take_log(bytes); });
      if (message) impl_->messages->push_back(std::move(*message));
    }
  }
  return *impl_->messages;
}

const std::vector<Channel>& Recording::channels(int sensor) const {
  static const std::vector<Channel> kNone;
  const auto index = static_cast<std::size_t>(sensor);
  return sensor >= 0 && index < impl_->channels->size() ? *(*impl_->channels)[index] : kNone;
}

}  // namespace cogrsim
