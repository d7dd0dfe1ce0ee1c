// cogrsim run: one scene on one backend.
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "cogrsim/simulation/snapshot_file.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/progress.h"
#include "common/refuse.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "live/live.h"
#include "net/http.h"
#include "render/plots.h"
#include "run/inputs.h"
#include "run/recording_start.h"
#include "run/run_log.h"
#include "run/run_measures.h"
#include "run/run_result.h"
#include "watch/watch_link.h"
#include "watch/watch_uses.h"

namespace cogrsim::cli {
namespace {

// Runs to `duration`, and saves the requested snapshots. A time that is over or is never reached is
// reported.
RunStatus run_and_save(const RunOptions& options, Simulation& simulation, double duration,
                       Progress& progress, RunLog& run_log, RunResult& result, bool& saved_all) {
  RunStatus status = simulation.status();
  const auto complain = [&](const Error& error) {
    progress.finish();
    print_error(error.text());
    result.diagnostics.push_back(to_diagnostic(error));
    saved_all = false;
  };
  for (const RunOptions::Save& save : options.saves) {
    const auto at = [&](double time) {
      return std::fabs(simulation.time() - time) <= 0.5 * simulation.dt();
    };
    if (can_step(status) && save.time > simulation.time() && !at(save.time)) {
      status = run_log.run(std::min(save.time, duration));
    }
    if (!at(save.time)) {
      complain(Error(
          fmt::format("no snapshot '{}' at {}: the run {}", save.file, time_text(save.time),
                      save.time < simulation.time() ? "began later"
                                                    : "ended at " + time_text(simulation.time()))));
      continue;
    }
    if (const auto kept = write_snapshot(simulation, save.file, options.scene.set, output_rules());
        !kept) {
      complain(kept.error());
    }
  }
  if (!can_step(status) || simulation.paused()) return status;
  return run_log.run(duration);
}

bool good(RunStatus status) {
  return status == RunStatus::completed || status == RunStatus::stopped;
}

// Writes JSON and summary; `status` is the exit status unless writing fails.
int deliver(const RunOptions& options, const RunResult& result, int status) {
  const auto printed = print_found(
      options.json, [&] { return json_text(to_json(result)); },
      [&] {
        return result.frame ? summary_text(result, style_of(fileno(standard_output())))
                            : std::string();
      });
  return printed ? status : refuse(printed.error());
}

// The options of the snapshot's run hold for this one too, unless they are set otherwise.
void take_over(const SnapshotInfo& then, RunOptions& options) {
  if (options.backend.empty()) options.backend = then.backend;
  if (!options.scene.seed) options.scene.seed = then.seed;
  if (options.step == 0.0) options.step = then.step;
  for (const auto& setting : then.parameters) options.scene.set.insert(setting);
}

// From the start, or from a snapshot; what could not be carried over is reported.
tl::expected<std::unique_ptr<Simulation>, std::vector<Diagnostic>> make_simulation(
    const std::optional<SnapshotFile>& snapshot, const RunOptions& options,
    const LoadedScene& scene, const SimulationOptions& settings) {
  if (!snapshot) return Simulation::create(scene.model, settings, scene.loader);
  auto resumed = resume(*snapshot, scene.model, settings, scene.loader);
  if (!resumed) return tl::unexpected(resumed.error());
  for (const std::string& note : resumed->notes) print_warning(options.from + ": " + note);
  return std::move(resumed->simulation);
}

/// One run of a scene, from the options to the exit status.
class SceneRun {
 public:
  SceneRun(RunOptions options, WatchLink* watch) : options_(std::move(options)), watch_(watch) {}

  int run() {
    add_input(options_.scene.scene);
    if (!options_.from.empty()) add_input(options_.from);
    if (!options_.inputs.empty()) add_input(options_.inputs);
    const std::vector<std::pair<std::string, OutputKind>> outputs = {
        {options_.json, OutputKind::json}};
    if (const auto writable = check_writable(outputs); !writable) return refuse(writable.error());
    catch_interrupts();
    if (const auto failed = start()) return deliver(options_, result_, *failed);
    if (const auto writable = check_writable(outputs); !writable) return refuse(writable.error());
    if (const auto failed = attach_outputs()) return deliver(options_, result_, *failed);
    bool saved_all = true;
    const RunStatus status = simulate(saved_all);
    return finish(status, saved_all);
  }

