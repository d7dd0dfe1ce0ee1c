#include "run/recording_start.h"

#include <filesystem>

#include "common/output_file.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;

// "scenes/maze.scene.xml" -> "maze.mcap"
std::string default_file(const std::string& scene) {
  std::string name = fs::path(scene).filename().string();
  const std::string ending = ".scene.xml";
  if (name.size() > ending.size() &&
      name.compare(name.size() - ending.size(), ending.size(), ending) == 0) {
    name.resize(name.size() - ending.size());
  } else {
    name = fs::path(name).stem().string();
  }
  return name + ".mcap";
}

}  // namespace

bool wants_recording(const SceneModel& model, const RunOptions& options) {
  return !options.record.empty() || model.record.has_value();
}

Result<RecorderOptions> recorder_options(const SceneModel& model, const RunOptions& options) {
  RecorderOptions out;
  const RecordModel choices = model.record.value_or(RecordModel());
  const fs::path folder = fs::path(options.scene.scene).parent_path();
  if (!options.record.empty()) {
    out.path = options.record;
    out.rules = output_rules();
  } else {
    const std::string outputs = output_folder(folder.string());
    const auto path =
        output_in(outputs, choices.file.empty() ? default_file(options.scene.scene) : choices.file);
    if (!path) return tl::unexpected(path.error());
    out.path = *path;
    out.rules = scene_rules(outputs);
  }
  out.every = choices.every;
  out.contacts = choices.contacts;
  out.images = choices.images;
  out.jpeg = choices.jpeg;
  out.parameters = options.scene.set;
  out.attachments = scene_files(model, folder.string());
  return out;
}

}  // namespace cogrsim::cli
