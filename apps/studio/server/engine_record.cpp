// Recordings of the run.
#include <filesystem>
#include <system_error>

#include "common/options.h"
#include "engine.h"
#include "run/recording_start.h"

namespace cogrsim::studio {

namespace fs = std::filesystem;

namespace {

constexpr const char* kEnding = ".mcap";

bool ends_so(const std::string& name) {
  const std::string ending = kEnding;
  return name.size() >= ending.size() &&
         name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

/// Characters that are allowed in a file's name.
std::string plain(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const auto u = static_cast<unsigned char>(c);
    out += u < 0x20 || c == '/' || c == '\\' || c == 0x7f ? '_' : c;
  }
  return out.empty() || out.front() == '.' ? "run" + out : out;
}

}  // namespace

Result<std::string> Engine::recording_path(const std::optional<std::string>& file) const {
  const fs::path folder = options_.folder.empty() ? fs::path(".") : fs::path(options_.folder);
  std::error_code ignored;
  if (!file || file->empty()) {
    // A free name: an older recording is never replaced without being asked for.
    const std::string stem = plain(simulation_->model()->name);
    for (int number = 1;; ++number) {
      const std::string name = stem + (number > 1 ? "-" + std::to_string(number) : "") + kEnding;
      if (!fs::exists(fs::symlink_status(folder / name, ignored))) return (folder / name).string();
    }
  }
  if (plain(*file) != *file || file->size() > 200) {
    return fail("'" + *file + "' is not a bare file name", "",
                "a recording goes beside the scene: give a name without folders");
  }
  const fs::path path = folder / (ends_so(*file) ? *file : *file + kEnding);
  if (fs::exists(fs::symlink_status(path, ignored)) && !Recording::open(path.string())) {
    return fail("'" + path.filename().string() + "' is there and is no recording", "",
                "give another name");
  }
  return path.string();
}

Answer Engine::record(bool on, const std::optional<std::string>& file) {
  if (!on) {
    if (!recorder_) return fail("nothing is recorded");
    const std::string name = recording_;
    end_recording("");
    publish(true);
    return Json{{"file", name}};
  }
  if (!simulation_) return fail("there is no scene yet that can be run");
  if (recorder_) {
    return fail("it is being recorded already, to '" + recording_ + "'", "", "end that first");
  }
  auto path = recording_path(file);
  if (!path) return tl::unexpected(path.error());
  cli::RunOptions choices;
  choices.record = *path;
  const std::vector<std::string>& files = scene_->model->files;
  choices.scene.scene = files.empty() ? std::string() : files.front();
  choices.scene.set = options_.parameters;
  auto recording = cli::recorder_options(*simulation_->model(), choices);
  if (!recording) return tl::unexpected(recording.error());
  auto started = Recorder::start(*simulation_, std::move(*recording));
  if (!started) return tl::unexpected(started.error());
  recorder_ = std::move(*started);
  recording_ = fs::path(*path).filename().string();
  publish(true);
  return Json{{"file", recording_}, {"from", simulation_->time()}};
}

void Engine::end_recording(const std::string& why) {
  if (!recorder_) return;
  if (!inputs_.list.empty())
    recorder_->attach({cli::kInputsFile, "application/jsonl", cli::to_text(inputs_)});
  const auto done = recorder_->finish(simulation_->status());
  recorder_.reset();
  if (!done) {
    publisher_.add_messages(
        {{simulation_->time(), Severity::error, "recording", done.error().text()}});
  } else if (!why.empty()) {
    publisher_.add_messages({{simulation_->time(), Severity::note, "recording",
                              "'" + recording_ + "' is written: " + why}});
  }
  recording_.clear();
}

}  // namespace cogrsim::studio
