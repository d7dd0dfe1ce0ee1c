// Drives a robot by a trained network, as its card says. Runs in every step of the physics: decisions are
// made at the card's rate, and the drive law, where the card has gains, in every step between them:
//
//     torque = kp (target - q) - kd q'     kp, kd of the card; for velocities kd (target - q')
#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "cogrsim/control/controller.h"
#include "cogrsim/core/diagnostic.h"
#include "cogrsim/policy/card.h"
#include "cogrsim/policy/observer.h"

namespace policy_plugin {
namespace {

using cogrsim::PolicyActionKind;
using Values = std::vector<double>;

std::string line_of(const cogrsim::Diagnostic& d) { return cogrsim::to_error(d).text(); }

class Policy final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;
    base_ = robot.sensor<cogrsim::PoseSensor>(robot.parameter<std::string>("base"));
    const auto path = card_path(robot);
    if (!path) return;
    std::vector<cogrsim::Diagnostic> found;
    card_ = cogrsim::read_policy_card(*path, found, changes(robot));
    if (card_) load_network(robot, found);
    for (const cogrsim::Diagnostic& d : found) robot.fail(line_of(d));
    if (!card_) return;
    command_ = robot.parameter<Values>("command");
    if (command_.empty()) command_ = card_->command;
    if (command_.size() != card_->command.size())
      robot.fail("the command has " + std::to_string(command_.size()) +
                 " numbers, and that of the card " + std::to_string(card_->command.size()));
    else
      declare_inputs(robot);
    find_motors(robot);
    const std::size_t count = card_->joints.size();
    raw_.assign(count, 0.0);
    clipped_.assign(count, 0.0);
    target_ = card_->actions.offset;
    gains_ = !card_->actions.kp.empty() || !card_->actions.kd.empty();
  }

