#include "compare/lockstep.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "common/progress.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "compare/shake.h"
#include "run/run_log.h"

namespace cogrsim::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kTrailPoints = 1000;  // of a robot's path, or a few more

struct Lane {
  std::unique_ptr<Simulation> simulation;
  std::string choice;  ///< as it was asked for
  RunEnd end;
};

std::string label_of(const std::string& choice, const std::vector<Lane>& lanes) {
  const auto before = std::count_if(lanes.begin(), lanes.end(),
                                    [&](const Lane& lane) { return lane.choice == choice; });
  return before == 0 ? choice : fmt::format("{} ({})", choice, before + 1);
}

Result<> shake_start(Simulation& simulation, const LockstepOptions& options, bool twin) {
  if (options.shake <= 0.0 && !twin) return {};
  WorldState state = simulation.frame()->state;
  const SceneModel& model = *simulation.model();
  int count = 0;
  if (options.shake > 0.0) count += shake(model, options.shake, options.shake_seed, state);
  // Another direction than that of all.
  if (twin) count += shake(model, options.twin, ~options.shake_seed, state);
  if (count == 0) {
    return fail("nothing in this scene can be shaken: no body or joint is free to move", "",
                "leave out --shake, --chaos and --seeds");
  }
  simulation.send(SetState{std::move(state)});
  return {};
}

tl::expected<std::vector<Lane>, std::vector<Diagnostic>> create_lanes(
    const SceneModelPtr& scene, const LockstepOptions& options,
    const std::shared_ptr<PluginLoader>& loader) {
  std::vector<Lane> lanes;
  std::vector<Diagnostic> problems;
  std::vector<std::string> backends = options.backends;
  if (options.twin > 0.0) backends.push_back(backends.front());
  for (std::size_t i = 0; i < backends.size(); ++i) {
    const std::string& backend = backends[i];
    const bool twin = i == options.backends.size();
    SimulationOptions settings;
    settings.backend = backend;
    settings.step = options.step;
    settings.seed = options.seed;
    settings.without = options.without;
    auto created = Simulation::create(scene, settings, loader);
    if (!created) {
      for (Diagnostic diagnostic : created.error()) {
        DiagnosticNote note;
        note.message = fmt::format("on backend '{}'", backend);
        diagnostic.notes.push_back(note);
        problems.push_back(std::move(diagnostic));
      }
      continue;
    }
    Lane lane;
    lane.simulation = std::move(*created);
    lane.end.backend = lane.simulation->backend().name();
    lane.end.engine_version = lane.simulation->backend().engine_version();
    lane.end.provenance = lane.simulation->provenance();
    lane.choice = backend;
    lane.end.label =
        twin ? fmt::format("{}, shaken by {}", lanes.front().end.label, length_text(options.twin))
             : label_of(backend, lanes);
    if (auto done = shake_start(*lane.simulation, options, twin); !done) {
      problems.push_back(to_diagnostic(done.error()));
      break;
    }
    lanes.push_back(std::move(lane));
  }
  if (!problems.empty()) return tl::unexpected(std::move(problems));
  return lanes;
}

// Step number `step` of every lane; why the comparison must end here, or "".
std::string step_all(std::vector<Lane>& lanes, std::uint64_t step) {
  std::string reason;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    // The first backend of a step has cold caches: they take turns.
    Lane& lane = lanes[(i + step) % lanes.size()];
    const auto start = Clock::now();
    const RunStatus status = lane.simulation->step();
    lane.end.wall_time += seconds_since(start);
    if (!can_step(status)) {
      reason = fmt::format("{}: {} at {:.9g} s", lane.end.label, to_string(status),
                           lane.simulation->time());
    } else if (lane.simulation->paused()) {
      reason = fmt::format("{}: paused at {:.9g} s, and nothing can resume it",
                           lane.end.label, lane.simulation->time());
    }
  }
  if (!reason.empty()) return reason;
  // A supervisor may restart its run or change the step, and then there is no common time.
  const Simulation& first = *lanes.front().simulation;
  for (const Lane& lane : lanes) {
    if (std::fabs(lane.simulation->time() - first.time()) > 1e-6 * first.dt()) {
      return fmt::format(
          "the clocks of {} and {} diverged at {:.9g} s: a supervisor restarted a "
          "run or changed its step",
          lanes.front().end.label, lane.end.label, first.time());
    }
  }
  return {};
}

