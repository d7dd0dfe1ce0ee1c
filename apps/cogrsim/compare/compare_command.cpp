// cogrsim compare: one scene on several backends, side by side.
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "cogrsim/physics/backend.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/progress.h"
#include "common/refuse.h"
#include "common/scene_loading.h"
#include "compare/compare_output.h"

namespace cogrsim::cli {
namespace {

// With steps that share instants runs can be compared with each other: all must divide the largest.
std::string steps_problem(const std::vector<double>& steps) {
  const double largest = *std::max_element(steps.begin(), steps.end());
  for (const double step : steps) {
    const double ratio = largest / step;
    if (std::fabs(ratio - std::round(ratio)) > 1e-6) {
      return fmt::format(
          "step {} does not divide {} evenly\n"
          "help: for convergence choose steps such as --step 4ms --step 2ms --step 1ms",
          step_text(step), step_text(largest));
    }
  }
  return {};
}

// The backends asked for, else those in libraries; of such lists the scene's own comes first.
std::vector<std::string> chosen_backends(const CompareCommandOptions& options, LoadedScene& scene) {
  const bool all = options.backends == std::vector<std::string>{"all"};
  std::vector<std::string> names = options.backends.empty()
                                       ? library_backends(scene.loader)
                                       : expand_all(options.backends, options.scene.without, scene);
  if (!options.backends.empty() && !all) return names;
  const auto own = std::find(names.begin(), names.end(), scene.model->physics.backend);
  if (own != names.end()) std::rotate(names.begin(), own, own + 1);
  return names;
}

// Curves cost memory per body; a large scene gets coarser ones.
int curve_points(const SceneModel& model) {
  const auto elements = std::max<std::size_t>(1, model.bodies.size() + model.joints.size());
  return static_cast<int>(std::clamp<std::size_t>(500000 / elements, 20, 300));
}

// Instants at which convergence compares positions: fewer of a large scene.
double trajectory_instants(const SceneModel& model) {
  const auto bodies = std::max<std::size_t>(1, model.bodies.size());
  return static_cast<double>(std::clamp<std::size_t>(200000 / bodies, 10, 200));
}

constexpr double kTwin = 1e-9;  // [m, rad]

// Runs the scene with every seed; the first one's result is the comparison that is shown.
bool run_seeds(const CompareCommandOptions& options, const LoadedScene& scene,
               LockstepOptions lockstep, CompareReport& report) {
  const std::vector<std::uint64_t> seeds =
      options.seeds.empty() ? std::vector<std::uint64_t>{report.seed} : options.seeds;
  CompareStatistics statistics(options.shake);
  Progress progress("compare", report.duration * static_cast<double>(seeds.size()));
  for (std::size_t i = 0; i < seeds.size() && !interrupted(); ++i) {
    lockstep.seed = lockstep.shake_seed = seeds[i];
    lockstep.keep_frames = i == 0 && !options.report.empty();
    lockstep.on_step = [&](double time) {
      progress.show(report.duration * static_cast<double>(i) + time);
    };
    auto result = run_lockstep(scene.model, lockstep, scene.loader);
    if (!result) {
      progress.finish();
      print_diagnostics(result.error());
      report.diagnostics.insert(report.diagnostics.end(), result.error().begin(),
                                result.error().end());
      return false;
    }
    // An interrupted repetition does not count; the first one is shown as far as it came.
    if (!interrupted() || i == 0) statistics.add(seeds[i], *result);
    if (i == 0) report.result = std::move(*result);
  }
  progress.finish();
  report.study = statistics.finish();
  return true;
}

// Runs the scene at every step; the first one's result is the comparison.
bool run_all(const CompareCommandOptions& options, const LoadedScene& scene,
             CompareReport& report) {
  std::vector<double> steps = options.steps;
  if (steps.empty()) steps.push_back(scene.model->physics.step);
  const bool converge = steps.size() > 1;
  const double largest = *std::max_element(steps.begin(), steps.end());
  const double stride =
      std::max(1.0, std::floor(report.duration / largest / trajectory_instants(*scene.model)));

  LockstepOptions lockstep;
  lockstep.backends = report.backends;
  lockstep.duration = report.duration;
  lockstep.seed = options.scene.seed;
  lockstep.without = options.scene.without;
  lockstep.compare.position_threshold = options.position_threshold;
  lockstep.compare.angle_threshold = options.angle_threshold;
  lockstep.compare.curve_points = curve_points(*scene.model);
  lockstep.interrupted = interrupted;
  lockstep.shake = options.shake;
  lockstep.shake_seed = report.seed;
  lockstep.twin = report.twin;
  lockstep.compare.twins = report.twin > 0.0 ? 1 : 0;
  lockstep.step = steps.front();
  if (!converge) return run_seeds(options, scene, lockstep, report);

  std::vector<std::pair<double, std::vector<Trajectory>>> trajectories;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    Progress progress(fmt::format("compare, step {}", step_text(steps[i])), report.duration);
    lockstep.step = steps[i];
    lockstep.trajectory_every =
        static_cast<std::uint64_t>(std::llround(largest / steps[i] * stride));
    lockstep.keep_frames = i == 0 && !options.report.empty();
    lockstep.on_step = [&](double time) { progress.show(time); };
    auto result = run_lockstep(scene.model, lockstep, scene.loader);
    progress.finish();
    if (!result) {
      print_diagnostics(result.error());
      report.diagnostics.insert(report.diagnostics.end(), result.error().begin(),
                                result.error().end());
      return false;
    }
    trajectories.emplace_back(steps[i], std::move(result->trajectories));
    if (i == 0) {
      CompareStatistics statistics(options.shake);
      statistics.add(report.seed, *result);
      report.study = statistics.finish();
      report.result = std::move(*result);
    }
    if (interrupted()) break;
  }
  if (trajectories.size() < 2) return true;
  std::sort(trajectories.begin(), trajectories.end(),
            [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<double> sorted;
  std::vector<std::vector<Trajectory>> runs;
  for (auto& [step, lanes] : trajectories) {
    sorted.push_back(step);
    runs.push_back(std::move(lanes));
  }
  report.convergence = convergence(report.result->comparison.runs, sorted, runs);
  return true;
}

std::string status_of(const LockstepResult& result) {
  // The gravest of all runs.
  RunStatus worst = RunStatus::completed;
  for (const RunEnd& run : result.runs) worst = std::max(worst, run.status);
  return to_string(worst);
}

int deliver(const CompareCommandOptions& options, const CompareReport& report, int status) {
  const auto check = [&](const Result<>& done) {
    if (done) return;
    print_error(done.error().text());
    status = kFailed;
  };
  if (!options.json.empty())
    check(write_output(options.json, OutputKind::json, json_text(to_json(report))));
  if (!report.result) return status;
  if (!options.report.empty())
    check(write_output(options.report, OutputKind::html, compare_html(report)));
  if (!options.table.empty()) {
    const bool latex = std::filesystem::path(options.table).extension() == ".tex";
    const TableFormat format = latex ? TableFormat::latex : TableFormat::markdown;
    check(write_output(options.table, OutputKind::text_table,
                       compare_table(report, format, options.rows)));
  }
  if (options.json != "-" && options.report != "-")
    check(print_report(compare_text(report, options.rows, style_of(fileno(standard_output())))));
  return status;
}

}  // namespace

int compare_command(const CompareCommandOptions& options) {
  add_input(options.scene.scene);
  for (const auto& [path, kind] :
       {std::pair(options.json, OutputKind::json), std::pair(options.report, OutputKind::html),
        std::pair(options.table, OutputKind::text_table)}) {
    if (path.empty()) continue;
    if (const auto writable = check_writable(path, kind); !writable) {
      return refuse(writable.error());
    }
  }
  if (!options.steps.empty()) {
    if (const std::string problem = steps_problem(options.steps); !problem.empty()) {
      print_error(problem);
      return kWrongUsage;
    }
  }
  catch_interrupts();

  CompareReport report;
  report.file = options.scene.scene;
  report.backends = options.backends;
  LoadedScene scene = load_scene(options.scene);
  report.diagnostics = scene.diagnostics;
  print_diagnostics(report.diagnostics);
  if (!scene.model) return deliver(options, report, kFailed);
  report.scene = scene.model->name;
  report.duration = duration_of(*scene.model, options.scene);
  report.seed = options.scene.seed.value_or(scene.model->physics.seed);
  report.set = options.scene.set;
  if (!options.seeds.empty()) report.seed = options.seeds.front();
  if (options.chaos || options.shake > 0.0 || options.seeds.size() > 1) report.twin = kTwin;
  report.backends = chosen_backends(options, scene);
  report.diagnostics = scene.diagnostics;
  if (report.backends.size() < 2) {
    const std::string problem =
        fmt::format("a comparison needs two backends, found {}",
                    report.backends.empty() ? "none" : "only '" + report.backends.front() + "'");
    print_error(problem + "\nhelp: name them with --backends A,B; cogrsim plugins lists them");
    report.diagnostics.push_back(to_diagnostic(Error(problem)));
    return deliver(options, report, kFailed);
  }
  const double step = options.steps.empty()
                          ? scene.model->physics.step
                          : *std::max_element(options.steps.begin(), options.steps.end());
  if (const std::string problem = step_problem(step, report.duration); !problem.empty()) {
    print_error(problem);
    report.diagnostics.push_back(to_diagnostic(Error(problem.substr(0, problem.find('\n')))));
    const bool asked = !options.steps.empty() || options.scene.duration;
    return deliver(options, report, asked ? kWrongUsage : kFailed);
  }

  if (!run_all(options, scene, report)) return deliver(options, report, kFailed);
  report.status = status_of(*report.result);
  if (!options.report.empty()) report.pictures = report_pictures(*report.result, *scene.loader);
  for (const RunEnd& run : report.result->runs) print_messages(run.messages, run.label);
  return deliver(options, report, report.result->failed ? kFailed : kGood);
}

}  // namespace cogrsim::cli
