// cogrsim info: the contents of a recording.
#include <unistd.h>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "cogrsim/core/image.h"
#include "cogrsim/recording/recording.h"
#include "common/json_text.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/provenance_text.h"
#include "common/refuse.h"
#include "common/terminal.h"
#include "replay/recording_options.h"

namespace cogrsim::cli {
namespace {

Json info_json(const RecordingInfo& info) {
  Json out;
  out["scene"] = info.scene;
  out["backend"] = info.backend;
  out["engine_version"] = info.engine_version;
  out["library_version"] = info.library_version;
  out["provenance"] = info.provenance ? to_json(*info.provenance) : Json(nullptr);
  out["status"] = text_or_null(info.status);
  out["complete"] = info.complete;
  out["damage"] = text_or_null(info.damage);
  out["seed"] = info.seed;
  out["step"] = info.step;
  out["start"] = info.start;
  out["end"] = info.end;
  out["frames"] = info.frames;
  out["dropped"] = info.dropped;
  out["file_size"] = info.file_size;
  out["parameters"] = Json::object();
  for (const auto& [name, value] : info.parameters) out["parameters"][name] = value;
  out["attachments"] = Json::array();
  for (const Attachment& file : info.attachments) {
    out["attachments"].push_back(
        {{"name", file.name}, {"media_type", file.media_type}, {"size", file.data.size()}});
  }
  out["topics"] = Json::array();
  for (const RecordingInfo::Topic& topic : info.topics) {
    out["topics"].push_back({{"name", topic.name},
                             {"schema", topic.schema},
                             {"encoding", topic.encoding},
                             {"messages", topic.messages}});
  }
  return out;
}

std::string info_text(const RecordingInfo& info, const Style& style) {
  using Align = TextTable::Align;
  const std::string status = info.status.empty() ? "cut off" : info.status;
  std::string out = fmt::format(
      "{}{}{} on {} {}: {}{}{}, {} to {} in steps of {}\n", style.bold, one_line(info.scene),
      style.off, one_line(info.backend), one_line(info.engine_version),
      info.status.empty() ? style.red : style.green, one_line(status), style.off,
      time_text(info.start), time_text(info.end), step_text(info.step));
  if (info.provenance) out += provenance_lines(*info.provenance);
  out += fmt::format("  frames    {}", info.frames);
  if (info.dropped > 0) out += fmt::format(", {} left out", info.dropped);
  out += fmt::format("\n  seed      {}\n  written   by CogRSim {}, {}\n", info.seed,
                     one_line(info.library_version), bytes_text(info.file_size));
  if (!info.damage.empty()) {
    out += fmt::format("  {}damage    {}{}\n", style.red, one_line(info.damage), style.off);
  }
  for (const auto& [name, value] : info.parameters) {
    out += fmt::format("  --set     {}={}\n", one_line(name), one_line(value));
  }
  TextTable topics({Align::left, Align::left, Align::right});
  topics.row({"topic", "schema", "messages"});
  for (const RecordingInfo::Topic& topic : info.topics) {
    topics.row({shortened(one_line(topic.name), 48), one_line(topic.schema),
                std::to_string(topic.messages)});
  }
  out += "\n" + topics.text("  ", style.bold, style.off);
  if (info.attachments.empty()) return out;
  TextTable files({Align::left, Align::left, Align::right});
  files.row({"attached", "type", "size"});
  for (const Attachment& file : info.attachments) {
    files.row({shortened(one_line(file.name), 48), one_line(file.media_type),
               bytes_text(file.data.size())});
  }
  return out + "\n" + files.text("  ", style.bold, style.off);
}

// Names come from a file and must not lead out of the folder.
std::string safe_name(const std::string& name) {
  std::string out;
  for (const auto& part : std::filesystem::path(name).relative_path().lexically_normal()) {
    if (part == ".." || part == "." || part.empty()) continue;
    out += (out.empty() ? "" : "/") + part.string();
  }
  return out.empty() ? "unnamed" : out;
}

bool holds(const std::filesystem::path& path, const std::string& data) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(path, error)) ||
      std::filesystem::file_size(path, error) != data.size()) {
    return false;
  }
  std::ifstream in(path, std::ios::binary);
  return std::string((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>()) ==
         data;
}

Result<> extract(const RecordingInfo& info, const std::string& folder) {
  std::vector<std::pair<std::string, const std::string*>> todo;
  for (const Attachment& file : info.attachments) {
    const std::filesystem::path path = std::filesystem::path(folder) / safe_name(file.name);
    if (holds(path, file.data)) continue;
    std::error_code error;
    std::filesystem::create_directories(path.parent_path(), error);
    if (auto done = check_writable(path.string(), OutputKind::other); !done) return done;
    todo.push_back({path.string(), &file.data});
  }
  // Nothing is written where one file is in the way.
  for (const auto& [path, data] : todo) {
    if (auto done = write_output(path, OutputKind::other, *data); !done) return done;
  }
  return {};
}

}  // namespace

int info_command(const InfoOptions& options) {
  const auto recording = Recording::open(options.file);
  if (!recording) {
    return refuse(recording.error());
  }
  add_input(options.file);
  const RecordingInfo& info = (*recording)->info();
  if (!options.extract.empty()) {
    if (const auto done = extract(info, options.extract); !done) {
      return refuse(done.error());
    }
  }
  const auto printed =
      print_found(options.json, [&] { return json_text(info_json(info)); },
                  [&] { return info_text(info, style_of(fileno(standard_output()))); });
  return printed ? kGood : refuse(printed.error());
}

}  // namespace cogrsim::cli
