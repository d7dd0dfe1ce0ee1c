#include "control/process/proxy.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/rendering/renderer.h"
#include "core/index.h"
#include "model/model_json.h"
#include "model/motor_limits.h"

namespace cogrsim {

namespace {

template <class Elements>
std::vector<int> inside(const SceneModel& model, int assembly, const Elements& elements) {
  const std::string prefix = assembly < 0 ? "" : model.assemblies[at(assembly)].name + ".";
  std::vector<int> out;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (!elements[i].removed && elements[i].name.compare(0, prefix.size(), prefix) == 0) {
      out.push_back(static_cast<int>(i));
    }
  }
  return out;
}

enum class PictureMark : std::uint8_t { none, same, fresh };

void put_vector(WireWriter& out, const Vec3& v) { out.bytes(v.data(), 3 * sizeof(double)); }
void get_vector(WireReader& in, Vec3& v) { in.bytes(v.data(), 3 * sizeof(double)); }

void put_picture(WireWriter& out, const Picture& picture) {
  out.put(picture.width);
  out.put(picture.height);
  out.put(picture.color.width);
  out.put(picture.color.height);
  out.put(picture.color.channels);
  out.put(picture.color.data);
  out.put(picture.depth);
  out.put(picture.bodies);
}

std::shared_ptr<const Picture> get_picture(WireReader& in) {
  auto picture = std::make_shared<Picture>();
  in.get(picture->width);
  in.get(picture->height);
  in.get(picture->color.width);
  in.get(picture->color.height);
  in.get(picture->color.channels);
  in.get(picture->color.data);
  in.get(picture->depth);
  in.get(picture->bodies);
  return picture;
}

void put_contacts(WireWriter& out, const std::vector<Contact>& contacts) {
  out.put(static_cast<std::uint64_t>(contacts.size()));
  for (const Contact& c : contacts) {
    for (const int index : {c.body_a, c.body_b, c.shape_a, c.shape_b}) out.put(index);
    put_vector(out, c.point);
    put_vector(out, c.normal);
    out.put(c.depth);
    put_vector(out, c.force);
  }
}

void get_contacts(WireReader& in, std::vector<Contact>& contacts) {
  contacts.resize(in.length(4 * sizeof(int) + 10 * sizeof(double)));
  for (Contact& c : contacts) {
    for (int* index : {&c.body_a, &c.body_b, &c.shape_a, &c.shape_b}) in.get(*index);
    get_vector(in, c.point);
    get_vector(in, c.normal);
    in.get(c.depth);
    get_vector(in, c.force);
  }
}

// After the call in which they were declared, and not again: an empty list says nothing.
void put_inputs(WireWriter& out, const std::vector<ControllerInput>& inputs) {
  out.put(static_cast<std::uint64_t>(inputs.size()));
  for (const ControllerInput& input : inputs) {
    out.put(input.name);
    out.put(input.unit);
    for (const double value : {input.lower, input.upper, input.value}) out.put(value);
  }
}

// False: a controller could not have declared them.
bool take_inputs(WireReader& in, std::vector<ControllerInput>& inputs) {
  const std::size_t count = in.length(2 * sizeof(std::uint64_t) + 3 * sizeof(double));
  for (std::size_t i = 0; i < count && in.good(); ++i) {
    ControllerInput input;
    in.get(input.name);
    in.get(input.unit);
    for (double* value : {&input.lower, &input.upper, &input.value}) in.get(*value);
    input.start = input.value;
    if (!in.good() || !input_mistake(inputs, input).empty()) return false;
    inputs.push_back(std::move(input));
  }
  return true;
}

}  // namespace

DeviceIndices::DeviceIndices(const SceneModel& model, int assembly)
    : motors(inside(model, assembly, model.motors)),
      sensors(inside(model, assembly, model.sensors)) {}

