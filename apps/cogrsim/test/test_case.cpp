#include "test/test_case.h"

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <thread>

#include <fmt/format.h>

#include "cogrsim/recording/recording.h"
#include "cogrsim/testing/judge.h"
#include "common/case_pool.h"
#include "common/interrupt.h"
#include "common/model_names.h"
#include "common/output_file.h"
#include "common/scene_loading.h"
#include "run/recording_start.h"
#include "run/run_log.h"

namespace cogrsim::cli {
namespace {

using Runs = std::vector<std::unique_ptr<Simulation>>;

std::string findings(const std::vector<Diagnostic>& diagnostics) {
  return diagnostics_text(diagnostics, false);
}

tl::expected<Runs, std::string> create(const LoadedScene& scene, const Json& input) {
  Runs runs;
  for (const Json& backend : input["backends"]) {
    SimulationOptions options;
    options.backend = backend.get<std::string>();
    if (!input["seed"].is_null()) options.seed = input["seed"].get<std::uint64_t>();
    options.without = input["without"].get<std::vector<std::string>>();
    auto made = Simulation::create(scene.model, options, scene.loader);
    if (!made) return tl::unexpected(findings(made.error()));
    runs.push_back(std::move(*made));
  }
  return runs;
}

// Why a run that ended before its time did so against its will; empty: it did not.
std::string bad_end(const Simulation& run) {
  if (run.status() == RunStatus::diverged || run.status() == RunStatus::fault) {
    std::string why = to_string(run.status());
    for (const RunMessage& message : run.messages())
      if (message.severity == Severity::error)
        return why + ", " + (message.source.empty() ? "" : message.source + ": ") + message.message;
    return why;
  }
  if (run.paused()) return "paused, and nothing can resume it";
  return {};
}

// Faults of runs that the test does not check, such as a stopped controller.
Json errors_of(const Runs& runs) {
  Json errors = Json::array();
  for (const auto& run : runs) {
    MessageBudget budget;
    const std::string which = runs.size() > 1 ? run->backend().name() : "";
    for (const RunMessage& message : run->messages())
      if (message.severity == Severity::error && budget.takes(message))
        errors.push_back(message_text(message, which));
    if (budget.left_out() > 0)
      errors.push_back(fmt::format("and {} more{}, see cogrsim run --json", budget.left_out(),
                                   which.empty() ? "" : " on " + which));
  }
  return errors;
}

// All runs step by step, together; why one of them ended badly.
std::string run_all(const Runs& runs, double duration,
                    const std::function<bool(const std::vector<FramePtr>&)>& see) {
  const auto frames = [&] {
    std::vector<FramePtr> out;
    for (const auto& run : runs) out.push_back(run->frame());
    return out;
  };
  if (see(frames())) return {};
  while (runs.front()->time() < duration - 0.5 * runs.front()->dt()) {
    bool ended = false;
    for (const auto& run : runs) {
      const RunStatus status = run->step();
      if (const std::string why = bad_end(*run); !why.empty())
        return runs.size() > 1 ? std::string(run->backend().name()) + " " + why : why;
      ended = ended || !can_step(status);
    }
    if (see(frames()) || ended) return {};
  }
  return {};
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json to_json(const Verdict& verdict, const SceneModel& model) {
  Json out;
  out["expectation"] = verdict.expectation;
  out["passed"] = verdict.passed;
  out["message"] = verdict.message;
  out["time"] = number(verdict.time);
  const auto file = static_cast<std::size_t>(verdict.origin.file);
  out["file"] = verdict.origin.line > 0 && file < model.files.size() ? Json(model.files[file])
                                                                     : Json(nullptr);
  out["line"] = verdict.origin.line;
  out["column"] = verdict.origin.column;
  out["columns"] = verdict.columns;
  out["samples"] = Json::array();
  for (const Verdict::Sample& sample : verdict.samples) {
    Json values = Json::array();
    for (const double value : sample.values) values.push_back(number(value));
    out["samples"].push_back(
        {{"time", sample.time}, {"values", values}, {"decisive", sample.decisive}});
  }
  out["text"] = to_text(verdict, model);
  return out;
}

// The same run again, kept on file: a run is the same every time. `problem`: why there is none.
Json record_again(const LoadedScene& scene, const Json& input, double duration,
                  std::string& problem) {
  Json files = Json::array();
  const auto path = input["recording"].get<std::string>();
  if (path.empty()) return files;
  auto runs = create(scene, input);
  if (!runs) return files;
  catch_interrupts();
  for (const auto& run : *runs) {
    if (interrupted()) return files;
    RunOptions options;
    options.scene.scene = input["scene"].get<std::string>();
    options.scene.set = input["set"].get<std::map<std::string, std::string>>();
    options.record = path +
                     (runs->size() > 1 ? std::string(".") + run->backend().name() : std::string()) +
                     ".mcap";
    auto recorder = Recorder::start(*run, *recorder_options(*scene.model, options));
    if (!recorder) {
      problem = recorder.error().text();
      continue;
    }
    RunStatus status = RunStatus::running;
    {
      const InterruptStops stops(*run);
      status = run->run_until(duration);
    }
    const auto finished = (*recorder)->finish(status);
    if (finished) {
      files.push_back(options.record);
    } else {
      problem = finished.error().text();
    }
  }
  return files;
}

Json run_case(const Json& input) {
  if (input["overwrite"].get<bool>()) allow_overwriting();
  SceneOptions options;
  options.scene = input["scene"].get<std::string>();
  options.set = input["set"].get<std::map<std::string, std::string>>();
  options.plugin_paths = input["plugin_paths"].get<std::vector<std::string>>();
  if (!input["seed"].is_null()) options.seed = input["seed"].get<std::uint64_t>();
  const LoadedScene scene = load_scene(options);
  if (!scene.model) return no_result(findings(scene.diagnostics));
  const auto index = input["test"].get<std::size_t>();
  if (index >= scene.model->tests.size()) return no_result("with this seed there is no such test");
  const TestModel& test = scene.model->tests[index];
  const double duration = test.duration.value_or(duration_of(*scene.model, options));

  auto runs = create(scene, input);
  if (!runs) return no_result(runs.error());
  Simulation& first = *runs->front();
  SignalScope scope{*scene.model, [&first](int sensor) { return &first.channels(sensor); }, {}};
  // The compiler accepts names that may be added during the run.
  scope.may_come = [&](const std::string& name) { return !in_scene(*scene.model, name); };
  auto judge =
      TestJudge::create(scope, test, duration, input["backends"].get<std::vector<std::string>>());
  if (!judge) return no_result(judge.error().text());
  for (const auto& run : *runs) run->observe(judge->needs(), [](const FramePtr&) {});

  const std::string early = run_all(*runs, duration, [&](const std::vector<FramePtr>& frames) {
    judge->see(frames);
    return judge->decided();
  });
  Json out = no_result("");
  bool passed = true;
  for (const Verdict& verdict : judge->finish(early)) {
    passed = passed && verdict.passed;
    out["verdicts"].push_back(to_json(verdict, *scene.model));
  }
  out["status"] = passed ? "passed" : "failed";
  out["errors"] = errors_of(*runs);
  for (std::size_t i = 0; i < runs->size(); ++i)
    if (const Provenance& p = (*runs)[i]->provenance(); !p.left_out.empty())
      out["left_out"][input["backends"][i].get<std::string>()] = to_text(p.left_out);
  out["simulated"] = first.time();
  if (!passed) {
    std::string problem;
    out["recordings"] = record_again(scene, input, duration, problem);
    if (!problem.empty()) out["unrecorded"] = problem;
  }
  return out;
}

}  // namespace

Json no_result(const std::string& message) {
  return {{"status", "error"},       {"message", message},          {"verdicts", Json::array()},
          {"errors", Json::array()}, {"recordings", Json::array()}, {"simulated", 0.0}};
}

int test_case_command() {
  const Json input = case_input();
  if (input.is_discarded()) return kWrongUsage;
  Json out;
  try {
    out = run_case(input);
  } catch (const std::exception& e) {
    out = no_result(message_of(e));
  }
  return write_case_result(out) ? kGood : kFailed;
}

}  // namespace cogrsim::cli
