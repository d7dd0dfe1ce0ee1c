#include "policy/policy_command.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/shown_text.h"
#include "cogrsim/simulation/simulation.h"
#include "common/arguments.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/progress.h"
#include "common/refuse.h"
#include "common/terminal.h"
#include "policy/policy_case.h"
#include "policy/policy_import.h"
#include "policy/policy_scene.h"
#include "policy/policy_watch.h"
#include "run/run_log.h"

namespace cogrsim::cli {
namespace {

struct PolicyOptions {
  std::string card, backend, json;
  std::vector<double> command;
  std::vector<std::string> plugin_paths;
  double duration = kDefaultDuration, step = 0.0;  // [s]
  std::optional<std::uint64_t> seed;
};

// The result, and what the run was.
struct PolicyRun {
  PolicyResult result;
  std::string backend, status;
  std::uint64_t seed = 0;
  bool stood = false;  // to the end that was asked for
};

bool has_errors(const std::vector<Diagnostic>& found) { return first_error(found) != nullptr; }

// Prints findings; true: there are errors.
bool complain(const std::vector<Diagnostic>& found) {
  print_diagnostics(found);
  return has_errors(found);
}

std::string widths_text(const PolicyScene& scene) {
  const PolicyCard& card = *scene.card;
  std::string out;
  std::size_t at = 0;
  for (const PolicyObservation& o : card.observations) {
    const std::size_t width = o.width(card.joints.size()) * static_cast<std::size_t>(o.history);
    const bool same =
        std::all_of(o.scale.begin(), o.scale.end(), [&](double s) { return s == o.scale.front(); });
    out += fmt::format("  {:>3}  {:<22}{:>4}{}{}{}\n", at, to_string(o.term), width,
                       o.history > 1 ? fmt::format("  {} decisions", o.history) : "",
                       !same ? "  scaled each"
                       : o.scale.empty() || o.scale.front() == 1.0
                           ? ""
                           : fmt::format("  times {}", o.scale.front()),
                       o.delay > 0.0 ? fmt::format("  {} s old", o.delay) : "");
    at += width;
  }
  return out;
}

std::string description(const PolicyScene& scene) {
  const PolicyCard& card = *scene.card;
  const char* kinds[] = {"positions", "velocities", "torques"};
  std::string out = fmt::format("{}: decides {:.4g} times a second about {}\n", one_line(card.file),
                                1.0 / card.period, one_line(card.robot));
  out += fmt::format("reads {} values\n", card.observed()) + widths_text(scene);
  out +=
      fmt::format("writes {} {}\n", card.joints.size(), kinds[static_cast<int>(card.actions.kind)]);
  for (std::size_t i = 0; i < card.joints.size(); ++i) {
    const Motor& motor = scene.model->motors[static_cast<std::size_t>(scene.robot.motors[i])];
    out += fmt::format("  {:>3}  {:<28} {:.4g} + {:.4g} a", i, one_line(card.joints[i]),
                       card.actions.offset[i], card.actions.scale[i]);
    if (motor.mode == MotorMode::servo)
      out += fmt::format("  kp {:.4g} kd {:.4g}", motor.kp, motor.kd);
    else if (!card.actions.kd.empty())
      out += fmt::format("  kp {:.4g} kd {:.4g}",
                         card.actions.kp.empty() ? 0.0 : card.actions.kp[i], card.actions.kd[i]);
    out += '\n';
  }
  return out;
}

int check(const PolicyOptions& options) {
  const PolicyScene scene = load_policy(options.card, options.plugin_paths);
  if (complain(scene.found)) return kFailed;
  const auto printed = print_report(description(scene));
  return printed ? kGood : refuse(printed.error());
}

std::string numbers(const std::vector<double>& values) {
  std::string out;
  for (const double v : values) out += fmt::format("{}{:.4g}", out.empty() ? "" : " ", v);
  return out;
}

std::string summary(const PolicyRun& run, const PolicyScene& scene,
                    const std::vector<double>& command) {
  const PolicyResult& r = run.result;
  std::string out = fmt::format("{} on {}, command {}, seed {}\n", one_line(scene.card->file),
                                run.backend, numbers(command), run.seed);
  if (r.fell)
    out += fmt::format("  stood      no: fell at {:.2f} s\n", *r.fell);
  else if (run.stood)
    out += fmt::format("  stood      {:.4g} s\n", r.time);
  else
    out += fmt::format("  stood      to {:.4g} s, where the run ended: {}\n", r.time, run.status);
  const Vec3 way = r.end - r.start;
  out += fmt::format(
      "  walked     {:.2f} m, to {:.2f} m ahead and {:.2f} m to the left; turned {:.1f} deg\n",
      r.path, way.x(), way.y(), r.heading * 180.0 / kPi);
  if (r.time > kSettled)
    out += fmt::format("  velocity   {:.3f} {:.3f} m/s, {:.3f} rad/s: the mean from {:.0f} s on\n",
                       r.velocity.x(), r.velocity.y(), r.velocity.z(), kSettled);
  if (r.limited)
    out += fmt::format("  at limits  {:.1f} % of the motors' time\n", 100.0 * *r.limited);
  return out;
}

Json result_json(const PolicyRun& run, const PolicyScene& scene,
                 const std::vector<double>& command) {
  const PolicyResult& r = run.result;
  return {{"card", scene.card->file},
          {"backend", run.backend},
          {"seed", run.seed},
          {"command", command},
          {"status", run.status},
          {"time", r.time},
          {"stood", run.stood},
          {"fell_at", r.fell ? Json(*r.fell) : Json(nullptr)},
          {"start", to_json(r.start)},
          {"end", to_json(r.end)},
          {"path", r.path},
          {"turned", r.heading},
          {"velocity", to_json(r.velocity)},
          {"at_limit", r.limited ? Json(*r.limited) : Json(nullptr)}};
}

int run(const PolicyOptions& options) {
  add_input(options.card);
  if (const auto writable = check_writable({{options.json, OutputKind::json}}); !writable)
    return refuse(writable.error());
  const PolicyScene scene = load_policy(options.card, options.plugin_paths);
  if (complain(scene.found)) return kFailed;
  if (!options.command.empty() && options.command.size() != scene.card->command.size())
    return refuse(Error(fmt::format("the command has {} numbers, and that of the card {}",
                                    options.command.size(), scene.card->command.size())),
                  kWrongUsage);
  const std::vector<double> command =
      options.command.empty() ? scene.card->command : options.command;
  const auto model = with_policy(scene, command);
  if (!model) return refuse(model.error());
  SimulationOptions settings;
  settings.backend = options.backend;
  settings.step = options.step;
  settings.seed = options.seed;
  catch_interrupts();
  auto created = Simulation::create(*model, settings, scene.loader);
  if (!created) {
    print_problems(created.error());
    return kFailed;
  }
  Simulation& simulation = **created;
  PolicyWatch watch(scene, simulation, command);
  bool fell = false;
  if (const FramePtr first = simulation.frame()) fell = watch.see(*first);
  const Observation observation = simulation.observe({}, [&](const FramePtr& frame) {
    if (watch.see(*frame)) simulation.stop();
  });
  PolicyRun out;
  out.backend = simulation.backend().name();
  out.seed = simulation.model()->physics.seed;
  RunStatus status = simulation.status();
  {
    Progress progress(out.backend, options.duration);
    RunLog log(simulation, progress, nullptr, false);
    const InterruptStops stops(simulation);
    if (!fell) status = log.run(options.duration);
    log.finish();
  }
  out.result = watch.finish();
  out.result.time = simulation.time();
  out.status = out.result.fell ? "fell" : to_string(status);
  out.stood = !out.result.fell && (status == RunStatus::completed || status == RunStatus::running);
  const auto printed =
      print_found(options.json, [&] { return json_text(result_json(out, scene, command)); },
                  [&] { return summary(out, scene, command); });
  if (!printed) return refuse(printed.error());
  return out.stood ? kGood : kFailed;
}

std::vector<double> command_from(const std::string& text) {
  const auto numbers = parse_command(text);
  if (!numbers) throw UsageError("--command", numbers.error());
  return *numbers;
}

}  // namespace

void add_policy(CLI::App& app, int& status) {
  struct Arguments {
    PolicyOptions options;
    PolicyImportOptions import;
    std::string what, command, duration, step, seed, robot, network, base;
    std::vector<std::string> files, set;
  };
  const auto arguments = std::make_shared<Arguments>();
  PolicyOptions& o = arguments->options;
  CLI::App& command = *app.add_subcommand(
      "policy", "Check the card of a trained policy, let it drive its robot, or make one");
  command
      .add_option(
          "what", arguments->what,
          "check: compare the card with network and robot; run: let it drive; import: make a "
          "card of what Isaac Lab, unitree_rl_gym, unitree_rl_lab or mujoco_playground write")
      ->required()
      ->check(CLI::IsMember({"check", "run", "import"}))
      ->type_name("check|run|import");
  command
      .add_option("files", arguments->files, "Policy card; for import: the files of the other tool")
      ->required()
      ->type_name("FILE...");
  const auto of = [&](const char* what, CLI::Option* option) {
    option->group(std::string("Options of ") + what);
    return option;
  };
  of("run",
     command.add_option("--command", arguments->command,
                        "What is asked of the policy, such as \"0.5 0 0\"; default: the card's"))
      ->type_name("LIST");
  of("run", command.add_option("-b,--backend", o.backend,
                               "Backend; default: that of the scene, or bullet"))
      ->type_name("NAME");
  of("run",
     command.add_option("-d,--duration", arguments->duration, "Length of the run; default: 10 s"))
      ->type_name("T");
  of("run", command.add_option("--step", arguments->step,
                               "Time step; default: the card's, or that of the scene"))
      ->type_name("DT");
  of("run", command.add_option("--seed", arguments->seed, "Seed; default: that of the scene"))
      ->type_name("N");
  of("run", add_json(command, o.json));
  of("import", command.add_option("-o,--output", arguments->import.output, "Card to write"))
      ->type_name("NAME.policy.yaml");
  of("import", command.add_option("--robot", arguments->robot, "The robot: URDF, MJCF or scene"))
      ->type_name("FILE");
  of("import", command.add_option("--network", arguments->network, "The network: ONNX"))
      ->type_name("FILE");
  of("import", command.add_option("--base", arguments->base,
                                  "Body or frame of the robot whose motion is observed"))
      ->type_name("NAME");
  add_list(command, "--set", arguments->set,
           "Value of a key of the card, in YAML; ~: its default; may be repeated", "KEY=VALUE");
  of("import", command.get_option("--set"));
  add_list(command, "--plugin-path", o.plugin_paths,
           "Folder with plugins, searched first; may be repeated", "DIR");
  command.footer(
      "Examples:\n"
      "  cogrsim policy check walker.policy.yaml\n"
      "  cogrsim policy run walker.policy.yaml --command \"0.5 0 0\" --backend mujoco -d 20s\n"
      "  cogrsim policy import IO_descriptors.yaml env.yaml --robot anymal.urdf --network net.onnx "
      "-o anymal.policy.yaml\n"
      "A run ends when the robot falls, as the card defines it. An import asks for what the files "
      "leave "
      "open.\n"
      "Exit status 0 it fits, stood to the end, or is written and fits; 1 it does not, or fell; 2 "
      "wrong "
      "usage.");
  command.callback([&status, arguments, &command] {
    PolicyOptions& options = arguments->options;
    const std::string& what = arguments->what;
    // An option of another action would be ignored.
    for (const CLI::Option* option : command.get_options())
      if (const std::string group = option->get_group(); option->count() > 0 &&
                                                         group.rfind("Options of ", 0) == 0 &&
                                                         group != "Options of " + what)
        throw UsageError(option->get_name(),
                         Error(fmt::format("`policy {}` has no such option", what)));
    if (what == "import") {
      PolicyImportOptions& import = arguments->import;
      import.sources = arguments->files;
      const std::string ending = ".policy.yaml";
      if (import.output.size() <= ending.size() ||
          import.output.compare(import.output.size() - ending.size(), ending.size(), ending) != 0)
        throw UsageError("--output", Error("name the card to write: -o NAME.policy.yaml"));
      for (const auto& [key, value] : {std::pair{"robot", &arguments->robot},
                                       {"network", &arguments->network},
                                       {"base", &arguments->base}})
        if (!value->empty()) import.answers.emplace_back(key, Json(*value).dump());
      for (const std::string& text : arguments->set) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos || equals == 0)
          throw UsageError("--set", Error("'" + text + "' is not KEY=VALUE"));
        import.answers.emplace_back(text.substr(0, equals), text.substr(equals + 1));
      }
      status = import_policy(import, options.plugin_paths);
      return;
    }
    if (arguments->files.size() != 1) throw UsageError("files", Error("name one card"));
    options.card = arguments->files.front();
    if (!arguments->duration.empty())
      options.duration = time_from("--duration", arguments->duration, kAboveZero, kLongestDuration);
    if (!arguments->step.empty()) options.step = step_from(arguments->step);
    if (!arguments->seed.empty()) options.seed = seed_from(arguments->seed);
    options.command = command_from(arguments->command);
    status = what == "check" ? check(options) : run(options);
  });
}

}  // namespace cogrsim::cli
