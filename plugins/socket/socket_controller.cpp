// A controller in another program, in any language: the simulation waits for it in every update, so
// that a run is the same as with a controller in a library. The exchange is described in
// docs/plugins/any-language.md.
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "cogrsim/control/controller.h"
#include "cogrsim/core/json_bounds.h"
#include "cogrsim/core/shown_text.h"
#include "cogrsim/rendering/renderer.h"
#include "connection.h"

namespace cogrsim::socket_controller {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kProtocol = 1;
constexpr std::size_t kShortestToken = 16;
constexpr int kOutputs = 8;

/// A number as JSON has it; what is not finite becomes "nan", "inf" or "-inf".
Json json_of(double x) {
  if (std::isfinite(x)) return x;
  return std::isnan(x) ? "nan" : x > 0.0 ? "inf" : "-inf";
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static const char* const digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const unsigned block = unsigned{bytes[i]} << 16 | (left > 1 ? unsigned{bytes[i + 1]} << 8 : 0) |
                           (left > 2 ? unsigned{bytes[i + 2]} : 0);
    out += digits[block >> 18];
    out += digits[block >> 12 & 63];
    out += left > 1 ? digits[block >> 6 & 63] : '=';
    out += left > 2 ? digits[block & 63] : '=';
  }
  return out;
}

/// Without a branch on the characters, so that the time does not reveal how many are right.
bool same_secret(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^
                  static_cast<unsigned char>(b.empty() ? 0 : b[i % b.size()]);
  return difference == 0;
}

class SocketController final : public Controller {
 public:
  void configure(Assembly& robot) override {
    robot_ = std::make_unique<Assembly>(robot);
    address_ = robot.parameter<std::string>("connect");
    wait_ = robot.parameter<double>("wait");
    patience_ = robot.parameter<double>("patience");
    motor_names_ = robot.motor_names();
    for (const std::string& name : motor_names_) motors_.push_back(robot.motor(name));
    sensor_names_ = robot.sensor_names();
    for (const std::string& name : sensor_names_) sensors_.push_back(robot.any_sensor(name));
    if (const char* token = std::getenv("COGRSIM_CONTROLLER_TOKEN")) token_ = token;
    if (!token_.empty() && token_.size() < kShortestToken)
      return robot.fail("COGRSIM_CONTROLLER_TOKEN has fewer than 16 characters");
    try {
      listener_ = Listener::at(address_, robot.scene_folder(), !token_.empty());
    } catch (const std::exception& e) {
      robot.fail(e.what());
    }
  }

  void update(const Tick& tick) override {
    if (!connection_) connect();
    const Deadline deadline = after(patience_);
    connection_->send(state(tick).dump(), deadline);
    take(message(deadline));
  }

  ~SocketController() override {
    if (!connection_) return;
    try {
      connection_->send(R"({"type":"end"})", after(1.0));
    } catch (const std::exception&) {  // it has gone already
    }
  }

 private:
  static Deadline after(double seconds) {
    return std::chrono::steady_clock::now() +
           std::chrono::duration_cast<std::chrono::steady_clock::duration>(
               std::chrono::duration<double>(std::min(seconds, 1e6)));
  }

  Json message(Deadline deadline) {
    const std::string text = connection_->receive(deadline);
    if (const std::string excess = json_excess(text); !excess.empty())
      throw std::runtime_error("the client sent a message that " + excess);
    const Json message = Json::parse(text, nullptr, false);
    if (!message.is_object()) throw std::runtime_error("the client sent no JSON object");
    return message;
  }

  /// The client's text of a field, "" if there is none.
  static std::string text(const Json& message, const char* name) {
    const auto found = message.find(name);
    return found != message.end() && found->is_string() ? found->get<std::string>() : "";
  }

  void connect() {
    if (::isatty(STDERR_FILENO) == 1)
      std::fprintf(stderr, "waits for a controller of '%s' at %s\n",
                   one_line(robot_->name()).c_str(), one_line(address_).c_str());
    const Deadline deadline = after(wait_);
    connection_ = listener_->accept(deadline);
    const Json hello = message(deadline);
    if (text(hello, "type") != "hello")
      throw std::runtime_error("the client's first message is not a hello");
    if (!token_.empty() && !same_secret(token_, text(hello, "token"))) {
      connection_->send(R"({"type":"refused","reason":"the token is wrong"})", deadline);
      connection_.reset();
      throw std::runtime_error("the client's token is wrong");
    }
    if (hello.value("protocol", Json()) != kProtocol) {
      connection_->send(R"({"type":"refused","reason":"this is protocol 1"})", deadline);
      connection_.reset();
      throw std::runtime_error("the client has another protocol than 1");
    }
    pictures_ = hello.value("pictures", Json(false)) == true;
    connection_->send(description().dump(), deadline);
  }

