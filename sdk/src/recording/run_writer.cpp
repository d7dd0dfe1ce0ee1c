#include "recording/run_writer.h"

#include <filesystem>
#include <fstream>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace cogrsim {

namespace {

constexpr std::size_t kAttachmentLimit = 256u << 20;  // total size of the textures [byte]

using Json = nlohmann::ordered_json;

std::string media_type_of(const std::string& bytes) {
  return bytes.rfind("\x89PNG", 0) == 0 ? "image/png" : "image/jpeg";
}

template <class Elements>
std::string names_json(const Elements& elements) {
  Json out = Json::array();
  for (const auto& element : elements) out.push_back(element.name);
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

RunWriter::RunWriter(std::unique_ptr<mcap::Sink> sink, const RecorderOptions& options)
    : mcap_(std::move(sink)),
      encoder_(mcap_, {options.contacts, options.images, options.jpeg}),
      options_(options) {}

Result<> RunWriter::start(const std::map<std::string, std::string>& about) {
  if (auto done = mcap_.start("cogrsim", "cogrsim " COGRSIM_VERSION); !done) return done;
  if (auto done = mcap_.metadata(kRunMetadata, about); !done) return done;
  if (auto done = mcap_.metadata(kParameterMetadata, options_.parameters); !done) return done;
  for (const Attachment& file : options_.attachments) {
    if (auto done = attach(file); !done) return done;
  }
  encoder_.start();
  return {};
}

Result<> RunWriter::attach_textures(const SceneModel& model) {
  std::set<std::string> done;
  std::size_t bytes = 0;
  for (const Material& material : model.materials) {
    if (material.texture.empty() || !done.insert(material.texture).second) continue;
    std::error_code error;
    const auto size = std::filesystem::file_size(material.texture, error);
    std::ifstream in(material.texture, std::ios::binary);
    std::string data;
    if (!error && bytes + size <= kAttachmentLimit) {
      data.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
    if (data.empty()) {
      encoder_.message(
          {0.0, Severity::warning, "recorder",
           fmt::format("texture '{}' is not in the recording: {}", material.texture,
                       error || !in ? "it cannot be read" : "the total size is too large")});
      continue;
    }
    bytes += data.size();
    auto written = mcap_.attachment(material.texture, media_type_of(data), data, 0);
    if (!written) return written;
  }
  return {};
}

void RunWriter::model(const SceneModelPtr& model, const SensorChannels& channels, double time) {
  // Names for readers of the packed numbers. A full disk is detected at the next chunk.
  static_cast<void>(mcap_.metadata(fmt::format("{} {}", kModelMetadata, encoder_.models()),
                                   {{"bodies", names_json(model->bodies)},
                                    {"joints", names_json(model->joints)},
                                    {"motors", names_json(model->motors)},
                                    {"sensors", names_json(model->sensors)}}));
  encoder_.model(model, channels, time);
}

Result<> RunWriter::finish(const std::map<std::string, std::string>& end) {
  return mcap_.finish(kEndMetadata, end);
}

}  // namespace cogrsim