const std::string& SceneForControllers::of(const SceneModelPtr& now,
                                           const SceneModelPtr& at_start) {
  if (model == now && original == at_start) return text;
  model = now;
  original = at_start;
  SceneModel scene;
  scene.name = now->name;
  scene.files = now->files;
  scene.set_parameters = at_start->set_parameters;
  scene.physics = now->physics;
  scene.physics.seed = at_start->physics.seed;
  scene.assemblies = now->assemblies;
  scene.bodies = now->bodies;
  for (Body& body : scene.bodies) body.shapes.clear();
  scene.joints = now->joints;
  scene.motors = now->motors;
  scene.sensors = now->sensors;
  scene.controllers = now->controllers;
  scene.mazes = at_start->mazes;
  scene.joint_positions = now->joint_positions;
  scene.joint_speeds = now->joint_speeds;
  text = model_to_json(scene);
  return text;
}

void ProxyWriter::put_scene(WireWriter& out) {
  const DevicePort& port = *access_.port;
  const bool fresh = shown_ != port.model();
  out.put(fresh);
  if (!fresh) return;
  shown_ = port.model();
  devices_ = DeviceIndices(*shown_, access_.assembly);
  pictures_.assign(devices_.sensors.size(), nullptr);
  out.put(scene_.of(port.model(), port.original()));
}

void ProxyWriter::put_state(WireWriter& out) {
  DevicePort& port = *access_.port;
  out.put(access_.random->state());
  out.put(access_.outputs);
  std::vector<double> inputs;
  for (const ControllerInput& input : access_.inputs) inputs.push_back(input.value);
  out.put(inputs);
  for (const int motor : devices_.motors) {
    out.put(port.target(motor));
    out.put(port.effort(motor));
    out.put(port.joint_position(motor));
    out.put(port.joint_velocity(motor));
  }
  for (std::size_t i = 0; i < devices_.sensors.size(); ++i) {
    const Reading& reading = port.reading(devices_.sensors[i]);
    out.put(reading.time);
    out.put(reading.sequence);
    out.put(reading.valid);
    out.put(reading.enabled);
    out.put(reading.values);
    put_contacts(out, reading.contacts);
    if (!reading.picture) {
      out.put(PictureMark::none);
    } else if (reading.picture == pictures_[i]) {
      out.put(PictureMark::same);
    } else {
      out.put(PictureMark::fresh);
      put_picture(out, *reading.picture);
      pictures_[i] = reading.picture;
    }
  }
}

bool ProxyWriter::take_effects(WireReader& in) {
  // Everything is read first, so that inconsistent data from a damaged process have no effect.
  const auto random = in.take<std::uint64_t>();
  std::vector<double> outputs, targets(devices_.motors.size());
  in.get(outputs);
  std::vector<char> set(targets.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    in.get(targets[i]);
    set[i] = in.take<bool>();
  }
  struct Switch {
    bool enabled = false, was_off = false;
  };
  std::vector<Switch> switches(devices_.sensors.size());
  for (Switch& one : switches) {
    in.get(one.enabled);
    in.get(one.was_off);
  }
  std::vector<int> asked;
  std::vector<std::string> sources, reports, mistakes;
  std::optional<std::string> fault;
  in.get(asked);
  in.get(sources);
  in.get(reports);
  in.get(mistakes);
  in.get(fault);
  std::vector<ControllerInput> inputs;
  const bool fits =
      take_inputs(in, inputs) && in.good() && outputs.size() == access_.outputs.size() &&
      sources.size() == reports.size() &&
      std::all_of(targets.begin(), targets.end(), [](double t) { return std::isfinite(t); }) &&
      std::all_of(asked.begin(), asked.end(), [&](int motor) {
        return std::binary_search(devices_.motors.begin(), devices_.motors.end(), motor);
      });
  if (!fits) return false;

  access_.random->set_state(random);
  access_.outputs = std::move(outputs);
  DevicePort& port = *access_.port;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (set[i]) port.set_target(devices_.motors[i], targets[i]);
  }
  for (std::size_t i = 0; i < switches.size(); ++i) {
    const int sensor = devices_.sensors[i];
    // Off and on again ends the reading, and those that are on their way.
    if (switches[i].was_off) port.enable(sensor, false);
    if (port.reading(sensor).enabled != switches[i].enabled)
      port.enable(sensor, switches[i].enabled);
  }
  access_.motors = std::move(asked);
  for (std::size_t i = 0; i < reports.size(); ++i) port.report(sources[i], reports[i]);
  access_.mistakes = std::move(mistakes);
  access_.fault = std::move(fault);
  if (!access_.configured) access_.inputs = std::move(inputs);
  return true;
}

