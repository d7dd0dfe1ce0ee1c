// Learns to crawl: tries what its arm can do, and keeps what moved it forward.
#include <cogrsim/algorithms/learner.h>
#include <cogrsim/control/controller.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <stdexcept>

class Crawler final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;
    shoulder_ = robot.motor("shoulder");
    elbow_ = robot.motor("elbow");
    place_ = robot.sensor<cogrsim::PoseSensor>("place");
    school_ = robot.parameter<double>("school");
    cogrsim::Parameters wanted;
    wanted["rate"] = robot.parameter<double>("rate");
    wanted["initial"] = robot.parameter<double>("initial");
    wanted["discount"] = robot.parameter<double>("discount");
    wanted["exploration"] = robot.parameter<double>("exploration");
    learner_ = robot.algorithm<cogrsim::Learner>(robot.parameter<std::string>("learner"), wanted);
  }

  // One update is one action: the last one has been done by now. What did it bring?
  void update(const cogrsim::Tick& tick) override {
    if (!place_.valid()) return;
    const double x = place_.pose().p.x();
    const bool trying = tick.time < school_;
    const int action = check(learner_->choose(state(), kActions, trying));
    if (state_before_ >= 0) {
      const double reward = 100.0 * (x - x_before_);  // [cm]
      check(learner_->learn({state_before_, action_before_, reward, state(), false, action}));
    }
    robot_->publish("gain", x - x_before_);
    state_before_ = state();
    action_before_ = action;
    x_before_ = x;
    // 0 and 1 lower and raise the shoulder, 2 and 3 stretch and bend the elbow; at an end nothing happens.
    int& joint = action < 2 ? up_ : bent_;
    joint = std::min(kPlaces - 1, std::max(0, joint + (action % 2 == 0 ? -1 : 1)));
    shoulder_.set(kShoulder[static_cast<std::size_t>(up_)]);
    elbow_.set(kElbow[static_cast<std::size_t>(bent_)]);
  }

 private:
  static constexpr int kPlaces = 4, kActions = 4;
  static constexpr std::array<double, kPlaces> kShoulder = {0.0, 0.35, 0.7, 1.05};  // [rad]
  static constexpr std::array<double, kPlaces> kElbow = {1.05, 1.48, 1.92, 2.36};   // [rad]

  std::int64_t state() const { return up_ * kPlaces + bent_; }
  // An error of the learner is our mistake; thrown, it is reported with robot and time.
  template <class Value>
  static Value check(cogrsim::Result<Value> result) {
    if (!result) throw std::runtime_error(result.error().text());
    return *result;
  }
  static void check(const cogrsim::Result<>& result) {
    if (!result) throw std::runtime_error(result.error().text());
  }

  std::optional<cogrsim::Assembly> robot_;
  cogrsim::MotorHandle shoulder_, elbow_;
  cogrsim::PoseSensor place_;
  std::shared_ptr<cogrsim::Learner> learner_;
  double school_ = 0.0;
  int up_ = 3, bent_ = 0;
  std::int64_t state_before_ = -1;
  int action_before_ = 0;
  double x_before_ = 0.0;
};

COGRSIM_CONTROLLER(
    Crawler, "crawler", version("1.0.0"), author("you"), summary("learns to crawl"),
    parameter("school", 120.0, "s", "for so long it tries things out").range(0.0, 1e6),
    parameter("learner", "q_learning", "who learns"),
    parameter("rate", 0.3, "1", "how much one experience counts").range(1e-6, 1.0),
    parameter("discount", 0.9, "1", "worth of a reward one action later").range(0.0, 1.0),
    parameter("initial", 3.0, "1", "value of what was never tried").range(-1e3, 1e3),
    parameter("exploration", 0.4, "1", "share of actions by lot, at school").range(0.0, 1.0),
    output("gain", "m", "of the last action"))