std::vector<FramePtr> frames_of(std::vector<Lane>& lanes) {
  std::vector<FramePtr> frames;
  for (Lane& lane : lanes) frames.push_back(lane.simulation->frame());
  return frames;
}

}  // namespace

tl::expected<LockstepResult, std::vector<Diagnostic>> run_lockstep(
    const SceneModelPtr& scene, const LockstepOptions& options,
    const std::shared_ptr<PluginLoader>& loader) {
  auto created = create_lanes(scene, options, loader);
  if (!created) return tl::unexpected(std::move(created.error()));
  std::vector<Lane> lanes = std::move(*created);

  std::vector<std::string> labels;
  for (const Lane& lane : lanes) labels.push_back(lane.end.label);
  const double dt = lanes.front().simulation->dt();
  const auto steps = static_cast<std::uint64_t>(std::llround(options.duration / dt));
  Comparison comparison(labels, options.compare);

  LockstepResult result;
  if (options.trajectory_every > 0) result.trajectories.resize(lanes.size());
  const auto record = [&](std::uint64_t step, const std::vector<FramePtr>& frames) {
    if (options.trajectory_every == 0 || step % options.trajectory_every != 0) return;
    for (std::size_t i = 0; i < frames.size(); ++i) result.trajectories[i].add(*frames[i]);
  };

  std::vector<FramePtr> frames = frames_of(lanes);
  std::vector<Trails> trails;
  if (options.keep_frames) {
    for (const FramePtr& frame : frames) trails.push_back(*Trails::of(*frame->model, {}));
  }
  const std::uint64_t trail_every = std::max<std::uint64_t>(1, steps / kTrailPoints);
  const auto keep = [&](std::uint64_t step) {
    if (!options.keep_frames) return;
    if (result.divergence.empty() && comparison.diverged()) result.divergence = frames;
    if (step % trail_every != 0) return;
    for (std::size_t i = 0; i < frames.size(); ++i) trails[i].add(*frames[i]);
  };
  comparison.add(0.0, frames);
  record(0, frames);
  keep(0);
  for (std::uint64_t step = 1; step <= steps; ++step) {
    if (options.interrupted && options.interrupted()) {
      result.ended_early = "interrupted";
      break;
    }
    result.ended_early = step_all(lanes, step);
    if (!result.ended_early.empty()) break;
    frames = frames_of(lanes);
    comparison.add(frames.front()->time, frames);
    record(step, frames);
    keep(step);
    if (options.on_step) options.on_step(frames.front()->time);
  }

  if (options.keep_frames) result.last = std::move(frames);
  for (const Trails& each : trails) result.trails.push_back(each.trails());
  result.comparison = comparison.finish();
  for (Lane& lane : lanes) {
    RunEnd& end = lane.end;
    const Simulation& simulation = *lane.simulation;
    const bool all = result.ended_early.empty();
    end.status = simulation.status();
    // A run that was still going has come to the end asked for, or was ended with the others.
    if (can_step(end.status)) end.status = all ? RunStatus::completed : RunStatus::stopped;
    result.failed =
        result.failed || end.status == RunStatus::diverged || end.status == RunStatus::fault;
    end.step = simulation.dt();
    end.steps = simulation.step_count();
    end.time = simulation.time();
    end.hash = state_hash(lane.simulation->frame()->state);
    end.messages = simulation.messages();
    result.runs.push_back(std::move(end));
  }
  return result;
}

}  // namespace cogrsim::cli
