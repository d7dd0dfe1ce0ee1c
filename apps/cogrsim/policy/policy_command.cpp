#include "policy/policy_command.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "cogrsim/algorithms/steering.h"
#include "cogrsim/core/constants.h"
#include "cogrsim/core/shown_text.h"
#include "cogrsim/simulation/simulation.h"
#include "common/arguments.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/progress.h"
#include "common/quantities.h"
#include "common/refuse.h"
#include "common/terminal.h"
#include "policy/policy_scene.h"
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

// Mean velocities count from here on [s]: before, the robot starts to walk.
constexpr double kSettled = 2.0;

/// How a robot did in a run.
struct PolicyResult {
  std::string backend, status;
  double time = 0.0;  // at the end [s]
  std::optional<double> fell;
  bool stood = false;  // to the end that was asked for
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();
  double heading = 0.0;          // turned since the start [rad]
  double path = 0.0;             // length of the way [m]
  Vec3 velocity = Vec3::Zero();  // mean, forward, to the left [m/s] and turning [rad/s]
  double limited = 0.0;          // share of time of the motors at their limits of effort
  std::uint64_t seed = 0;
};

/// Watches the base in every step.
class Watch {
 public:
  Watch(const PolicyScene& scene, Simulation& simulation)
      : scene_(scene), simulation_(simulation) {}

  void see(const Frame& frame) {
    const auto base = static_cast<std::size_t>(scene_.robot.base);
    const Pose& body = frame.state.poses[base];
    const Twist& twist = frame.state.twists[base];
    const double heading = planar(body).heading;
    if (!seen_) {
      result.start = body.p;
    } else {
      const double turn = wrapped_angle(heading - heading_);
      result.heading += turn;
      result.path += Vec3(body.p.x() - last_.x(), body.p.y() - last_.y(), 0.0).norm();
      if (frame.time > kSettled) {
        const double dt = frame.time - time_;
        const Vec3 v = Eigen::AngleAxisd(-heading, Vec3::UnitZ()) * twist.linear;
        sum_ += dt * Vec3(v.x(), v.y(), 0.0) + Vec3(0.0, 0.0, turn);
        settled_ += dt;
      }
    }
    seen_ = true;
    heading_ = heading;
    last_ = result.end = body.p;
    time_ = frame.time;
    efforts(frame);
    const PolicyCard& card = *scene_.card;
    const Vec3 up = body.q * (scene_.robot.X_BF.q * Vec3::UnitZ());
    const bool low = body.p.z() < card.fallen_height;
    if (!result.fell && (low || std::acos(std::clamp(up.z(), -1.0, 1.0)) > card.fallen_tilt)) {
      result.fell = frame.time;
      simulation_.stop();
    }
  }

  void finish() {
    if (settled_ > 0.0) result.velocity = sum_ / settled_;
    if (samples_ > 0.0) result.limited = at_limit_ / samples_;
  }

  PolicyResult result;

 private:
  void efforts(const Frame& frame) {
    for (std::size_t i = 0; i < scene_.robot.motors.size(); ++i) {
      const auto index = static_cast<std::size_t>(scene_.robot.motors[i]);
      const Motor& motor = scene_.model->motors[index];
      const JointAxis& axis = scene_.model->joints[static_cast<std::size_t>(motor.joint)]
                                  .axes[static_cast<std::size_t>(motor.axis)];
      double limit = std::min(motor.max_effort, axis.max_effort);
      if (!scene_.card->actions.effort_limit.empty())
        limit = std::min(limit, scene_.card->actions.effort_limit[i]);
      samples_ += 1.0;
      if (std::fabs(frame.state.motor_efforts[index]) >= 0.999 * limit) at_limit_ += 1.0;
    }
  }

  const PolicyScene& scene_;
  Simulation& simulation_;
  bool seen_ = false;
  double heading_ = 0.0, time_ = 0.0, settled_ = 0.0, samples_ = 0.0, at_limit_ = 0.0;
  Vec3 last_ = Vec3::Zero(), sum_ = Vec3::Zero();
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
  const auto printed = print_output(description(scene));
  return printed ? kGood : refuse(printed.error());
}

std::string numbers(const std::vector<double>& values) {
  std::string out;
  for (const double v : values) out += fmt::format("{}{:.4g}", out.empty() ? "" : " ", v);
  return out;
}

std::string summary(const PolicyResult& r, const PolicyScene& scene,
                    const std::vector<double>& command) {
  std::string out = fmt::format("{} on {}, command {}, seed {}\n", one_line(scene.card->file),
                                r.backend, numbers(command), r.seed);
  if (r.fell)
    out += fmt::format("  stood      no: fell at {:.2f} s\n", *r.fell);
  else if (r.stood)
    out += fmt::format("  stood      {:.4g} s\n", r.time);
  else
    out += fmt::format("  stood      to {:.4g} s, where the run ended: {}\n", r.time, r.status);
  const Vec3 way = r.end - r.start;
  out += fmt::format(
      "  walked     {:.2f} m, to {:.2f} m ahead and {:.2f} m to the left; turned {:.1f} deg\n",
      r.path, way.x(), way.y(), r.heading * 180.0 / kPi);
  if (r.time > kSettled)
    out += fmt::format("  velocity   {:.3f} {:.3f} m/s, {:.3f} rad/s: the mean from {:.0f} s on\n",
                       r.velocity.x(), r.velocity.y(), r.velocity.z(), kSettled);
  out += fmt::format("  at limits  {:.1f} % of the motors' time\n", 100.0 * r.limited);
  return out;
}

