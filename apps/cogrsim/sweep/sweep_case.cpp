#include "sweep/sweep_case.h"

#include <sys/wait.h>
#include <chrono>
#include <cmath>
#include <cstring>
#include <new>

#include <fmt/format.h>

#include "cogrsim/dsl/study.h"
#include "common/progress.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "policy/policy_case.h"
#include "run/run_measures.h"

namespace cogrsim::cli {
namespace {

// Why a run ended otherwise than by reaching its end: the last that was reported as an error.
std::string cause_of(const Simulation& simulation, RunStatus status) {
  if (status == RunStatus::completed) return {};
  const std::vector<RunMessage>& messages = simulation.messages();
  for (auto m = messages.rbegin(); m != messages.rend(); ++m) {
    if (status == RunStatus::stopped ? m->source == "run" : m->severity == Severity::error) {
      return m->source.empty() || m->source == "run" ? m->message : m->source + ": " + m->message;
    }
  }
  return {};
}

// Plugins' exceptions are caught and reported. A lack of memory is none of a controller's faults, unless
// an isolated one met the bound of its own process.
bool lacks_memory(const RunMessage& message) {
  return message.message.find("bad_alloc") != std::string::npos &&
         message.message.find("it may take") == std::string::npos;
}

Json run(const Json& input) {
  if (input.contains("policy")) return run_policy_case(input);
  SceneOptions options;
  options.scene = input["scene"].get<std::string>();
  options.set = input["set"].get<std::map<std::string, std::string>>();
  options.seed = input["seed"].get<std::uint64_t>();
  options.plugin_paths = input["plugin_paths"].get<std::vector<std::string>>();
  if (!input["until"].is_null()) options.duration = input["until"].get<double>();
  const LoadedScene scene = load_scene(options);
  if (!scene.model) return failed_result("failed", refusal_text(scene.diagnostics));

  SimulationOptions settings;
  settings.backend = input["backend"].get<std::string>();
  settings.seed = options.seed;
  settings.step = input["step"].get<double>();
  settings.without = input["without"].get<std::vector<std::string>>();
  auto created = Simulation::create(scene.model, settings, scene.loader);
  if (!created) return failed_result("failed", refusal_text(created.error()));
  Simulation& simulation = **created;
  const double duration = duration_of(*scene.model, options);
  if (const std::string problem = step_problem(simulation.dt(), duration); !problem.empty()) {
    return failed_result("failed", problem.substr(0, problem.find('\n')));
  }

  std::vector<MeasureModel> measures = scene.model->measures;
  for (const Json& measure : input["measures"]) {
    MeasureModel model;
    model.name = measure["name"].get<std::string>();
    model.signal = measure["signal"].get<std::string>();
    model.take = dsl::parse_take(measure["take"].get<std::string>()).value();
    measures.push_back(std::move(model));
  }
  const auto attached = RunMeasures::attach(simulation, std::move(measures));
  if (!attached) return failed_result("failed", attached.error().message);

  const auto start = std::chrono::steady_clock::now();
  RunStatus status = simulation.run_until(duration);
  const double wall = seconds_since(start);
  Json result = ended_result(simulation, status, wall);
  for (const RunMeasures::Value& value : attached->values()) {
    // Infinite numbers are kept as text: JSON has no such numbers.
    result["measures"][value.name] = std::isnan(value.value) ? Json(nullptr)
                                     : std::isinf(value.value)
                                         ? Json(value.value > 0 ? "inf" : "-inf")
                                         : Json(value.value);
    result["units"][value.name] = value.unit;
  }
  return result;
}

}  // namespace

std::string refusal_text(const std::vector<Diagnostic>& diagnostics) {
  const Diagnostic* d = first_error(diagnostics);
  if (d == nullptr) return "the scene cannot be run";
  const std::string text = d->code.empty() ? d->message : d->code + ": " + d->message;
  return d->file.empty() ? text : d->position_text() + ": " + text;
}

Json ended_result(Simulation& simulation, RunStatus status, double wall) {
  Json result = failed_result("", "");
  if (status == RunStatus::running) {
    status = RunStatus::stopped;  // paused, and nothing can resume it
    result["cause"] = "the run was paused, and nothing can resume it";
  } else {
    result["cause"] = cause_of(simulation, status);
  }
  result["status"] = to_string(status);
  for (const RunMessage& message : simulation.messages()) {
    if (message.severity == Severity::error && result["cause"] == "") {
      result["cause"] = message.source + ": " + message.message;
    }
    if (!lacks_memory(message)) continue;
    result["status"] = "memory";
    result["cause"] = message.source + ": it needed more memory than there was";
    break;
  }
  result["provenance"] = to_json(simulation.provenance());
  result["end_time"] = simulation.time();
  result["wall_time"] = wall;
  result["state_hash"] = fmt::format("{:016x}", state_hash(simulation.frame()->state));
  return result;
}

namespace {

// The last two lines with something on them, as they may be shown: what a library said, and who was
// called when it crashed.
std::string last_lines(const std::string& text) {
  std::string said;
  std::size_t end = text.find_last_not_of(" \n\r\t");
  for (int i = 0; i < 2 && end != std::string::npos; ++i) {
    const std::size_t before = text.find_last_of('\n', end);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::string line = one_line(text.substr(begin, end - begin + 1));
    said = said.empty() ? line : line + "; " + said;
    if (begin == 0) break;
    end = text.find_last_not_of(" \n\r\t", before);
  }
  return said;
}

}  // namespace

Json failed_result(const std::string& status, const std::string& cause) {
  return {{"status", status},       {"cause", cause},        {"end_time", nullptr},
          {"wall_time", nullptr},   {"state_hash", nullptr}, {"measures", Json::object()},
          {"units", Json::object()}};
}

Json sweep_outcome(CaseEnd end, const CasePool::Limits& limits) {
  if (end.timed_out) {
    return failed_result("timeout",
                         fmt::format("took longer than {}", elapsed_text(limits.timeout)));
  }
  const std::string said = last_lines(end.error_text);
  const std::string limited =
      limits.memory_limit > 0
          ? fmt::format(" (its memory was limited to {} MB)", limits.memory_limit / 1000000)
          : "";
  if (WIFSIGNALED(end.status)) {
    const int signal = WTERMSIG(end.status);
    return failed_result("crashed", fmt::format("signal {} ({}){}{}", signal, strsignal(signal),
                                                limited, said.empty() ? "" : ": " + said));
  }
  Json& result = end.result;
  if (WEXITSTATUS(end.status) == 0 && result.is_object() && result.contains("status") &&
      result.contains("measures")) {
    return std::move(result);
  }
  return failed_result(
      "crashed", fmt::format("ended with exit status {} and without a result{}{}",
                             WEXITSTATUS(end.status), limited, said.empty() ? "" : ": " + said));
}

int sweep_case_command() {
  const Json input = case_input();
  if (input.is_discarded() || !input.contains("scene")) {
    print_error("sweep-case is for cogrsim sweep alone");
    return kWrongUsage;
  }
  Json result;
  try {
    result = run(input);
  } catch (const std::bad_alloc&) {
    result = failed_result("memory", input["memory_limit"] == 0
                                         ? "there was no more memory"
                                         : "it needed more memory than its limit");
  } catch (const std::exception& e) {
    result = failed_result("failed", message_of(e));
  }
  return write_case_result(result) ? kGood : kFailed;
}

}  // namespace cogrsim::cli