  void update(const cogrsim::Tick& tick) override {
    if (!observer_) begin(tick.period);
    if (base_.valid()) {
      measured_.base = base_.pose();
      measured_.twist = base_.twist();
    } else if (steps_ == 0) {
      throw std::runtime_error("the pose sensor has no reading at the start");
    }
    const std::size_t count = motors_.size();
    measured_.positions.resize(count);
    measured_.velocities.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      measured_.positions[i] = robot_->joint_position(motors_[i]);
      measured_.velocities[i] = robot_->joint_velocity(motors_[i]);
    }
    observer_->measure(measured_);
    const bool decides = steps_ % decimation_ == 0;
    if (decides) decide();
    ++steps_;
    // Targets that are as old as the delay hold from now on.
    for (auto& each : pending_) --each.left;
    while (!pending_.empty() && pending_.front().left <= 0) {
      target_ = std::move(pending_.front().target);
      pending_.pop_front();
    }
    if (decides || !card_->actions.per_decision) drive();
  }

  std::optional<std::string> save() const override {
    cogrsim::PolicyMemoryWriter memory;
    memory.list(std::vector<double>{observer_ ? step_ : 0.0, static_cast<double>(steps_),
                                    static_cast<double>(pending_.size())});
    memory.list(raw_);
    memory.list(clipped_);
    memory.list(target_);
    for (const Pending& each : pending_) {
      memory.number(each.left);
      memory.list(each.target);
    }
    for (const auto& values : inputs_) memory.list(values);
    for (const auto* part : {&measured_.positions, &measured_.velocities}) memory.list(*part);
    const auto& [base, twist] = std::tie(measured_.base, measured_.twist);
    memory.list(Values{base.p.x(), base.p.y(), base.p.z(), base.q.w(), base.q.x(), base.q.y(),
                       base.q.z(), twist.linear.x(), twist.linear.y(), twist.linear.z(),
                       twist.angular.x(), twist.angular.y(), twist.angular.z()});
    if (observer_) observer_->save(memory);
    return memory.text;
  }

  void restore(const std::string& text) override {
    cogrsim::PolicyMemoryReader memory(text);
    Values head(3);
    memory.list(head);
    if (!(head[0] >= 0.0 && head[1] >= 0.0 && head[1] < 1e15 && head[2] >= 0.0 && head[2] <= 1e5))
      throw std::runtime_error("the snapshot is of another policy");
    if (head[0] > 0.0) begin(head[0]);
    steps_ = static_cast<std::uint64_t>(head[1]);
    const std::size_t count = motors_.size();
    memory.list(raw_);
    memory.list(clipped_);
    memory.list(target_);
    pending_.assign(static_cast<std::size_t>(head[2]), {0.0, Values(count)});
    for (Pending& each : pending_) {
      each.left = memory.number();
      memory.list(each.target);
    }
    for (auto& values : inputs_) memory.list(values);
    for (auto* part : {&measured_.positions, &measured_.velocities}) {
      part->assign(memory.size() == 0 ? 0 : count, 0.0);
      memory.list(*part);
    }
    Values b(13);
    memory.list(b);
    measured_.base = {{b[0], b[1], b[2]}, cogrsim::Quat(b[3], b[4], b[5], b[6])};
    measured_.twist = {{b[7], b[8], b[9]}, {b[10], b[11], b[12]}};
    if (observer_) observer_->restore(memory);
  }

 private:
  struct Pending {
    double left = 0.0;  // steps until it holds
    Values target;
  };

  // A scene may come from somebody else, and names cards in its folder only. Others are named on the
  // command line, as parameters of the scene.
  static std::optional<std::string> card_path(cogrsim::Assembly& robot) {
    namespace fs = std::filesystem;
    const std::string name = robot.parameter<std::string>("card"), folder = robot.scene_folder();
    std::error_code error;
    const fs::path base =
        fs::weakly_canonical(folder.empty() ? fs::path(".") : fs::path(folder), error);
    const fs::path full = fs::weakly_canonical(base / name, error);
    const auto& set = robot.set_parameters();
    const bool asked =
        std::any_of(set.begin(), set.end(), [&](const auto& each) { return each.second == name; });
    // Compared by path elements after resolving links: "scene2" is not inside "scene".
    if (!error &&
        (asked ||
         std::mismatch(base.begin(), base.end(), full.begin(), full.end()).first == base.end()))
      return full.string();
    robot.fail("card '" + name + "' lies outside the scene's folder " + base.string() +
               "; a card elsewhere is named by --set");
    return std::nullopt;
  }

  // Lines of KEY=VALUE.
  static cogrsim::CardChanges changes(cogrsim::Assembly& robot) {
    cogrsim::CardChanges out;
    std::istringstream lines(robot.parameter<std::string>("change"));
    for (std::string line; std::getline(lines, line);) {
      const std::size_t equals = line.find('=');
      if (equals == std::string::npos)
        robot.fail("'" + line + "' is no KEY=VALUE of a card");
      else
        out.emplace_back(line.substr(0, equals), line.substr(equals + 1));
    }
    return out;
  }

  // What a person may ask for while the run goes: where the card says within which limits. A run that asks
  // for more from its start may go on doing so.
  void declare_inputs(cogrsim::Assembly& robot) {
    const auto& names = card_->command_names;
    for (std::size_t i = 0; i < card_->command_limits.size(); ++i) {
      const auto& [lower, upper] = card_->command_limits[i];
      asked_.push_back(
          robot.input(names.empty() ? "command " + std::to_string(i + 1) : names[i].first,
                      command_[i], std::min(lower, command_[i]), std::max(upper, command_[i]),
                      names.empty() ? "" : names[i].second));
    }
  }

  void load_network(cogrsim::Assembly& robot, std::vector<cogrsim::Diagnostic>& found) {
    auto network = cogrsim::PolicyNetwork::read(card_->network);
    if (!network) {
      robot.fail(network.error().text());
      return;
    }
    network_ = *network;
    const auto sizes = cogrsim::check_policy_network(*card_, *network_);
    found.insert(found.end(), sizes.begin(), sizes.end());
    for (const auto& port : network_->inputs()) inputs_.emplace_back(port.size, 0.0f);
    if (sizes.empty()) ports_ = cogrsim::policy_ports(*card_, *network_);
  }

  // By the joints that they drive.
  void find_motors(cogrsim::Assembly& robot) {
    std::vector<std::string> driven;
    std::vector<cogrsim::MotorHandle> all;
    for (const std::string& name : robot.motor_names()) {
      all.push_back(robot.motor(name));
      driven.push_back(all.back().joint());
    }
    for (const std::string& joint : card_->joints) {
      const int index = cogrsim::find_policy_name(driven, joint);
      if (index < 0) {
        std::string names;
        for (const std::string& name : driven) names += (names.empty() ? "" : ", ") + name;
        robot.fail("no motor drives a joint '" + joint + "', or several do; there are motors of " +
                   (names.empty() ? "none" : names));
        continue;
      }
      motors_.push_back(all[static_cast<std::size_t>(index)]);
      check_mode(robot, joint, motors_.back().mode());
    }
  }

  void check_mode(cogrsim::Assembly& robot, const std::string& joint,
                  cogrsim::MotorMode mode) const {
    using cogrsim::MotorMode;
    const cogrsim::PolicyActions& a = card_->actions;
    const bool torque = mode == MotorMode::torque;
    const bool law = !a.kp.empty() || !a.kd.empty();
    const bool fits = law                                  ? torque || mode == MotorMode::servo
                      : a.kind == PolicyActionKind::torque ? torque
                      : a.kind == PolicyActionKind::velocity
                          ? mode == MotorMode::velocity
                          : mode == MotorMode::position || mode == MotorMode::servo;
    if (!fits)
      robot.fail("the motor of joint '" + joint + "' is in mode " + to_string(mode) +
                 ", which does not fit the card; `cogrsim policy check` says why");
  }

  void begin(double step) {
    const double steps = card_->period / step;
    if (steps < 0.999 || std::fabs(steps - std::round(steps)) > 1e-4 * steps)
      throw std::runtime_error("decisions every " + std::to_string(card_->period) +
                               " s are no multiple of the time between updates, " +
                               std::to_string(step) +
                               " s; a policy needs no rate in the scene: it runs in every step");
    step_ = step;
    decimation_ = static_cast<std::uint64_t>(std::lround(steps));
    if (gains_ && decimation_ == 1 && card_->step > 0.0 && card_->step < 0.75 * card_->period)
      throw std::runtime_error(
          "the drive law would run once per decision only; leave out the controller's rate");
    observer_.emplace(*card_, step,
                      [this](double low, double high) { return robot_->uniform(low, high); });
  }

  void decide() {
    for (std::size_t i = 0; i < asked_.size(); ++i) command_[i] = asked_[i].value();
    inputs_[ports_.observed] = observer_->decide(command_, raw_, clipped_);
    const auto out = network_->run(inputs_);
    if (!out) throw std::runtime_error(out.error().text());
    for (const auto& [in, from] : ports_.feedback) inputs_[in] = (*out)[from];
    const std::vector<float>& action = (*out)[ports_.acting];
    const cogrsim::PolicyActions& a = card_->actions;
    Values target(action.size());
    for (std::size_t i = 0; i < action.size(); ++i) {
      raw_[i] = static_cast<double>(action[i]);
      if (!std::isfinite(raw_[i]))
        throw std::runtime_error("the network's output for joint '" + card_->joints[i] +
                                 "' is no finite number");
      clipped_[i] = a.clip ? std::clamp(raw_[i], a.clip->first, a.clip->second) : raw_[i];
      target[i] = a.offset[i] + a.scale[i] * clipped_[i];
    }
    // One more, as the step of the decision itself counts down, too.
    pending_.push_back({std::round(a.delay / step_) + 1.0, std::move(target)});
  }

  void drive() {
    const cogrsim::PolicyActions& a = card_->actions;
    for (std::size_t i = 0; i < motors_.size(); ++i) {
      const double q = measured_.positions[i], speed = measured_.velocities[i];
      double value = target_[i];
      if (gains_ && motors_[i].mode() == cogrsim::MotorMode::torque) {
        value = a.kind == PolicyActionKind::velocity ? a.kd[i] * (target_[i] - speed)
                                                     : a.kp[i] * (target_[i] - q) - a.kd[i] * speed;
        value = a.limited(i, value, speed);
      } else if (a.kind == PolicyActionKind::torque) {
        value = a.limited(i, value, speed);
      }
      motors_[i].set(value);
    }
  }

  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  cogrsim::PoseSensor base_;
  std::shared_ptr<const cogrsim::PolicyCard> card_;
  std::shared_ptr<const cogrsim::PolicyNetwork> network_;
  std::vector<cogrsim::MotorHandle> motors_;
  Values command_;
  std::vector<cogrsim::InputHandle> asked_;  // of the command; empty: it stays
  bool gains_ = false;
  std::vector<std::vector<float>> inputs_;  // of the network
  cogrsim::PolicyPorts ports_;
  std::optional<cogrsim::PolicyObserver> observer_;
  double step_ = 0.0;
  std::uint64_t decimation_ = 1, steps_ = 0;
  cogrsim::PolicyMeasured measured_;
  Values raw_, clipped_, target_;
  std::deque<Pending> pending_;
};

}  // namespace
}  // namespace policy_plugin

COGRSIM_CONTROLLER(policy_plugin::Policy, "policy", version("1.0.0"), author("CogRSim"),
                   summary("drives a robot by a trained network"),
                   parameter("card", "", "policy card, relative to the scene").must_be_set(),
                   parameter("base", "base",
                             "name of a pose sensor at the base that the card names"),
                   parameter("command", std::vector<double>{}, "",
                             "what is asked of the policy; by default the card's"),
                   parameter("change", "",
                             "values in place of the card's, lines such as actions.delay=20 ms"))