  /// What the client needs to know before the first update.
  Json description() const {
    Json out = {{"type", "hello"},         {"protocol", kProtocol},
                {"robot", robot_->name()}, {"backend", robot_->backend()},
                {"seed", robot_->seed()},  {"set", robot_->set_parameters()}};
    out["motors"] = Json::array();
    for (std::size_t i = 0; i < motors_.size(); ++i) {
      const MotorHandle& motor = motors_[i];
      Json one = {{"name", motor_names_[i]},
                  {"mode", to_string(motor.mode())},
                  {"lower", json_of(motor.lower())},
                  {"upper", json_of(motor.upper())},
                  {"max_speed", json_of(motor.max_speed())},
                  {"max_effort", json_of(motor.max_effort())}};
      if (motor.mode() == MotorMode::dc) one["max_voltage"] = json_of(motor.max_voltage());
      out["motors"].push_back(std::move(one));
    }
    out["sensors"] = Json::array();
    for (std::size_t i = 0; i < sensors_.size(); ++i)
      out["sensors"].push_back({{"name", sensor_names_[i]}, {"type", sensors_[i].type()}});
    out["outputs"] = Json::array();
    for (int i = 1; i <= kOutputs; ++i) out["outputs"].push_back("output_" + std::to_string(i));
    return out;
  }

  Json state(const Tick& tick) {
    Json out = {
        {"type", "update"}, {"time", tick.time}, {"period", tick.period}, {"count", tick.count}};
    Json& motors = out["motors"] = Json::array();
    for (const MotorHandle& motor : motors_)
      motors.push_back({{"target", json_of(motor.target())},
                        {"effort", json_of(motor.effort())},
                        {"position", json_of(robot_->joint_position(motor))},
                        {"velocity", json_of(robot_->joint_velocity(motor))}});
    Json& sensors = out["sensors"] = Json::array();
    for (const SensorHandle& sensor : sensors_) {
      Json one = {{"valid", sensor.valid()}};
      if (sensor.valid()) {
        const Reading& reading = sensor.reading();
        one["time"] = reading.time;
        one["sequence"] = reading.sequence;
        Json& values = one["values"] = Json::array();
        for (const double value : reading.values) values.push_back(json_of(value));
        if (pictures_ && reading.picture && !reading.picture->color.data.empty()) {
          const Image& image = reading.picture->color;
          one["picture"] = {{"width", image.width},
                            {"height", image.height},
                            {"channels", image.channels},
                            {"data", base64(image.data)}};
        }
      }
      sensors.push_back(std::move(one));
    }
    return out;
  }

  void take(const Json& message) {
    if (const std::string fault = text(message, "fault"); !fault.empty())
      throw std::runtime_error(fault);
    if (text(message, "type") != "set")
      throw std::runtime_error("the client sent '" + text(message, "type") +
                               "' where 'set' was expected");
    for (const auto& [name, value] : message.items()) {
      if (name == "targets") {
        set_targets(value);
      } else if (name == "outputs") {
        if (!value.is_object()) throw std::runtime_error("outputs: expected numbers by name");
        for (const auto& [output, number] : value.items()) {
          if (!number.is_number())
            throw std::runtime_error("output '" + output + "': expected a number");
          robot_->publish(output, number.get<double>());
        }
      } else if (name == "report") {
        robot_->report(text(message, "report"));
      } else if (name != "type") {
        throw std::runtime_error("the client sent the unknown field '" + name +
                                 "'; there are targets, outputs, report and fault");
      }
    }
  }

  /// In the order of hello's motors, null: unchanged; or by name.
  void set_targets(const Json& targets) {
    const auto set = [&](std::size_t i, const Json& value) {
      if (value.is_null()) return;
      if (!value.is_number())
        throw std::runtime_error("target of '" + motor_names_[i] + "': expected a number");
      motors_[i].set(value.get<double>());
    };
    if (targets.is_array()) {
      if (targets.size() != motors_.size())
        throw std::runtime_error("targets: expected " + std::to_string(motors_.size()) +
                                 ", one for each motor, found " + std::to_string(targets.size()));
      for (std::size_t i = 0; i < motors_.size(); ++i) set(i, targets[i]);
      return;
    }
    if (!targets.is_object())
      throw std::runtime_error("targets: expected a list, or numbers by the motors' names");
    for (const auto& [name, value] : targets.items()) {
      const auto found = std::find(motor_names_.begin(), motor_names_.end(), name);
      if (found == motor_names_.end()) throw std::runtime_error("there is no motor '" + name + "'");
      set(static_cast<std::size_t>(found - motor_names_.begin()), value);
    }
  }

  std::unique_ptr<Assembly> robot_;
  std::string address_, token_;
  double wait_ = 0.0, patience_ = 0.0;  // [s]
  std::vector<std::string> motor_names_, sensor_names_;
  std::vector<MotorHandle> motors_;
  std::vector<SensorHandle> sensors_;
  bool pictures_ = false;
  std::shared_ptr<Listener> listener_;
  std::unique_ptr<Connection> connection_;
};

}  // namespace

COGRSIM_CONTROLLER(
    SocketController, "socket", version("1.0.0"),
    summary("a controller in another program, over a socket"),
    parameter("connect", "", "unix:PATH inside the scene's folder, or tcp:HOST:PORT").must_be_set(),
    parameter("wait", 60.0, "s", "longest wait for the program").range(0.0, 1e6),
    parameter("patience", 10.0, "s", "longest wall-clock time of an update").range(1e-3, 1e6),
    output("output_1", "1", "as the program defines it"),
    output("output_2", "1", "as the program defines it"),
    output("output_3", "1", "as the program defines it"),
    output("output_4", "1", "as the program defines it"),
    output("output_5", "1", "as the program defines it"),
    output("output_6", "1", "as the program defines it"),
    output("output_7", "1", "as the program defines it"),
    output("output_8", "1", "as the program defines it"))

}  // namespace cogrsim::socket_controller
