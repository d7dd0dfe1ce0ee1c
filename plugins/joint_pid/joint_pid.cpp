// Holds joints at targets with one PID law each. See README.md.
#include <algorithm>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "cogrsim/control/controller.h"
#include "pid.h"

namespace joint_pid {
namespace {

/// Names separated by spaces or commas.
std::vector<std::string> split_names(const std::string& text) {
  std::vector<std::string> out;
  std::string name;
  for (const char c : text + " ") {
    if (c == ' ' || c == ',' || c == '\t' || c == '\n') {
      if (!name.empty()) out.push_back(name);
      name.clear();
    } else {
      name += c;
    }
  }
  return out;
}

class JointPid final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override;
  void update(const cogrsim::Tick& tick) override;
  std::optional<std::string> save() const override;
  void restore(const std::string& memory) override;

 private:
  struct Loop {
    cogrsim::MotorHandle motor;
    Pid pid;
    double target = 0.0;  // [rad] or [m]
  };

  std::vector<double> per_motor(cogrsim::Assembly& robot, const std::string& name,
                                std::size_t motors);

  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  std::vector<Loop> loops_;
};

/// A list parameter with one value for all motors or one for each.
std::vector<double> JointPid::per_motor(cogrsim::Assembly& robot, const std::string& name,
                                        std::size_t motors) {
  auto values = robot.parameter<std::vector<double>>(name);
  if (values.size() == 1) values.resize(motors, values[0]);
  if (values.size() != motors) {
    robot.fail("parameter '" + name + "': expected 1 value or one for each of the " +
               std::to_string(motors) + " motors, found " + std::to_string(values.size()));
    values.resize(motors, 0.0);
  }
  return values;
}

void JointPid::configure(cogrsim::Assembly& robot) {
  robot_ = robot;
  const auto names = split_names(robot.parameter<std::string>("motors"));
  if (names.empty()) {
    robot.fail("parameter 'motors': expected the name of at least one motor");
    return;
  }
  const bool turns = !robot.parameter<std::vector<double>>("target").empty();
  const bool slides = !robot.parameter<std::vector<double>>("travel").empty();
  if (turns == slides) {
    robot.fail(
        "give either 'target' (angles, for joints that turn) or 'travel' (lengths, for "
        "joints that slide)");
    return;
  }
  const auto targets = per_motor(robot, turns ? "target" : "travel", names.size());
  const auto kp = per_motor(robot, "kp", names.size());
  const auto ki = per_motor(robot, "ki", names.size());
  const auto kd = per_motor(robot, "kd", names.size());
  const auto limit = per_motor(robot, "limit", names.size());

  for (std::size_t i = 0; i < names.size(); ++i) {
    Loop loop;
    loop.motor = robot.motor(names[i]);
    if (!loop.motor.valid()) continue;
    const auto mode = loop.motor.mode();
    if (mode == cogrsim::MotorMode::position || mode == cogrsim::MotorMode::servo) {
      robot.fail("motor '" + names[i] + "' has mode \"" + cogrsim::to_string(mode) +
                 "\" and closes its own loop: joint_pid needs a torque, velocity or dc motor");
    }
    double bound = limit[i] > 0 ? limit[i] : std::numeric_limits<double>::infinity();
    if (mode == cogrsim::MotorMode::torque) bound = std::min(bound, loop.motor.max_effort());
    if (mode == cogrsim::MotorMode::velocity) bound = std::min(bound, loop.motor.max_speed());
    loop.pid = Pid({kp[i], ki[i], kd[i], bound});
    loop.target = targets[i];
    loops_.push_back(loop);
  }
}

void JointPid::update(const cogrsim::Tick& tick) {
  for (Loop& loop : loops_) {
    loop.motor.set(loop.pid.update(loop.target, robot_->joint_position(loop.motor),
                                   robot_->joint_velocity(loop.motor), tick.period));
  }
}

// The integrals, in the order of the motors.
std::optional<std::string> JointPid::save() const {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(17);
  for (const Loop& loop : loops_) out << loop.pid.integral_output() << ' ';
  return out.str();
}

void JointPid::restore(const std::string& memory) {
  std::istringstream in(memory);
  in.imbue(std::locale::classic());
  for (Loop& loop : loops_) {
    double integral = 0.0;
    if (!(in >> integral)) {
      throw std::runtime_error("the state has another number of motors than " +
                               std::to_string(loops_.size()));
    }
    loop.pid.set_integral_output(integral);
  }
}

}  // namespace
}  // namespace joint_pid

COGRSIM_CONTROLLER(
    joint_pid::JointPid, "joint_pid", version("1.0.0"), author("CogRSim"),
    summary("holds joints at targets, one PID law each, on torque, velocity or DC motors"),
    parameter("motors", "", "names of the motors, separated by spaces").must_be_set(),
    parameter("target", std::vector<double>{}, "rad", "angles to hold, for joints that turn"),
    parameter("travel", std::vector<double>{}, "m", "positions to hold, for joints that slide"),
    parameter("kp", std::vector<double>{10.0}, "", "output per coordinate, SI").range(0.0, 1e9),
    parameter("ki", std::vector<double>{0.0}, "", "output per coordinate and second, SI")
        .range(0.0, 1e9),
    parameter("kd", std::vector<double>{1.0}, "", "output per speed, SI").range(0.0, 1e9),
    parameter("limit", std::vector<double>{0.0}, "", "limit of the output, SI; 0: the motor's own")
        .range(0.0, 1e12))