void RemoteDevices::set_target(int motor, double target) {
  motors_[at(motor)].target = clamp_target(*model_, model_->motors[at(motor)], target);
  motors_[at(motor)].set = true;
}

void RemoteDevices::enable(int sensor, bool on) {
  Reading& reading = readings_[at(sensor)];
  reading.enabled = on;
  if (on) return;
  reading.valid = false;
  was_off_[at(sensor)] = true;
}

void RemoteDevices::report(const std::string& source, const std::string& message) {
  // The log of the run stores fewer and notes that messages are missing.
  constexpr std::size_t kMost = 2000;
  if (reports_.size() >= kMost) return;
  sources_.push_back(source);
  reports_.push_back(message);
}

void RemoteDevices::take_scene(WireReader& in) {
  if (!in.take<bool>()) return;
  std::string text;
  in.get(text);
  auto model = model_from_json(text);
  if (!in.good() || !model) return in.spoil();
  model_ = std::make_shared<SceneModel>(std::move(*model));
  // The controller may keep pointers to the mazes of the first scene.
  if (!original_) original_ = model_;
  motors_.resize(model_->motors.size());
  for (MotorCopy& motor : motors_) motor = {motor.target};  // removed motors have no state
  readings_.assign(model_->sensors.size(), Reading());
  was_off_.assign(readings_.size(), false);
  for (std::size_t i = 0; i < readings_.size(); ++i) readings_[i].sensor = static_cast<int>(i);
  fresh_ = true;
}

void RemoteDevices::take_reading(WireReader& in, std::size_t device) {
  Reading& reading = readings_[at(devices_.sensors[device])];
  in.get(reading.time);
  in.get(reading.sequence);
  in.get(reading.valid);
  in.get(reading.enabled);
  in.get(reading.values);
  get_contacts(in, reading.contacts);
  switch (static_cast<PictureMark>(in.take<std::uint8_t>())) {
    case PictureMark::none:
      reading.picture.reset();
      break;
    case PictureMark::same:
      reading.picture = pictures_[device];
      break;
    case PictureMark::fresh:
      reading.picture = pictures_[device] = get_picture(in);
      break;
  }
}

void RemoteDevices::take_state(WireReader& in, AssemblyAccess& access) {
  if (std::exchange(fresh_, false)) {
    devices_ = DeviceIndices(*model_, access.assembly);
    pictures_.assign(devices_.sensors.size(), nullptr);
  }
  access.random->set_state(in.take<std::uint64_t>());
  in.get(access.outputs);
  std::vector<double> inputs;
  in.get(inputs);
  for (std::size_t i = 0; i < inputs.size() && i < access.inputs.size(); ++i)
    access.inputs[i].value = inputs[i];
  for (const int index : devices_.motors) {
    MotorCopy& motor = motors_[at(index)];
    for (double* value : {&motor.target, &motor.effort, &motor.position, &motor.velocity}) {
      in.get(*value);
    }
    motor.set = false;
  }
  for (std::size_t i = 0; i < devices_.sensors.size(); ++i) take_reading(in, i);
}

void RemoteDevices::put_effects(WireWriter& out, AssemblyAccess& access) {
  out.put(access.random->state());
  out.put(access.outputs);
  for (const int motor : devices_.motors) {
    out.put(target(motor));
    out.put(motors_[at(motor)].set);
  }
  for (const int sensor : devices_.sensors) {
    out.put(reading(sensor).enabled);
    out.put(static_cast<bool>(was_off_[at(sensor)]));
    was_off_[at(sensor)] = false;
  }
  out.put(access.motors);
  out.put(std::exchange(sources_, {}));
  out.put(std::exchange(reports_, {}));
  out.put(std::exchange(access.mistakes, {}));
  out.put(std::exchange(access.fault, std::nullopt));
  const bool more = std::exchange(declared_, access.inputs.size()) != access.inputs.size();
  put_inputs(out, more ? access.inputs : std::vector<ControllerInput>());
}

}  // namespace cogrsim
