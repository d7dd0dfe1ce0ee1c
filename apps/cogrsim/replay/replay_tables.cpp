#include "replay/replay_tables.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "cogrsim/recording/frame_tables.h"
#include "common/output_file.h"

namespace cogrsim::cli {
namespace {

// RFC 4180.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

std::string cell(const TableValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{:.17g}", *number);
  const auto* text = std::get_if<std::string_view>(&value);
  return text != nullptr ? cell(std::string(*text)) : std::string();
}

std::string titled(const std::string& name, const std::string& unit) {
  return cell(unit.empty() || unit == "1" ? name : fmt::format("{} [{}]", name, unit));
}

}  // namespace

Result<std::unique_ptr<ReplayTables>> ReplayTables::create(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    return fail(fmt::format("cannot write tables into '{}': {}", folder,
                            error ? error.message() : "it is not a folder"));
  }
  return std::unique_ptr<ReplayTables>(new ReplayTables(folder));
}

ReplayTables::File* ReplayTables::table(const std::string& name, const std::string& head) {
  std::unique_ptr<File>& slot = files_[name];
  if (!slot) {
    slot = std::make_unique<File>();
    std::string file = name;
    std::replace(file.begin(), file.end(), '/', '_');
    const std::string path = folder_ + "/" + file + ".csv";
    auto created = OutputFile::create(path, OutputKind::csv, output_rules());
    if (created) {
      slot->file.emplace(std::move(*created));
      note(slot->file->append(head + "\n"));
    } else {
      note(tl::unexpected(created.error()));
    }
  }
  return slot.get();
}

void ReplayTables::add(const Frame& frame, const ChannelsOf& channels) {
  const SceneModel& model = *frame.model;
  const auto row = [this](File* to, const std::string& text) {
    if (to->file && problem_) note(to->file->append(text + "\n"));
  };
  for (const auto& [name, kind] :
       {std::pair("bodies", FrameTable::bodies), std::pair("joints", FrameTable::joints),
        std::pair("contacts", FrameTable::contacts)}) {
    std::string head;
    for (const TableColumn& column : columns_of(kind))
      head += (head.empty() ? "" : ",") + titled(column.name, column.unit);
    File* const to = table(name, head);
    for_rows(kind, frame, [&](const std::vector<TableValue>& values) {
      std::string text;
      for (const TableValue& value : values) text += (text.empty() ? "" : ",") + cell(value);
      row(to, text);
    });
  }
  for (const Reading& reading : frame.readings) {
    const SensorModel& sensor = model.sensors[reading.sensor];
    if (reading.sequence == 0 || sensor.removed) continue;
    std::string head = "time [s],sequence,valid";
    for (const Channel& channel : channels(reading.sensor)) {
      head += "," + titled(channel.name, channel.unit);
    }
    File* const to = table("sensors_" + sensor.name, head);
    if (to->sequence == reading.sequence) continue;
    to->sequence = reading.sequence;
    std::string text = fmt::format("{:.17g},{},{}", reading.time, reading.sequence,
                                   reading.valid ? "true" : "false");
    for (const double value : reading.values) text += fmt::format(",{:.17g}", value);
    row(to, text);
  }
}

void ReplayTables::note(const Result<>& done) {
  if (problem_ && !done) problem_ = done;
}

Result<> ReplayTables::finish() {
  for (auto& [name, slot] : files_) {
    if (problem_ && slot->file) note(slot->file->commit());
  }
  return problem_;
}

}  // namespace cogrsim::cli
