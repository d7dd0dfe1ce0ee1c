#include "policy/policy_case.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/random.h"
#include "common/progress.h"
#include "common/quantities.h"
#include "policy/filmstrip.h"
#include "policy/policy_watch.h"
#include "sweep/sweep_case.h"

namespace cogrsim::cli {
namespace {

// Of the start, drawn from the seed, uniform within ± these; the base is lifted so that no foot is in the
// ground: half a leg of 1 m turned by 0.02 rad is 1 cm.
constexpr double kJointShift = 0.02;   // of every joint [rad] or [m]
constexpr double kBaseVelocity = 0.1;  // of the robot, forward and to the left [m/s]
constexpr double kLift = 0.01;         // [m]
constexpr double kPushEvery = 3.0, kFirstPush = 2.0, kPushTime = 0.1;  // [s]

WorldState disturbed_start(const PolicyScene& scene, std::uint64_t seed, WorldState state) {
  const SceneModel& model = *scene.model;
  RandomStream random(seed, "policy.start");
  const Vec3 velocity(random.uniform(-kBaseVelocity, kBaseVelocity),
                      random.uniform(-kBaseVelocity, kBaseVelocity), 0.0);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (!is_of_robot(model, scene.robot, static_cast<int>(b)) ||
        model.bodies[b].kind != BodyKind::dynamic)
      continue;
    state.poses[b].p.z() += kLift;
    state.twists[b].linear += velocity;
  }
  for (const int index : scene.robot.joints) {
    const Joint& joint = model.joints[static_cast<std::size_t>(index)];
    double& q = state.joint_positions[static_cast<std::size_t>(joint.position_offset)];
    q = std::clamp(q + random.uniform(-kJointShift, kJointShift), std::min(q, joint.axes[0].lower),
                   std::max(q, joint.axes[0].upper));
  }
  return state;
}

// What the card's sensors would have, without noise, scale and delay.
class Trace {
 public:
  Trace(const PolicyScene& scene, double until, double step)
      : scene_(scene),
        until_(until),
        every_(std::max<std::uint64_t>(
            1, static_cast<std::uint64_t>(std::lround(scene.card->period / step)))) {}

  void see(const Frame& frame) {
    // The frame of step 0 is shown before the start that the seed draws is set.
    if (frame.step == 0 || frame.step % every_ != 0 || frame.time > until_ + 1e-9) return;
    row_.clear();
    terms.clear();
    for (const PolicyObservation& o : scene_.card->observations) add(o, frame);
    rows.push_back(row_);
  }
  Json terms = Json::array(), rows = Json::array();

 private:
  void put(const PolicyObservation& o, const std::string& of, double value) {
    terms.push_back(fmt::format("{} {}", to_string(o.term), of));
    row_.push_back(value);
  }
  void put(const PolicyObservation& o, const Vec3& v) {
    for (int i = 0; i < 3; ++i) put(o, std::string(1, "xyz"[i]), v[i]);
  }
  void add(const PolicyObservation& o, const Frame& frame) {
    const auto base = static_cast<std::size_t>(scene_.robot.base);
    const Pose X = frame.state.poses[base] * scene_.robot.X_BF;
    const Twist& twist = frame.state.twists[base];
    switch (o.term) {
      case PolicyTerm::base_linear_velocity:
        return put(o, X.q.conjugate() *
                          (twist.linear + twist.angular.cross(X.p - frame.state.poses[base].p)));
      case PolicyTerm::base_angular_velocity:
        return put(o, X.q.conjugate() * twist.angular);
      case PolicyTerm::projected_gravity:
        return put(o, X.q.conjugate() * Vec3(0, 0, -1));
      case PolicyTerm::base_height:
        return put(o, "", X.p.z());
      case PolicyTerm::joint_positions:
      case PolicyTerm::joint_velocities:
        for (std::size_t i = 0; i < scene_.robot.joints.size(); ++i) {
          const Joint& joint =
              scene_.model->joints[static_cast<std::size_t>(scene_.robot.joints[i])];
          const bool position = o.term == PolicyTerm::joint_positions;
          put(o, "of " + scene_.card->joints[i],
              position
                  ? frame.state.joint_positions[static_cast<std::size_t>(joint.position_offset)]
                  : frame.state.joint_velocities[static_cast<std::size_t>(joint.speed_offset)]);
        }
        return;
      default:
        return;
    }
  }

