#include "render/frames.h"

#include <unistd.h>
#include <algorithm>

#include <fmt/format.h>

#include "cogrsim/recording/recording.h"
#include "common/interrupt.h"
#include "common/progress.h"
#include "common/scene_loading.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

class RecordedFrames final : public FrameSource {
 public:
  RecordedFrames(std::unique_ptr<Recording> recording, std::vector<std::string> plugin_paths)
      : recording_(std::move(recording)), loader_(std::move(plugin_paths)) {}

  std::string name() const override { return recording_->info().scene; }
  std::string backend() const override { return recording_->info().backend; }
  double end() const override { return recording_->info().end; }
  Result<FramePtr> at(double time) override {
    if (interrupted()) return nothing_written();
    // A frame counts as reached a millionth of a step early: times are read in decimals.
    return recording_->frame(recording_->index_at(time + 1e-6 * recording_->info().step));
  }
  const std::vector<Channel>& channels(int sensor) const override {
    return recording_->channels(sensor);
  }
  PluginLoader& loader() override { return loader_; }

 private:
  std::unique_ptr<Recording> recording_;
  PluginLoader loader_;
};

class RunFrames final : public FrameSource {
 public:
  RunFrames(LoadedScene scene, std::unique_ptr<Simulation> simulation, double duration)
      : scene_(std::move(scene)),
        simulation_(std::move(simulation)),
        duration_(duration),
        stops_(*simulation_),
        progress_(simulation_->backend().name(), duration) {}

  std::string name() const override { return scene_.model->name; }
  std::string backend() const override { return simulation_->backend().name(); }
  double end() const override { return duration_; }
  Result<FramePtr> at(double time) override {
    while (simulation_->time() + 0.5 * simulation_->dt() < time) {
      // In pieces, so that the progress line moves.
      const double next = std::min(time, simulation_->time() + 100.0 * simulation_->dt());
      const RunStatus status = simulation_->run_until(next);
      progress_.show(simulation_->time());
      if (status != RunStatus::completed || simulation_->paused()) {
        progress_.finish();
        print_messages(simulation_->messages());
        return fail(fmt::format("the run ended at {} ({}), before {}",
                                time_text(simulation_->time()), to_string(simulation_->status()),
                                time_text(time)));
      }
    }
    return simulation_->frame();
  }
  const std::vector<Channel>& channels(int sensor) const override {
    return simulation_->channels(sensor);
  }
  PluginLoader& loader() override { return *scene_.loader; }

 private:
  LoadedScene scene_;
  std::unique_ptr<Simulation> simulation_;
  double duration_;
  InterruptStops stops_;
  Progress progress_;
};

}  // namespace

bool is_recording(const std::string& path) {
  const std::string ending = ".mcap";
  return path.size() >= ending.size() &&
         path.compare(path.size() - ending.size(), ending.size(), ending) == 0;
}

std::unique_ptr<FrameSource> FrameSource::open(const FrameSourceOptions& options, int& status) {
  status = kFailed;
  const SceneOptions& source = options.source;
  catch_interrupts();
  if (is_recording(source.scene)) {
    const bool meant_for_scenes = !options.backend.empty() || options.step > 0.0 || source.seed ||
                                  !source.set.empty() || source.duration || !source.without.empty();
    if (meant_for_scenes) {
      print_error(
          "--backend, --step, --seed, --set, --duration and --without are for scenes; a recording "
          "has its own"
          "\nhelp: leave them out, or name the scene instead of the recording");
      status = kWrongUsage;
      return nullptr;
    }
    auto recording = Recording::open(source.scene);
    if (!recording) {
      print_error(recording.error().text());
      return nullptr;
    }
    if (const std::string& damage = (*recording)->info().damage; !damage.empty()) {
      print_warning(fmt::format("{}: {}; using what is readable, up to {}", source.scene,
                                damage, time_text((*recording)->info().end)));
    }
    status = kGood;
    return std::make_unique<RecordedFrames>(std::move(*recording), source.plugin_paths);
  }

  LoadedScene scene = load_scene(source);
  print_diagnostics(scene.diagnostics);
  if (!scene.model) return nullptr;
  SimulationOptions settings;
  settings.backend = options.backend;
  settings.step = options.step;
  settings.seed = source.seed;
  settings.without = source.without;
  auto simulation = Simulation::create(scene.model, settings, scene.loader);
  if (!simulation) {
    print_diagnostics(simulation.error());
    return nullptr;
  }
  status = kGood;
  const double duration = duration_of(*scene.model, source);
  return std::make_unique<RunFrames>(std::move(scene), std::move(*simulation), duration);
}

}  // namespace cogrsim::cli
