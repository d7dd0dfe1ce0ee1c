// cogrsim run: one scene on one backend.
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "cogrsim/simulation/snapshot_file.h"
#include "interrupt.h"
#include "narrator.h"
#include "options.h"
#include "output_file.h"
#include "plots.h"
#include "progress.h"
#include "recording_start.h"
#include "refuse.h"
#include "run_measures.h"
#include "run_result.h"
#include "scene_loading.h"
#include "terminal.h"
#include "watch_link.h"
#include "watch_uses.h"

namespace cogrsim::cli {
namespace {

using Clock = std::chrono::steady_clock;

// Runs to `duration` [s] in pieces short enough to redraw the progress line and to tell what came; a
// run is the same however it is chopped.
RunStatus run_with_progress(Simulation& simulation, double duration, Progress& progress,
                            Narrator& narrator, double& wall_time) {
  constexpr double kPiece = 0.05;  // aimed-at wall time of a piece [s]
  double steps = 1.0;
  RunStatus status = simulation.status();
  while (simulation.time() < duration - 0.5 * simulation.dt()) {
    const double end = std::min(duration, simulation.time() + steps * simulation.dt());
    const auto start = Clock::now();
    status = simulation.run_until(end);
    const double took = seconds_since(start);
    wall_time += took;
    narrator.tell_messages();
    progress.show(simulation.time());
    const bool goes_on = status == RunStatus::running || status == RunStatus::completed;
    // Nobody is there to resume a run that a supervisor paused.
    if (!goes_on || simulation.paused()) break;
    steps = std::max(1.0, std::floor(steps * std::clamp(kPiece / std::max(took, 1e-9), 0.25, 4.0)));
  }
  return status;
}

// Runs to `duration`, keeping the snapshots that were asked for on the way. A time that lies behind
// or is never reached is told.
RunStatus run_and_save(const RunOptions& options, Simulation& simulation, double duration,
                       Progress& progress, Narrator& narrator, RunResult& result, bool& saved_all) {
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
    const bool goes_on = status == RunStatus::running || status == RunStatus::completed;
    if (goes_on && save.time > simulation.time() && !at(save.time)) {
      status = run_with_progress(simulation, std::min(save.time, duration), progress, narrator,
                                 result.wall_time);
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
  const bool goes_on = status == RunStatus::running || status == RunStatus::completed;
  if (!goes_on || simulation.paused()) return status;
  return run_with_progress(simulation, duration, progress, narrator, result.wall_time);
}

bool good(RunStatus status) {
  return status == RunStatus::completed || status == RunStatus::stopped;
}

// Writes JSON and summary; `status` is the exit status unless writing fails.
int deliver(const RunOptions& options, const RunResult& result, int status) {
  if (!options.json.empty()) {
    if (const auto written =
            write_output(options.json, OutputKind::json, json_text(to_json(result)));
        !written) {
      return refuse(written.error());
    }
  }
  if (!result.frame) return status;
  if (options.json == "-") {
    std::fputs(summary_text(result, style_of(STDERR_FILENO)).c_str(), stderr);
    return status;
  }
  if (const auto printed = print_output(summary_text(result, style_of(fileno(standard_output()))));
      !printed) {
    return refuse(printed.error());
  }
  return status;
}

// What the snapshot's run was told holds for this one too, unless it is told otherwise.
void take_over(const SnapshotInfo& then, RunOptions& options) {
  if (options.backend.empty()) options.backend = then.backend;
  if (!options.scene.seed) options.scene.seed = then.seed;
  if (options.step == 0.0) options.step = then.step;
  for (const auto& setting : then.parameters) options.scene.set.insert(setting);
}

// From the start, or from a snapshot; what could not be carried over is told.
tl::expected<std::unique_ptr<Simulation>, std::vector<Diagnostic>> make_simulation(
    const std::optional<SnapshotFile>& snapshot, const RunOptions& options,
    const LoadedScene& scene, const SimulationOptions& settings) {
  if (!snapshot) return Simulation::create(scene.model, settings, scene.loader);
  auto resumed = resume(*snapshot, scene.model, settings, scene.loader);
  if (!resumed) return tl::unexpected(resumed.error());
  for (const std::string& note : resumed->notes) print_warning(options.from + ": " + note);
  return std::move(resumed->simulation);
}

}  // namespace

int run_command(const RunOptions& options) { return run_command(options, nullptr); }

int run_command(const RunOptions& given, WatchLink* watcher) {
  RunOptions options = given;
  add_input(options.scene.scene);
  if (!options.from.empty()) add_input(options.from);
  if (!options.json.empty()) {
    if (const auto writable = check_writable(options.json, OutputKind::json); !writable) {
      return refuse(writable.error());
    }
  }
  catch_interrupts();

  RunResult result;
  result.file = options.scene.scene;
  result.backend = options.backend;
  std::optional<SnapshotFile> snapshot;
  if (!options.from.empty()) {
    auto read = SnapshotFile::read(options.from);
    if (!read) {
      print_error(read.error().text());
      result.diagnostics.push_back(to_diagnostic(read.error()));
      return deliver(options, result, kFailed);
    }
    snapshot = std::move(*read);
    take_over(snapshot->info(), options);
  }
  LoadedScene scene = load_scene(options.scene);
  if (watcher) watcher->rests_on(used_files(scene, options), scene.model != nullptr);
  result.diagnostics = scene.diagnostics;
  print_diagnostics(result.diagnostics);
  if (!scene.model) return deliver(options, result, kFailed);
  result.scene = scene.model->name;

  const double step = options.step > 0.0 ? options.step : scene.model->physics.step;
  const double duration = duration_of(*scene.model, options.scene);
  if (const std::string problem = step_problem(step, duration); !problem.empty()) {
    print_error(problem);
    result.diagnostics.push_back(to_diagnostic(Error(problem.substr(0, problem.find('\n')))));
    const bool asked = options.step > 0.0 || options.scene.duration;
    return deliver(options, result, asked ? kWrongUsage : kFailed);
  }

  SimulationOptions settings;
  settings.backend = options.backend;
  settings.step = options.step;
  settings.seed = options.scene.seed;
  settings.speed = options.speed;
  for (const RunOptions::Save& save : options.saves) {
    if (const auto writable = check_writable(save.file, OutputKind::snapshot); !writable) {
      print_error(writable.error().text());
      return deliver(options, result, kFailed);
    }
  }
  auto created = make_simulation(snapshot, options, scene, settings);
  if (!created) {
    std::vector<Diagnostic> coded;
    for (const Diagnostic& d : created.error()) {
      if (d.code.empty()) {
        print_error(Error(d.message, "", d.help).text());
      } else {
        coded.push_back(d);
      }
    }
    print_diagnostics(coded);
    result.diagnostics.insert(result.diagnostics.end(), created.error().begin(),
                              created.error().end());
    return deliver(options, result, kFailed);
  }
  Simulation& simulation = **created;
  result.backend = simulation.backend().name();
  if (watcher) watcher->rests_on(plugin_files(*scene.loader, result.backend), false);
  result.engine_version = simulation.backend().engine_version();
  result.provenance = simulation.provenance();
  result.seed = simulation.model()->physics.seed;
  result.set = options.scene.set;

  std::unique_ptr<Recorder> recorder;
  if (wants_recording(*scene.model, options)) {
    auto recording = recorder_options(*scene.model, options);
    auto started = recording ? Recorder::start(simulation, std::move(*recording))
                             : tl::unexpected(recording.error());
    if (!started) {
      print_error(started.error().text());
      result.diagnostics.push_back(to_diagnostic(started.error()));
      return deliver(options, result, kFailed);
    }
    recorder = std::move(*started);
  }

  std::optional<RunPlots> plots;
  if (!options.plots.empty()) {
    auto attached = RunPlots::attach(simulation);
    if (!attached) {
      print_error(attached.error().text());
      result.diagnostics.push_back(to_diagnostic(attached.error()));
      return deliver(options, result, kFailed);
    }
    plots = std::move(*attached);
    if (plots->empty()) print_warning("the scene has no plots, so --plots draws nothing");
  }

  std::optional<RunMeasures> measures;
  if (!scene.model->measures.empty()) {
    auto attached = RunMeasures::attach(simulation, scene.model->measures);
    if (!attached) {
      print_error(attached.error().text());
      result.diagnostics.push_back(to_diagnostic(attached.error()));
      return deliver(options, result, kFailed);
    }
    measures = std::move(*attached);
    if (snapshot && simulation.time() > 0.0) {
      print_warning("measures count from " + time_text(simulation.time()) +
                    " on: a snapshot does not hold what they saw before");
    }
  }

  if (simulation.time() > duration - 0.5 * simulation.dt()) {
    print_warning(
        fmt::format("the snapshot is of {}, where the run ends; ask for a longer "
                    "--duration",
                    time_text(simulation.time())));
  }
  bool saved_all = true;
  RunStatus status = RunStatus::running;
  Progress progress(result.backend, duration);
  // With --json - the standard output is JSON alone.
  std::FILE* const told = options.json == "-" ? stderr : standard_output();
  Narrator narrator(simulation, progress, options.events ? told : nullptr, !options.json.empty());
  {
    const InterruptStops stops(simulation);
    status = run_and_save(options, simulation, duration, progress, narrator, result, saved_all);
  }
  narrator.finish();
  result.messages = simulation.messages();
  result.events = narrator.events();
  result.events_left_out = narrator.events_left_out();
  if (measures) result.measures = measures->values();
  if (status == RunStatus::running) {
    if (simulation.paused()) {
      status = RunStatus::stopped;
      result.messages.push_back({simulation.time(), Severity::advice, "cogrsim",
                                 "the run was paused, and nobody is here to resume it"});
      print_message(result.messages.back());
    } else {
      status = RunStatus::completed;
    }
  }
  result.status = to_string(status);
  result.step = simulation.dt();
  result.steps = simulation.step_count();
  result.time = simulation.time();
  result.frame = simulation.frame();
  // A controller that was stopped for its fault leaves no run to rely on, though the world went on.
  const bool faulty =
      std::any_of(result.messages.begin(), result.messages.end(),
                  [](const RunMessage& message) { return message.severity == Severity::error; });
  int exit_status = good(status) && saved_all && !faulty ? kGood : kFailed;
  // Before the plots, which take their time: whoever interrupts them keeps it.
  if (recorder) {
    if (const auto finished = recorder->finish(status); !finished) {
      print_error(finished.error().text());
      result.diagnostics.push_back(to_diagnostic(finished.error()));
      exit_status = kFailed;
    }
  }
  // Nobody waits for the result of a run that is about to start anew.
  const bool superseded = watcher != nullptr && watcher->superseded();
  if (plots && !superseded) {
    if (const auto drawn = plots->draw(options.plots); !drawn) {
      print_error(drawn.error().text());
      result.diagnostics.push_back(to_diagnostic(drawn.error()));
      exit_status = kFailed;
    }
  }
  return superseded ? exit_status : deliver(options, result, exit_status);
}

}  // namespace cogrsim::cli
