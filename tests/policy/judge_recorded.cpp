// Inputs for networks of others: of a card what its network is given while it drives its robot, with a
// command that changes every ten seconds; of an ONNX file alone normal random numbers.
#include "judge_recorded.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/random.h"
#include "cogrsim/policy/observer.h"
#include "policy/policy_scene.h"
#include "policy/policy_watch.h"

namespace cogrsim::test {

namespace {

constexpr double kRun = 10.0;       // with one command [s]
constexpr double kStill = 0.2;      // share of the commands that ask for nothing
constexpr double kCommanded = 0.8;  // the others are within ± this [m/s], [rad/s]
constexpr int kMostRuns = 10000;    // a robot that falls at once makes few observations in each

// What the controller's sensors have.
PolicyMeasured measured(const cli::PolicyScene& scene, const Frame& frame) {
  const PolicyRobot& robot = scene.robot;
  const auto base = static_cast<std::size_t>(robot.base);
  const Pose& X_WB = frame.state.poses[base];
  const Twist& twist = frame.state.twists[base];
  PolicyMeasured out;
  out.base = X_WB * robot.X_BF;
  out.twist = {twist.linear + twist.angular.cross(out.base.p - X_WB.p), twist.angular};
  for (const int index : robot.joints) {
    const Joint& joint = scene.model->joints[static_cast<std::size_t>(index)];
    out.positions.push_back(
        frame.state.joint_positions[static_cast<std::size_t>(joint.position_offset)]);
    out.velocities.push_back(
        frame.state.joint_velocities[static_cast<std::size_t>(joint.speed_offset)]);
  }
  return out;
}

// The controller, beside the one that drives: the same observations of the same frames.
class Shadow {
 public:
  Shadow(const cli::PolicyScene& scene, std::vector<double> command, double step,
         RandomStream& random)
      : scene_(scene),
        command_(std::move(command)),
        every_(std::max<long>(1, std::lround(scene.card->period / step))),
        ports_(policy_ports(*scene.card, *scene.network)),
        observer_(*scene.card, step,
                  [&random](double low, double high) { return random.uniform(low, high); }),
        raw_(scene.card->joints.size(), 0.0),
        clipped_(raw_) {
    for (const NetworkPort& port : scene.network->inputs()) inputs_.emplace_back(port.size, 0.0f);
  }

  Result<> see(const Frame& frame, std::vector<NetworkInputs>& into) {
    observer_.measure(measured(scene_, frame));
    if (steps_++ % every_ != 0) return {};
    inputs_[ports_.observed] = observer_.decide(command_, raw_, clipped_);
    into.push_back(inputs_);
    const auto out = scene_.network->run(inputs_);
    if (!out) return tl::unexpected(out.error());
    for (const auto& [in, from] : ports_.feedback) inputs_[in] = (*out)[from];
    const auto& clip = scene_.card->actions.clip;
    for (std::size_t i = 0; i < raw_.size(); ++i) {
      raw_[i] = static_cast<double>((*out)[ports_.acting][i]);
      clipped_[i] = clip ? std::clamp(raw_[i], clip->first, clip->second) : raw_[i];
    }
    return {};
  }

 private:
  const cli::PolicyScene& scene_;
  std::vector<double> command_;
  long every_, steps_ = 0;
  PolicyPorts ports_;
  PolicyObserver observer_;
  NetworkInputs inputs_;
  std::vector<double> raw_, clipped_;
};

}  // namespace

Result<std::vector<NetworkInputs>> random_inputs(const PolicyNetwork& network, std::size_t count) {
  RandomStream random(1, "judge");
  std::vector<NetworkInputs> out(count);
  for (NetworkInputs& each : out)
    for (const NetworkPort& port : network.inputs()) {
      std::vector<float> values(port.size);
      for (float& value : values) value = static_cast<float>(random.normal());
      each.push_back(std::move(values));
    }
  return out;
}

Result<std::vector<NetworkInputs>> recorded_inputs(const std::string& card,
                                                   const std::string& backend, std::size_t count,
                                                   std::shared_ptr<const PolicyNetwork>& network,
                                                   std::string& file) {
  const cli::PolicyScene scene = cli::load_policy(card, {});
  if (const Diagnostic* error = first_error(scene.found)) return tl::unexpected(to_error(*error));
  network = scene.network;
  file = scene.card->network;
  RandomStream random(1, "judge");
  std::vector<NetworkInputs> out;
  for (int run = 0; run < kMostRuns && out.size() < count; ++run) {
    std::vector<double> command = scene.card->command;
    const bool still = random.uniform() < kStill;
    for (double& each : command) each = still ? 0.0 : random.uniform(-kCommanded, kCommanded);
    const auto model = cli::with_policy(scene, command);
    if (!model) return tl::unexpected(model.error());
    SimulationOptions options;
    options.backend = backend;
    options.seed = static_cast<std::uint64_t>(run + 1);
    auto created = Simulation::create(*model, options, scene.loader);
    if (!created) return tl::unexpected(to_error(created.error().front()));
    Simulation& simulation = **created;
    cli::PolicyWatch watch(scene, simulation, command);
    Shadow shadow(scene, command, simulation.dt(), random);
    Result<> good;
    const auto see = [&](const Frame& frame) {
      // Before the step that the controller does with it, so the last frame of a run has no decision.
      const bool fell = watch.see(frame);
      good = fell ? Result<>() : shadow.see(frame, out);
      return !fell && good && out.size() < count;
    };
    bool on = see(*simulation.frame());
    const Observation observation = simulation.observe({}, [&](const FramePtr& frame) {
      if (frame->step == 0) return;  // has been seen
      if (on && !(on = see(*frame))) simulation.stop();
    });
    if (on) static_cast<void>(simulation.run_until(kRun));
    if (!good) return tl::unexpected(good.error());
  }
  if (out.size() < count)
    return tl::unexpected(
        Error(fmt::format("{}: the robot falls before {} decisions were made in {} "
                          "runs; there are {}",
                          card, count, kMostRuns, out.size())));
  return out;
}

}  // namespace cogrsim::test