 private:
  /// Prints an error and keeps it for the JSON.
  int fail_with(const Error& error) {
    print_error(error.text());
    result_.diagnostics.push_back(to_diagnostic(error));
    return kFailed;
  }

  /// Reads snapshot and scene and makes the simulation. Returns an exit status where that fails.
  std::optional<int> start() {
    result_.file = options_.scene.scene;
    result_.backend = options_.backend;
    if (!options_.from.empty()) {
      auto read = SnapshotFile::read(options_.from);
      if (!read) return fail_with(read.error());
      snapshot_ = std::move(*read);
      take_over(snapshot_->info(), options_);
    }
    if (!options_.inputs.empty()) {
      auto read = read_inputs(options_.inputs);
      if (!read) return fail_with(read.error());
      if (options_.backend.empty()) options_.backend = read->backend;
      if (options_.step == 0.0) options_.step = read->dt;
      if (!read->lost.empty())
        print_warning(options_.inputs + ": the run will not be the same: " + read->lost);
      if (options_.backend != read->backend)
        print_warning(options_.inputs + ": the inputs were given to a run on " + read->backend);
      inputs_.emplace(std::move(read->list));
    }
    scene_ = load_scene(options_.scene);
    if (watch_) watch_->depends_on(used_files(scene_, options_), scene_.model != nullptr);
    result_.diagnostics = scene_.diagnostics;
    print_diagnostics(result_.diagnostics);
    if (!scene_.model) return kFailed;
    result_.scene = scene_.model->name;

    const double step = options_.step > 0.0 ? options_.step : scene_.model->physics.step;
    // Who watches decides how long: a scene's duration is for runs by themselves.
    duration_ = options_.live && !options_.scene.duration
                    ? kLongestDuration
                    : duration_of(*scene_.model, options_.scene);
    if (const std::string problem = step_problem(step, duration_); !problem.empty()) {
      print_error(problem);
      result_.diagnostics.push_back(to_diagnostic(Error(problem.substr(0, problem.find('\n')))));
      return options_.step > 0.0 || options_.scene.duration ? kWrongUsage : kFailed;
    }
    SimulationOptions settings;
    settings.backend = options_.backend;
    settings.step = options_.step;
    settings.seed = options_.scene.seed;
    settings.speed = options_.speed;
    settings.without = options_.scene.without;
    for (const RunOptions::Save& save : options_.saves) {
      if (const auto writable = check_writable(save.file, OutputKind::snapshot); !writable) {
        print_error(writable.error().text());
        return kFailed;
      }
    }
    auto created = make_simulation(snapshot_, options_, scene_, settings);
    if (!created) {
      print_problems(created.error());
      result_.diagnostics.insert(result_.diagnostics.end(), created.error().begin(),
                                 created.error().end());
      return kFailed;
    }
    simulation_ = std::move(*created);
    result_.backend = simulation_->backend().name();
    if (watch_) watch_->depends_on(plugin_files(*scene_.loader, result_.backend), false);
    result_.engine_version = simulation_->backend().engine_version();
    result_.provenance = simulation_->provenance();
    result_.seed = simulation_->model()->physics.seed;
    result_.set = options_.scene.set;
    return std::nullopt;
  }

  /// Inputs, recording, plots and measures. Returns an exit status where one of them fails.
  std::optional<int> attach_outputs() {
    if (inputs_) {
      // Commands that are sent when a step is over take effect before the next one.
      simulation_->observe({}, [this](const FramePtr& frame) {
        inputs_->give(frame->step, [this](const Input& input) { simulation_->send(input.command); });
      });
    }
    if (wants_recording(*scene_.model, options_)) {
      auto recording = recorder_options(*scene_.model, options_);
      auto started = recording ? Recorder::start(*simulation_, std::move(*recording))
                               : tl::unexpected(recording.error());
      if (!started) return fail_with(started.error());
      recorder_ = std::move(*started);
    }
    if (options_.live) {
      if (const auto failed = start_live()) return failed;
    }
    if (!options_.plots.empty()) {
      auto attached = RunPlots::attach(*simulation_);
      if (!attached) return fail_with(attached.error());
      plots_ = std::move(*attached);
      if (plots_->empty()) print_warning("the scene has no plots, so --plots draws nothing");
    }
    if (!scene_.model->measures.empty()) {
      auto attached = RunMeasures::attach(*simulation_, scene_.model->measures);
      if (!attached) return fail_with(attached.error());
      measures_ = std::move(*attached);
      if (snapshot_ && simulation_->time() > 0.0)
        print_warning("measures count from " + time_text(simulation_->time()) +
                      " on: a snapshot does not hold what they saw before");
    }
    if (simulation_->time() > duration_ - 0.5 * simulation_->dt())
      print_warning(
          fmt::format("the snapshot is of {}, where the run ends; ask for a longer --duration",
                      time_text(simulation_->time())));
    return std::nullopt;
  }

