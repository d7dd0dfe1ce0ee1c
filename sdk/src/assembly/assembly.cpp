#include "cogrsim/assembly/assembly.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "assembly/assembly_access.h"
#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/core/constants.h"
#include "cogrsim/core/shown_text.h"
#include "cogrsim/sensing/sensor_models.h"
#include "core/index.h"
#include "model/motor_limits.h"

namespace cogrsim {

namespace {

std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "'" : ", '") + name + "'";
  return out.empty() ? "none" : out;
}

std::string not_there(const std::string& kind, const std::string& name,
                      const std::vector<std::string>& names) {
  const std::string near = nearest_name(name, names);
  return "there is no " + kind + " '" + name + "'" +
         (near.empty() ? "" : ", did you mean '" + near + "'?") + "; it has " + listed(names);
}

/// Names of the elements inside an assembly, without the name of the assembly in front.
template <class Elements>
std::vector<std::string> names_inside(const SceneModel& model, int assembly,
                                      const Elements& elements) {
  const std::string prefix = assembly < 0 ? "" : model.assemblies[at(assembly)].name + ".";
  std::vector<std::string> names;
  for (const auto& element : elements) {
    if (!element.removed && element.name.compare(0, prefix.size(), prefix) == 0) {
      names.push_back(element.name.substr(prefix.size()));
    }
  }
  return names;
}

template <class Elements>
int find_inside(const SceneModel& model, int assembly, const Elements& elements,
                const std::string& name) {
  const std::string full = assembly < 0 ? name : model.assemblies[at(assembly)].name + "." + name;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (!elements[i].removed && elements[i].name == full) return static_cast<int>(i);
  }
  return -1;
}

const Motor& motor_of(const AssemblyAccess& access, int index) {
  return access.port->model()->motors[at(index)];
}

}  // namespace

void MotorHandle::set(double target) {
  if (!access_) return;
  if (std::isfinite(target)) return access_->port->set_target(motor_, target);
  if (access_->fault) return;
  access_->fault = fmt::format("sent {} to motor '{}'; its target stays {}", target,
                               motor_of(*access_, motor_).name, access_->port->target(motor_));
}

double MotorHandle::target() const { return access_ ? access_->port->target(motor_) : kNaN; }

double MotorHandle::effort() const { return access_ ? access_->port->effort(motor_) : kNaN; }

MotorMode MotorHandle::mode() const {
  return access_ ? motor_of(*access_, motor_).mode : MotorMode::velocity;
}

double MotorHandle::max_speed() const {
  return access_ ? motor_max_speed(*access_->port->model(), motor_of(*access_, motor_)) : 0.0;
}

double MotorHandle::max_effort() const {
  return access_ ? motor_max_effort(*access_->port->model(), motor_of(*access_, motor_)) : 0.0;
}

double MotorHandle::max_voltage() const {
  return access_ ? motor_of(*access_, motor_).max_voltage : 0.0;
}

const std::string& MotorHandle::joint() const {
  static const std::string none;
  return access_ ? access_->port->model()->joints[at(motor_of(*access_, motor_).joint)].name : none;
}

double MotorHandle::lower() const {
  const JointAxis* axis =
      access_ ? driven_axis(*access_->port->model(), motor_of(*access_, motor_)) : nullptr;
  return axis ? axis->lower : -kInfinity;
}

double MotorHandle::upper() const {
  const JointAxis* axis =
      access_ ? driven_axis(*access_->port->model(), motor_of(*access_, motor_)) : nullptr;
  return axis ? axis->upper : kInfinity;
}

const Reading& SensorHandle::reading() const {
  static const Reading kNone;
  return access_ ? access_->port->reading(sensor_) : kNone;
}

bool SensorHandle::valid() const { return access_ && reading().valid; }

const std::string& SensorHandle::type() const {
  static const std::string kNone;
  return access_ ? description().type : kNone;
}

double SensorHandle::time() const { return access_ ? reading().time : kNaN; }

std::uint64_t SensorHandle::sequence() const { return reading().sequence; }

double SensorHandle::value(int channel) const {
  if (!valid() || channel < 0) return kNaN;
  const auto& values = reading().values;
  const auto index = static_cast<std::size_t>(channel);
  return index < values.size() ? values[index] : kNaN;
}