  const PolicyScene& scene_;
  double until_;
  std::uint64_t every_;
  Json row_ = Json::array();
};

// Runs to the end, with pushes of this change of velocity [m/s].
RunStatus run_pushed(const PolicyScene& scene, Simulation& simulation, std::uint64_t seed,
                     double push, double duration) {
  RandomStream random(seed, "policy.push");
  double mass = 0.0;
  for (std::size_t b = 0; b < scene.model->bodies.size(); ++b)
    if (is_of_robot(*scene.model, scene.robot, static_cast<int>(b)))
      mass += scene.model->bodies[b].mass;
  const Body& base = scene.model->bodies[static_cast<std::size_t>(scene.robot.base)];
  for (double at = kFirstPush; push > 0.0 && at < duration; at += kPushEvery) {
    const RunStatus status = simulation.run_until(at);
    if (status != RunStatus::completed) return status;
    const double angle = random.uniform(0.0, 2.0 * kPi), force = mass * push / kPushTime;
    simulation.send(ApplyForce{base.name, force * Vec3(std::cos(angle), std::sin(angle), 0.0),
                               Vec3::Zero(), base.com, false, kPushTime});
  }
  return simulation.run_until(duration);
}

Json measures_json(const PolicyResult& r, bool stood) {
  const auto number = [](const std::optional<double>& x) { return x ? Json(*x) : Json(nullptr); };
  const std::optional<double> walked[] = {r.velocity.x(), r.velocity.y(), r.velocity.z()};
  Json out = {{"stood", stood ? 1.0 : 0.0},
              {"upright", r.fell.value_or(r.time)},
              {"fell_at", number(r.fell)},
              {"velocity_error", number(r.velocity_error)},
              {"turning_error", number(r.turning_error)},
              {"slip", number(r.slip)},
              {"mean_force", number(r.mean_force)},
              {"peak_force", number(r.peak_force)},
              {"at_limit", number(r.limited)},
              {"cost_of_transport", number(r.cost)}};
  const char* names[] = {"forward", "leftward", "turning"};
  for (int i = 0; i < 3; ++i) out[names[i]] = r.time > kSettled ? number(walked[i]) : Json(nullptr);
  return out;
}

}  // namespace

Result<std::vector<double>> parse_command(const std::string& text) {
  std::vector<double> out;
  for (const std::string& piece : split(text, ' ')) {
    if (piece.empty()) continue;
    const auto number = parse_number(piece);
    if (!number) return tl::unexpected(number.error());
    out.push_back(*number);
  }
  return out;
}

Result<PolicySettings> parse_settings(const std::string& text) {
  PolicySettings out;
  for (const std::string& piece : split(text, ';')) {
    if (piece.empty()) continue;
    const auto pair = parse_setting(piece);
    if (!pair) return tl::unexpected(pair.error());
    out[pair->first] = pair->second;
  }
  return out;
}

Json run_policy_case(const Json& input) {
  PolicySettings settings = input["set"].get<PolicySettings>();
  if (const auto change = settings.find("change"); change != settings.end()) {
    const auto more = parse_settings(change->second);
    if (!more) return failed_result("failed", more.error().message);
    settings.erase(change);
    for (const auto& [name, value] : *more) settings[name] = value;
  }
  const PolicyScene scene =
      load_policy(input["scene"].get<std::string>(),
                  input["plugin_paths"].get<std::vector<std::string>>(), settings);
  if (first_error(scene.found) != nullptr)
    return failed_result("failed", refusal_text(scene.found));
  std::vector<double> command = scene.card->command;
  if (settings.count("command") > 0) {
    const auto asked = parse_command(settings.at("command"));
    if (!asked) return failed_result("failed", asked.error().message);
    if (!asked->empty()) command = *asked;
  }
  const auto push = setting_number(settings, "push", "m/s", 0.0),
             step = setting_number(settings, "step", "s", input["step"].get<double>()),
             start = setting_number(settings, "start", "", 1.0);
  for (const auto* each : {&push, &step, &start})
    if (!*each) return failed_result("failed", each->error().message);
  const auto model = with_policy(scene, command);
  if (!model) return failed_result("failed", model.error().message);
  SimulationOptions options;
  options.backend = input["backend"].get<std::string>();
  options.seed = input["seed"].get<std::uint64_t>();
  options.step = *step;
  options.without = input["without"].get<std::vector<std::string>>();
  auto created = Simulation::create(*model, options, scene.loader);
  if (!created) return failed_result("failed", refusal_text(created.error()));
  Simulation& simulation = **created;
  const double duration = input["until"].get<double>();
  if (*start != 0.0)
    simulation.send(SetState{disturbed_start(scene, *options.seed, simulation.frame()->state)});
  PolicyWatch watch(scene, simulation, command);
  Trace trace(scene, input.value("trace", -1.0), simulation.dt());
  std::optional<StripCamera> camera;
  if (const int pictures = std::clamp(input.value("pictures", 0), 0, kMostPictures); pictures > 0)
    camera.emplace(scene, pictures, duration);
  const bool fell_at_once = watch.see(*simulation.frame());
  const Observation observation =
      simulation.observe(PolicyWatch::contents(), [&](const FramePtr& frame) {
        trace.see(*frame);
        if (camera) camera->see(frame);
        if (watch.see(*frame)) simulation.stop();
      });
  const auto began = std::chrono::steady_clock::now();
  const RunStatus status = fell_at_once
                               ? RunStatus::stopped
                               : run_pushed(scene, simulation, *options.seed, *push, duration);
  Json result = ended_result(simulation, status, seconds_since(began));
  const PolicyResult measured = watch.finish();
  if (measured.fell) {
    result["status"] = to_string(RunStatus::completed);
    result["cause"] = "";
  }
  const bool stood = !measured.fell && status == RunStatus::completed;
  result["measures"] = measures_json(measured, stood);
  for (const PolicyMeasure& measure : kPolicyMeasures) result["units"][measure.name] = measure.unit;
  if (camera) result["strip"] = camera->develop();
  if (input.contains("trace")) {
    result["terms"] = trace.terms;
    result["trace"] = trace.rows;
    result["period"] = scene.card->period;
  }
  return result;
}

}  // namespace cogrsim::cli
