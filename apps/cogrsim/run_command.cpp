// cogrsim run: one scene on one backend.
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "interrupt.h"
#include "options.h"
#include "output_file.h"
#include "plots.h"
#include "progress.h"
#include "recording_start.h"
#include "run_result.h"
#include "scene_loading.h"
#include "terminal.h"

namespace cogrsim::cli {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Runs to `duration` [s] in pieces short enough to redraw the progress line; a run is the same
// however it is chopped. Without a terminal there is one piece.
RunStatus run_with_progress(Simulation& simulation, double duration, Progress& progress,
                            double& wall_time) {
  constexpr double kPiece = 0.05;  // aimed-at wall time of a piece [s]
  double steps = progress.shown() ? 1.0 : std::numeric_limits<double>::infinity();
  RunStatus status = simulation.status();
  while (simulation.time() < duration - 0.5 * simulation.dt()) {
    const double end = std::min(duration, simulation.time() + steps * simulation.dt());
    const auto start = Clock::now();
    status = simulation.run_until(end);
    const double took = seconds_since(start);
    wall_time += took;
    progress.show(simulation.time());
    const bool goes_on = status == RunStatus::running || status == RunStatus::completed;
    // Nobody is there to resume a run that a supervisor paused.
    if (!goes_on || simulation.paused()) break;
    steps = std::max(1.0, std::floor(steps * std::clamp(kPiece / std::max(took, 1e-9), 0.25, 4.0)));
  }
  return status;
}

bool good(RunStatus status) {
  return status == RunStatus::completed || status == RunStatus::stopped;
}

// Writes JSON and summary; `status` is the exit status unless writing fails.
int deliver(const RunOptions& options, const RunResult& result, int status) {
  if (!options.json.empty()) {
    if (const auto written = write_output(options.json, json_text(to_json(result))); !written) {
      print_error(written.error().text());
      return kFailed;
    }
  }
  if (!result.frame) return status;
  if (options.json == "-") {
    std::fputs(summary_text(result, style_of(STDERR_FILENO)).c_str(), stderr);
    return status;
  }
  if (const auto printed = print_output(summary_text(result, style_of(STDOUT_FILENO))); !printed) {
    print_error(printed.error().text());
    return kFailed;
  }
  return status;
}

}  // namespace

int run_command(const RunOptions& options) {
  if (!options.json.empty()) {
    if (const auto writable = check_writable(options.json); !writable) {
      print_error(writable.error().text());
      return kFailed;
    }
  }
  catch_interrupts();

  RunResult result;
  result.file = options.scene.scene;
  result.backend = options.backend;
  LoadedScene scene = load_scene(options.scene);
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
  auto created = Simulation::create(scene.model, settings, scene.loader);
  if (!created) {
    print_diagnostics(created.error());
    result.diagnostics.insert(result.diagnostics.end(), created.error().begin(),
                              created.error().end());
    return deliver(options, result, kFailed);
  }
  Simulation& simulation = **created;
  result.backend = simulation.backend().name();
  result.engine_version = simulation.backend().engine_version();

  std::unique_ptr<Recorder> recorder;
  if (wants_recording(*scene.model, options)) {
    auto started = Recorder::start(simulation, recorder_options(*scene.model, options));
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

  RunStatus status = RunStatus::running;
  {
    const InterruptStops stops(simulation);
    Progress progress(result.backend, duration);
    status = run_with_progress(simulation, duration, progress, result.wall_time);
  }
  result.messages = simulation.messages();
  if (status == RunStatus::running) {
    if (simulation.paused()) {
      status = RunStatus::stopped;
      result.messages.push_back({simulation.time(), Severity::advice, "cogrsim",
                                 "the run was paused, and nobody is here to resume it"});
    } else {
      status = RunStatus::completed;
    }
  }
  result.status = to_string(status);
  result.step = simulation.dt();
  result.steps = simulation.step_count();
  result.time = simulation.time();
  result.frame = simulation.frame();
  print_messages(result.messages);
  int exit_status = good(status) ? kGood : kFailed;
  if (plots) {
    if (const auto drawn = plots->draw(options.plots); !drawn) {
      print_error(drawn.error().text());
      result.diagnostics.push_back(to_diagnostic(drawn.error()));
      exit_status = kFailed;
    }
  }
  if (recorder) {
    if (const auto finished = recorder->finish(status); !finished) {
      print_error(finished.error().text());
      result.diagnostics.push_back(to_diagnostic(finished.error()));
      exit_status = kFailed;
    }
  }
  return deliver(options, result, exit_status);
}

}  // namespace cogrsim::cli