Json result_json(const PolicyResult& r, const PolicyScene& scene,
                 const std::vector<double>& command) {
  return {{"card", scene.card->file},
          {"backend", r.backend},
          {"seed", r.seed},
          {"command", command},
          {"status", r.status},
          {"time", r.time},
          {"stood", r.stood},
          {"fell_at", r.fell ? Json(*r.fell) : Json(nullptr)},
          {"start", to_json(r.start)},
          {"end", to_json(r.end)},
          {"path", r.path},
          {"turned", r.heading},
          {"velocity", to_json(r.velocity)},
          {"at_limit", r.limited}};
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
  Watch watch(scene, simulation);
  if (const FramePtr first = simulation.frame()) watch.see(*first);
  const Observation observation =
      simulation.observe({}, [&](const FramePtr& frame) { watch.see(*frame); });
  watch.result.backend = simulation.backend().name();
  watch.result.seed = simulation.model()->physics.seed;
  RunStatus status = simulation.status();
  {
    Progress progress(watch.result.backend, options.duration);
    RunLog log(simulation, progress, nullptr, false);
    const InterruptStops stops(simulation);
    if (!watch.result.fell) status = log.run(options.duration);
    log.finish();
  }
  watch.finish();
  watch.result.time = simulation.time();
  watch.result.status = watch.result.fell ? "fell" : to_string(status);
  watch.result.stood =
      !watch.result.fell && (status == RunStatus::completed || status == RunStatus::running);
  if (!options.json.empty()) {
    const auto written = write_output(options.json, OutputKind::json,
                                      json_text(result_json(watch.result, scene, command)));
    if (!written) return refuse(written.error());
  }
  if (options.json != "-") {
    const auto printed = print_output(summary(watch.result, scene, command));
    if (!printed) return refuse(printed.error());
  }
  return watch.result.stood ? kGood : kFailed;
}

std::vector<double> command_from(const std::string& text) {
  std::vector<double> out;
  for (const std::string& piece : split(text, ' ')) {
    if (piece.empty()) continue;
    const auto number = parse_number(piece);
    if (!number) throw UsageError("--command", number.error());
    out.push_back(*number);
  }
  return out;
}

}  // namespace

void add_policy(CLI::App& app, int& status) {
  struct Arguments {
    PolicyOptions options;
    std::string what, command, duration, step, seed;
  };
  const auto arguments = std::make_shared<Arguments>();
  PolicyOptions& o = arguments->options;
  CLI::App& command = *app.add_subcommand(
      "policy", "Check the card of a trained policy, or let it drive its robot");
  command
      .add_option("what", arguments->what,
                  "check: compare the card with network and robot; run: let it drive")
      ->required()
      ->check(CLI::IsMember({"check", "run"}))
      ->type_name("check|run");
  command.add_option("card", o.card, "Policy card")->required()->type_name("NAME.policy.yaml");
  command
      .add_option("--command", arguments->command,
                  "What is asked of the policy, such as \"0.5 0 0\"; default: the card's")
      ->type_name("LIST");
  command.add_option("-b,--backend", o.backend, "Backend; default: that of the scene, or bullet")
      ->type_name("NAME");
  command.add_option("-d,--duration", arguments->duration, "Length of the run; default: 10 s")
      ->type_name("T");
  command
      .add_option("--step", arguments->step, "Time step; default: the card's, or that of the scene")
      ->type_name("DT");
  command.add_option("--seed", arguments->seed, "Seed; default: that of the scene")->type_name("N");
  command.add_option("--json", o.json, "Write the result as JSON; - is the standard output")
      ->type_name("FILE|-");
  add_list(command, "--plugin-path", o.plugin_paths,
           "Folder with plugins, searched first; may be repeated", "DIR");
  command.footer(
      "Examples:\n"
      "  cogrsim policy check walker.policy.yaml\n"
      "  cogrsim policy run walker.policy.yaml --command \"0.5 0 0\" --backend mujoco -d 20s\n"
      "A run ends when the robot falls, as the card defines it.\n"
      "Exit status 0 it fits, or stood to the end; 1 it does not, or fell; 2 wrong usage.");
  command.callback([&status, arguments] {
    PolicyOptions& options = arguments->options;
    if (!arguments->duration.empty())
      options.duration = time_from("--duration", arguments->duration, kAboveZero, kLongestDuration);
    if (!arguments->step.empty()) options.step = step_from(arguments->step);
    if (!arguments->seed.empty()) options.seed = seed_from(arguments->seed);
    options.command = command_from(arguments->command);
    status = arguments->what == "check" ? check(options) : run(options);
  });
}

}  // namespace cogrsim::cli
