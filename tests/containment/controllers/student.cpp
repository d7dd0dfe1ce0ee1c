// A controller that uses the whole interface of Assembly, and records every bit of the results.
#include <cstring>
#include <memory>
#include <vector>

#include "cogrsim/algorithms/grid_planner.h"
#include "cogrsim/control/controller.h"
#include "cogrsim/core/random.h"
#include "cogrsim/rendering/renderer.h"

namespace {

using namespace cogrsim;

class Student final : public Controller {
 public:
  void configure(Assembly& robot) override {
    robot_ = std::make_unique<Assembly>(robot);
    for (const std::string& name : robot.motor_names()) motors_.push_back(robot.motor(name));
    for (const std::string& name : robot.sensor_names()) {
      sensors_.push_back(robot.any_sensor(name));
    }
    lidar_ = robot.sensor<Lidar>("scan");
    touch_ = robot.sensor<ContactSensor>("touch");
    camera_ = robot.sensor<CameraSensor>("eye");
    infrared_ = robot.sensor<Infrared>("ir");
    planner_ = robot.algorithm<GridPlanner>("a_star");
    note(robot.name());
    note(robot.scene_folder());
    note(robot.parameter<std::string>("word"));
    note(robot.parameter<double>("number"));
    note(robot.parameter<int>("count"));
    note(robot.parameter<bool>("yes") ? 1.0 : 0.0);
    for (const double value : robot.parameter<std::vector<double>>("list")) note(value);
    for (const MotorHandle& motor : motors_) {
      note(static_cast<double>(motor.mode()));
      note(motor.max_speed());
      note(motor.max_effort());
    }
  }

  void update(const Tick& tick) override {
    note(tick.time);
    note(tick.period);
    for (MotorHandle& motor : motors_) {
      note(motor.target());
      note(motor.effort());
      note(robot_->joint_position(motor));
      note(robot_->joint_velocity(motor));
      motor.set(robot_->uniform(-3.0, 3.0));
    }
    for (const SensorHandle& sensor : sensors_) {
      note(sensor.valid() ? 1.0 : 0.0);
      note(sensor.time());
      note(static_cast<double>(sensor.sequence()));
      for (const double value : sensor.reading().values) note(value);
    }
    for (std::size_t i = 0; i < lidar_.size(); ++i) {
      note(lidar_.range(i));
      note(lidar_.direction(i).x());
    }
    for (const Contact& contact : touch_.points()) note(contact.force.z());
    for (const std::string& body : touch_.bodies()) note(body);
    note(infrared_.body());
    if (const auto picture = camera_.picture()) {
      hash_ = hash_bytes(picture->color.data.data(), picture->color.data.size(), hash_);
      hash_ = hash_bytes(picture->depth.data(), picture->depth.size() * sizeof(float), hash_);
      kept_.push_back(picture);  // pictures may be stored as long as needed
      if (kept_.size() > 3) note(static_cast<double>(kept_[kept_.size() - 3]->color.data[7]));
    }
    // Off for every third update, and off and on in one.
    if (tick.count % 3 == 1) sensors_.front().enable(false);
    if (tick.count % 3 == 2) sensors_.front().enable(true);
    if (tick.count % 7 == 3) {
      sensors_.back().enable(false);
      sensors_.back().enable(true);
    }
    if (tick.count % 20 == 5) robot_->report("at " + std::to_string(hash_));
    robot_->publish("number", static_cast<double>(hash_ >> 12));
  }

  std::optional<std::string> save() const override { return std::to_string(hash_); }
  void restore(const std::string& memory) override { hash_ = std::stoull(memory); }

 private:
  void note(double value) { hash_ = hash_bytes(&value, sizeof value, hash_); }
  void note(const std::string& text) { hash_ = hash_bytes(text.data(), text.size(), hash_); }

  std::unique_ptr<Assembly> robot_;
  std::vector<MotorHandle> motors_;
  std::vector<SensorHandle> sensors_;
  Lidar lidar_;
  ContactSensor touch_;
  CameraSensor camera_;
  Infrared infrared_;
  std::shared_ptr<GridPlanner> planner_;
  std::vector<std::shared_ptr<const Picture>> kept_;
  std::uint64_t hash_ = 1469598103934665603ull;
};

}  // namespace

COGRSIM_CONTROLLER(Student, "student", version("1.0.0"), summary("looks at everything"),
                   parameter("word", "hello", "a word"), parameter("number", 1.25, "m", "a number"),
                   parameter("count", 3, "a count"), parameter("yes", true, "a switch"),
                   parameter("list", std::vector<double>{1, 2, 3}, "m", "a list"),
                   output("number", "1", "of all it has seen"))
