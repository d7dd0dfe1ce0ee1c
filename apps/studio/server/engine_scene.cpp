// Scenes and engines of the run, and continuing a run with other ones.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "cogrsim/simulation/snapshot_file.h"
#include "engine.h"
#include "engine_carry.h"

namespace cogrsim::studio {

namespace fs = std::filesystem;

namespace {

/// A folder that only this user can read, removed with this object.
class PrivateFolder {
 public:
  PrivateFolder() {
    std::error_code none;
    std::string wanted = (fs::temp_directory_path(none) / "cogrsim-studio-XXXXXX").string();
    if (!none && ::mkdtemp(wanted.data()) != nullptr) path_ = wanted;
  }
  ~PrivateFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  /// Empty: it could not be made.
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// The whole state of a run, from which it continues with another scene or engine.
Result<SnapshotFile> snapshot_of(const Simulation& simulation) {
  const PrivateFolder folder;
  if (folder.path().empty())
    return fail("there is no temporary folder to put the run's state into");
  const std::string file = (folder.path() / "state").string();
  if (auto written = write_snapshot(simulation, file); !written) {
    return tl::unexpected(written.error());
  }
  return SnapshotFile::read(file);
}

/// An edit may rename the scene; its state is still valid.
SceneModelPtr renamed(const SceneModelPtr& model, const std::string& name) {
  if (model->name == name) return model;
  auto copy = std::make_shared<SceneModel>(*model);
  copy->name = name;
  return copy;
}

bool of_another_scene(const std::string& note) {
  return note.rfind("the scene is not that of the snapshot", 0) == 0;
}

}  // namespace

SimulationOptions Engine::simulation_options() const {
  SimulationOptions options;
  options.backend = backend_;
  options.step = dt_.value_or(0.0);
  options.seed = options_.seed;
  options.isolation = options_.isolation;
  options.without = options_.without;
  return options;
}

Engine::Made Engine::make(const SceneModelPtr& model, const SimulationOptions& options) const {
  // Loaders are for one thread, and remember what they have loaded: a plugin that was rebuilt is
  // found by another one.
  return Simulation::create(model, options, std::make_shared<PluginLoader>(plugin_folders_));
}

void Engine::adopt(std::unique_ptr<Simulation> simulation) {
  end_recording("the run continues as another one");
  latest_.reset();
  simulation_ = std::move(simulation);
  provenance_ = std::make_shared<const Provenance>(simulation_->provenance());
  messages_seen_ = 0;
  latest_ = simulation_->frame();
  numbered_model_.reset();
  FrameContents contents;
  contents.contacts = true;
  simulation_->observe(contents, [this](const FramePtr& frame) { on_frame(frame); });
  tell_processes();
}

void Engine::forget_past() {
  publisher_.discard(history_.clear());
  publisher_.clear_events();
  last_kept_.reset();
  restarted_();
}

tl::expected<void, Refusal> Engine::begin_again(const Scene& scene, const std::string& backend,
                                                std::optional<double> dt,
                                                std::optional<CompareRequest> request) {
  SimulationOptions options = simulation_options();
  options.backend = backend;
  options.step = dt.value_or(0.0);
  auto made = make(scene.model, options);
  if (!made) return tl::unexpected(made.error());
  std::unique_ptr<SecondRun> ghost;
  if (request) {
    SimulationOptions other = options;
    if (request->backend) other.backend = *request->backend;
    if (request->step) other.step = *request->step;
    auto second = make(scene.model, other);
    if (!second) return tl::unexpected(second.error());
    if (!steps_meet((*made)->dt(), (*second)->dt())) {
      return tl::unexpected(Refusal{
          to_diagnostic(Error("the two steps have no time in common within 1000 of them", "",
                              "choose one that goes into the other, such as half of it"))});
    }
    ghost = std::make_unique<SecondRun>();
    ghost->request = *request;
    ghost->labels = labels_of(**made, **second);
    ghost->simulation = std::move(*second);
  }
  ghost_ = std::move(ghost);
  if (!scene_ || scene_->model != scene.model || !origins_) {
    origins_ = std::make_shared<const Origins>(scene.origins);
  }
  scene_ = scene;
  created_with_ = options;
  adopt(std::move(*made));
  forget_inputs();
  inputs_.backend = simulation_->backend().name();
  inputs_.dt = simulation_->dt();
  inputs_scene_ = scene.model;
  inputs_without_ = options.without;
  state_ = State::stopped;
  ending_.clear();
  end_reason_.clear();
  factor_ = 0.0;
  forget_past();
  take_instant(true);
  scenes_.forget();
  collect_messages();
  publish(true);
  return {};
}

tl::expected<std::vector<std::string>, Refusal> Engine::carry_over(const Scene& scene,
                                                                   const std::string& backend,
                                                                   bool anyway) {
  auto snapshot = snapshot_of(*simulation_);
  if (!snapshot) return tl::unexpected(Refusal{to_diagnostic(snapshot.error())});
  const SceneModelPtr model = renamed(scene.model, snapshot->info().scene);
  SimulationOptions options = simulation_options();
  options.backend = backend;
  const auto loader = [this] { return std::make_shared<PluginLoader>(plugin_folders_); };
  auto resumed = resume(*snapshot, model, options, loader());
  if (!resumed) return tl::unexpected(resumed.error());
  bool same_scene = resumed->same_scene;
  if (!same_scene && options.step != created_with_.step && options.backend == backend_) {
    // A step that was changed during the run makes it look like another scene.
    const auto as_then = resume(*snapshot, model, created_with_, loader());
    same_scene =
        as_then && as_then->same_scene && scene.model->physics.step == scene_->model->physics.step;
  }
  if (same_scene && !anyway) {
    // Comments or source positions: nothing that the run depends on, so it is not restarted.
    origins_ = std::make_shared<const Origins>(scene.origins);
    // Runs of the one are runs of the other.
    for (SceneModelPtr* of : {&inputs_scene_, &before_scene_})
      if (*of == scene_->model) *of = scene.model;
    scene_ = scene;
    numbered_model_.reset();
    same_lineage_ = true;
    take_instant(true);
    publish(true);
    return std::vector<std::string>();
  }
  std::vector<std::string> notes = std::move(resumed->notes);
  notes.erase(std::remove_if(notes.begin(), notes.end(), of_another_scene), notes.end());
  if (auto placed = place_edited(*resumed->simulation, *scene_->model, *scene.model); !placed) {
    notes.push_back("what was edited is not where it should be: " + placed.error().message);
  }
  if (!recording_.empty()) {
    notes.push_back("the recording '" + recording_ +
                    "' ends here: the run continues as another one");
  }
  if (scene_->model->physics.duration != scene.model->physics.duration) ending_.clear();
  if (!(scene_->model == scene.model)) {
    origins_ = std::make_shared<const Origins>(scene.origins);
  }
  scene_ = scene;
  created_with_ = options;
  // What a person gave since the last step waits in the run that ends here.
  std::vector<Command> waiting;
  for (const cli::Input& input : inputs_.list)
    if (input.step == simulation_->step_count()) waiting.push_back(input.command);
  adopt(std::move(resumed->simulation));
  for (const Command& command : waiting) simulation_->send(command);
  lose_inputs("the scene, its engine or its plugins were changed");
  anchor();
  take_instant(true);
  collect_messages();
  publish(true);
  return notes;
}

tl::expected<std::vector<std::string>, Refusal> Engine::show(Scene scene) {
  auto shown = take(scene);
  refused_.reset();
  // Another engine may run it.
  const auto by_engine = [](const Diagnostic& d) {
    return d.code == "CG0801" || d.code == "CG0802";
  };
  if (!shown && std::any_of(shown.error().begin(), shown.error().end(), by_engine))
    refused_ = std::move(scene);
  return shown;
}

tl::expected<std::vector<std::string>, Refusal> Engine::take(const Scene& scene) {
  settle();
  const bool new_plugins = !scene.plugin_folders.empty() && scene.plugin_folders != plugin_folders_;
  if (new_plugins) plugin_folders_ = scene.plugin_folders;
  const bool playing = state_ == State::playing;
  const bool begun = simulation_ && simulation_->step_count() > 0;
  if (begun && !ghost_ && state_ != State::ended) {
    return carry_over(scene, backend_.empty() ? std::string() : backend_, new_plugins);
  }
  std::vector<std::string> notes;
  if (begun) {
    notes.push_back(ghost_ ? "the comparison restarts"
                           : "the run restarts: it had ended (" + ending_ + ")");
  }
  const auto request = ghost_ ? std::optional<CompareRequest>(ghost_->request) : std::nullopt;
  if (auto done = begin_again(scene, backend_, dt_, request); !done) {
    return tl::unexpected(done.error());
  }
  if (playing) {
    // Cannot be refused: it has just been made.
    static_cast<void>(play());
  }
  return notes;
}

}  // namespace cogrsim::studio