  std::optional<int> start_live() {
    const RecordModel choices = scene_.model->record.value_or(RecordModel());
    StreamOptions stream;
    stream.contacts = choices.contacts;
    stream.images = choices.images;
    stream.jpeg = choices.jpeg;
    auto started =
        Live::start(*simulation_, *options_.live, stream, options_.speed, options_.scene.set);
    if (!started) return fail_with(started.error());
    live_ = std::move(*started);
    fmt::print(stderr, "live: {}\n", live_->address());
    if (!net::is_loopback(options_.live->host)) {
      print_warning(
          "others in the network reach this run: whoever does sees and may steer it, there is no "
          "password, and nothing is encrypted\n"
          "help: leave the address out and come by `ssh -L`");
    }
    return std::nullopt;
  }

  RunStatus simulate(bool& saved_all) {
    Progress progress(result_.backend, duration_);
    // With --json - the standard output is JSON alone.
    std::FILE* const printed = options_.json == "-" ? stderr : standard_output();
    RunLog run_log(*simulation_, progress, options_.events ? printed : nullptr,
                   !options_.json.empty(), live_.get());
    RunStatus status = RunStatus::running;
    {
      const InterruptStops stops(*simulation_);
      status =
          run_and_save(options_, *simulation_, duration_, progress, run_log, result_, saved_all);
      result_.wall_time = run_log.wall_time();
    }
    run_log.finish();
    live_.reset();
    if (inputs_ && inputs_->left() > 0)
      print_warning(fmt::format("{}: {} inputs are for later than the end of this run",
                                options_.inputs, inputs_->left()));
    if (inputs_ && inputs_->missed() > 0)
      print_warning(fmt::format("{}: {} inputs were left out: they are for steps that were over",
                                options_.inputs, inputs_->missed()));
    result_.messages = simulation_->messages();
    result_.events = run_log.events();
    result_.events_left_out = run_log.events_left_out();
    if (measures_) result_.measures = measures_->values();
    if (status != RunStatus::running) return status;
    if (!simulation_->paused()) return RunStatus::completed;
    result_.messages.push_back({simulation_->time(), Severity::warning, "cogrsim",
                                "the run was paused, and nothing can resume it"});
    print_message(result_.messages.back());
    return RunStatus::stopped;
  }

  int finish(RunStatus status, bool saved_all) {
    result_.status = to_string(status);
    result_.step = simulation_->dt();
    result_.steps = simulation_->step_count();
    result_.time = simulation_->time();
    result_.frame = simulation_->frame();
    // A controller that was stopped for its fault leaves no run to rely on, though the world kept
    // moving.
    const bool faulty =
        std::any_of(result_.messages.begin(), result_.messages.end(),
                    [](const RunMessage& message) { return message.severity == Severity::error; });
    int exit_status = good(status) && saved_all && !faulty ? kGood : kFailed;
    // Before the plots, which take long: it is kept if they are interrupted.
    if (recorder_)
      if (const auto finished = recorder_->finish(status); !finished)
        exit_status = fail_with(finished.error());
    // The result of a run that is about to be restarted is not needed.
    if (watch_ != nullptr && watch_->superseded()) return exit_status;
    if (plots_)
      if (const auto drawn = plots_->draw(options_.plots); !drawn)
        exit_status = fail_with(drawn.error());
    return deliver(options_, result_, exit_status);
  }

  RunOptions options_;
  WatchLink* watch_;
  RunResult result_;
  std::optional<SnapshotFile> snapshot_;
  std::optional<InputPlayer> inputs_;
  LoadedScene scene_;
  double duration_ = 0.0;  // [s]
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<Live> live_;
  std::optional<RunPlots> plots_;
  std::optional<RunMeasures> measures_;
};

}  // namespace

int run_command(const RunOptions& options) { return run_command(options, nullptr); }

int run_command(const RunOptions& options, WatchLink* watch) {
  return SceneRun(options, watch).run();
}

}  // namespace cogrsim::cli