void SensorHandle::enable(bool on) {
  if (access_) access_->port->enable(sensor_, on);
}

std::string SensorHandle::body_name(int body) const {
  if (!access_ || body < 0) return "";
  const std::vector<Body>& bodies = access_->port->model()->bodies;
  return at(body) < bodies.size() ? bodies[at(body)].name : "";
}

const SensorModel& SensorHandle::description() const {
  return access_->port->model()->sensors[at(sensor_)];
}

std::string Infrared::body() const {
  return valid() ? body_name(static_cast<int>(value(1))) : std::string();
}

std::size_t Lidar::size() const {
  if (directions_.empty() && bound()) directions_ = ray_directions(description());
  return directions_.size();
}

std::vector<double> Lidar::ranges() const {
  if (!valid()) return {};
  const std::vector<double>& values = reading().values;
  return {values.begin(), values.begin() + static_cast<std::ptrdiff_t>(size())};
}

Vec3 Lidar::direction(std::size_t ray) const {
  return ray < size() ? directions_[ray] : Vec3::UnitX();
}

std::vector<std::string> ContactSensor::bodies() const {
  std::vector<std::string> names;
  if (!valid()) return names;
  for (const Contact& contact : reading().contacts) names.push_back(body_name(contact.body_a));
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

const std::string& Assembly::name() const { return access_->name; }

std::vector<std::string> Assembly::motor_names() const {
  const SceneModel& model = *access_->port->model();
  return names_inside(model, access_->assembly, model.motors);
}

std::vector<std::string> Assembly::sensor_names() const {
  const SceneModel& model = *access_->port->model();
  return names_inside(model, access_->assembly, model.sensors);
}

MotorHandle Assembly::motor(const std::string& name) {
  const SceneModel& model = *access_->port->model();
  const int index = find_inside(model, access_->assembly, model.motors, name);
  if (index < 0) {
    access_->mistakes.push_back(not_there("motor", name, motor_names()));
    return {};
  }
  access_->motors.push_back(index);
  return {access_.get(), index};
}

MotorHandle Assembly::motor(const std::string& name, MotorMode mode) {
  const MotorHandle handle = motor(name);
  if (handle.valid() && handle.mode() != mode)
    fail("motor '" + name + "' has mode \"" + to_string(handle.mode()) + "\": expected mode \"" +
         to_string(mode) + "\"");
  return handle;
}

SensorHandle Assembly::any_sensor(const std::string& name) {
  SensorHandle handle;
  bind(handle, name, nullptr);
  return handle;
}

void Assembly::bind(SensorHandle& handle, const std::string& name, const char* type) {
  const SceneModel& model = *access_->port->model();
  const int index = find_inside(model, access_->assembly, model.sensors, name);
  if (index < 0) {
    access_->mistakes.push_back(not_there("sensor", name, sensor_names()));
    return;
  }
  const SensorModel& sensor = model.sensors[at(index)];
  if (type && sensor.type != type) {
    access_->mistakes.push_back("sensor '" + name + "' is of type '" + sensor.type +
                                "', and was asked for as '" + type + "'");
    return;
  }
  handle.access_ = access_.get();
  handle.sensor_ = index;
}

const ParameterValue* Assembly::find_parameter(const std::string& name, ParameterType type) {
  for (const ParameterSpec& spec : *access_->table) {
    if (spec.name != name) continue;
    if (spec.type() == type) return &access_->parameters.at(name);
    access_->mistakes.push_back("parameter '" + name + "' is declared as " +
                                to_string(spec.type()) + ", and was asked for as " +
                                to_string(type));
    return nullptr;
  }
  std::vector<std::string> names;
  for (const ParameterSpec& spec : *access_->table) names.push_back(spec.name);
  access_->mistakes.push_back(not_there("declared parameter", name, names));
  return nullptr;
}

template <>
double Assembly::parameter<double>(const std::string& name) {
  const ParameterValue* value = find_parameter(name, ParameterType::number);
  return value ? std::get<double>(*value) : 0.0;
}

template <>
int Assembly::parameter<int>(const std::string& name) {
  const ParameterValue* value = find_parameter(name, ParameterType::integer);
  return value ? static_cast<int>(std::get<std::int64_t>(*value)) : 0;
}

template <>
bool Assembly::parameter<bool>(const std::string& name) {
  const ParameterValue* value = find_parameter(name, ParameterType::boolean);
  return value && std::get<bool>(*value);
}

template <>
std::string Assembly::parameter<std::string>(const std::string& name) {
  const ParameterValue* value = find_parameter(name, ParameterType::text);
  return value ? std::get<std::string>(*value) : std::string();
}

template <>
std::vector<double> Assembly::parameter<std::vector<double>>(const std::string& name) {
  const ParameterValue* value = find_parameter(name, ParameterType::number_list);
  return value ? std::get<std::vector<double>>(*value) : std::vector<double>();
}

double Assembly::joint_position(const MotorHandle& motor) const {
  return motor.valid() ? access_->port->joint_position(motor.motor_) : kNaN;
}

double Assembly::joint_velocity(const MotorHandle& motor) const {
  return motor.valid() ? access_->port->joint_velocity(motor.motor_) : kNaN;
}

std::uint64_t Assembly::seed() const { return access_->port->original()->physics.seed; }

const std::string& Assembly::backend() const { return access_->port->original()->physics.backend; }

const std::map<std::string, std::string>& Assembly::set_parameters() const {
  return access_->port->original()->set_parameters;
}

std::string Assembly::scene_folder() const {
  const SceneModel& model = *access_->port->model();
  if (model.files.empty()) return "";
  const std::size_t slash = model.files.front().find_last_of('/');
  return slash == std::string::npos ? "." : model.files.front().substr(0, slash);
}

void Assembly::report(const std::string& message) {
  access_->port->report("controller '" + access_->plugin + "' of '" + access_->name + "'", message);
}

const MazeModel* Assembly::maze(const std::string& name) {
  // From the original scene, because later models of the run may be destroyed while a controller
  // uses the maze.
  const std::vector<MazeModel>& mazes = access_->port->original()->mazes;
  std::vector<std::string> names;
  for (const MazeModel& maze : mazes) {
    if (maze.name == name || (name.empty() && mazes.size() == 1)) return &maze;
    names.push_back(maze.name);
  }
  access_->mistakes.push_back(not_there("maze", name, names));
  return nullptr;
}

double InputHandle::value() const { return access_ ? access_->inputs[input_].value : 0.0; }

InputHandle Assembly::input(const std::string& name, double value, double lower, double upper,
                            const std::string& unit) {
  if (access_->configured) {
    access_->fault =
        "input '" + one_line(name.substr(0, 100)) + "' is declared after configure() has ended";
    return {};
  }
  ControllerInput input{name, unit, lower, upper, value};
  if (std::string wrong = input_mistake(access_->inputs, input); !wrong.empty()) {
    access_->mistakes.push_back(std::move(wrong));
    return {};
  }
  access_->inputs.push_back(std::move(input));
  return {access_.get(), access_->inputs.size() - 1};
}

void Assembly::publish(const std::string& output, double value) {
  auto wrong = publish_output(*access_->declared, output, value, access_->outputs);
  if (wrong) access_->fault = std::move(wrong);
}

double Assembly::uniform(double low, double high) { return access_->random->uniform(low, high); }

void Assembly::fail(const std::string& message) { access_->mistakes.push_back(message); }

std::shared_ptr<void> Assembly::find_algorithm(const std::string& name, const char* family,
                                               const Parameters& parameters) {
  DevicePort& port = *access_->port;
  // Two algorithms of a controller, and two controllers with the same algorithm, draw different
  // numbers.
  const std::string path = access_->controller + "." + name;
  const std::uint64_t seed = RandomStream(port.original()->physics.seed, path).next();
  auto made = load_algorithm_of(port.loader(), name, family, parameters, seed,
                                scene_folder().empty() ? "." : scene_folder());
  if (made) return *made;
  std::string mistake = made.error().message;
  if (!made.error().hint.empty()) mistake += "; " + made.error().hint;
  access_->mistakes.push_back(std::move(mistake));
  return nullptr;
}

}  // namespace cogrsim
