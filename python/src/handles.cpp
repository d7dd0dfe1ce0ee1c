// The robot of a controller: motors, sensors, parameters.
#include "handles.h"

#include <algorithm>

#include <fmt/format.h>

#include "cogrsim/control/controller.h"
#include "frame.h"
#include "rendering.h"

namespace cogrsim::python {

namespace {

template <class Handle>
struct PyDevice {
  Assembly assembly;  // keeps what the handle refers to
  Handle handle;
  GatePtr gate;
  std::string name;
  const Handle& get() const {
    gate->check((std::is_same_v<Handle, MotorHandle> ? "motor '" : "sensor '") + name + "'");
    return handle;
  }
};
using PyMotor = PyDevice<MotorHandle>;
using PySensor = PyDevice<SensorHandle>;

struct PyInput {
  Assembly assembly;  // keeps what the handle refers to
  InputHandle handle;
  GatePtr gate;
  std::string name;
};

Assembly& robot(PyAssembly& self) {
  self.gate->check("'" + self.assembly.name() + "'");
  return self.assembly;
}

py::object parameter(PyAssembly& self, const std::string& name) {
  Assembly& of = robot(self);
  std::vector<std::string> names;
  for (const ParameterSpec& spec : *self.table) {
    names.push_back(spec.name);
    if (spec.name != name) continue;
    switch (spec.type()) {
      case ParameterType::boolean:
        return py::bool_(of.parameter<bool>(name));
      case ParameterType::integer:
        return py::int_(of.parameter<int>(name));
      case ParameterType::number:
        return py::float_(of.parameter<double>(name));
      case ParameterType::text:
        return py::str(of.parameter<std::string>(name));
      case ParameterType::number_list:
        return py::cast(of.parameter<std::vector<double>>(name));
    }
  }
  raise_unknown("parameter", name, names);
}

/// The handle of a sensor of this type; its owner was asked for it before.
template <class Handle>
Handle typed(const PySensor& self) {
  if (self.get().type() != Handle::kType)
    throw py::attribute_error("sensor '" + self.name + "' is no " + Handle::kType);
  Assembly assembly = self.assembly;
  return assembly.sensor<Handle>(self.name);
}

PicturePtr picture_of(const PySensor& self) {
  return self.get().valid() ? self.get().reading().picture : nullptr;
}

std::shared_ptr<const std::vector<Contact>> contacts(const PySensor& self) {
  return std::make_shared<const std::vector<Contact>>(self.get().reading().contacts);
}

}  // namespace

void Gate::check(const std::string& what) const {
  if (open && thread == std::this_thread::get_id()) return;
  throw std::runtime_error(what +
                           " can only be used inside the calls of its controller, supervisor or "
                           "sensor, and in their thread");
}

py::object to_python(const ParameterValue& value) {
  return std::visit([](const auto& v) -> py::object { return py::cast(v); }, value);
}

void bind_handles(py::module_& m) {
  py::class_<Tick>(m, "Tick", "Timing of an update.")
      .def_readonly("time", &Tick::time, "Time of the measured frame [s]")
      .def_readonly("period", &Tick::period, "Time since the previous update [s]")
      .def_readonly("count", &Tick::count, "Number of previous updates")
      .def("__repr__",
           [](const Tick& t) { return fmt::format("<Tick {} at {:.6g} s>", t.count, t.time); });

  py::class_<PyMotor>(m, "Motor", "A motor of a robot, for its controller.")
      .def_readonly("name", &PyMotor::name, "Name inside the assembly")
      .def(
          "set",
          [](PyMotor& self, double target) {
            self.get();
            self.handle.set(target);
          },
          py::arg("target"),
          "Set the target from the next step on, in the unit of the mode; clamped to the limits. A "
          "value\n"
          "that is not finite is a fault.")
      .def_property_readonly(
          "target", [](const PyMotor& s) { return s.get().target(); },
          "The present target, in the unit of the mode")
      .def_property_readonly(
          "effort", [](const PyMotor& s) { return s.get().effort(); },
          "Mean during the last step [N m] or [N]")
      .def_property_readonly(
          "mode", [](const PyMotor& s) { return to_string(s.get().mode()); },
          "'velocity', 'torque', 'position', 'servo' or 'dc'")
      .def_property_readonly(
          "max_speed", [](const PyMotor& s) { return s.get().max_speed(); },
          "[rad/s] or [m/s]; inf: no limit")
      .def_property_readonly(
          "max_effort", [](const PyMotor& s) { return s.get().max_effort(); },
          "[N m] or [N]; inf: no limit")
      .def_property_readonly(
          "max_voltage", [](const PyMotor& s) { return s.get().max_voltage(); },
          "Of mode 'dc' [V]; inf: no limit")
      .def_property_readonly(
          "lower", [](const PyMotor& s) { return s.get().lower(); },
          "Lower limit of the driven joint axis [rad] or [m]; -inf: none")
      .def_property_readonly(
          "upper", [](const PyMotor& s) { return s.get().upper(); },
          "Upper limit of the driven joint axis [rad] or [m]; inf: none")
      .def_property_readonly(
          "valid", [](const PyMotor& s) { return s.get().valid(); },
          "False: the assembly has no such motor, or it was removed")
      .def_property_readonly(
          "joint_position", [](const PyMotor& s) { return s.assembly.joint_position(s.get()); },
          "Position of the driven joint axis at the end of the last step [rad] or [m]")
      .def_property_readonly(
          "joint_velocity", [](const PyMotor& s) { return s.assembly.joint_velocity(s.get()); },
          "Speed of that axis [rad/s] or [m/s]")
      .def("__repr__", [](const PyMotor& s) { return "<Motor '" + s.name + "'>"; });

  py::class_<PySensor>(m, "SensorHandle", "A sensor of a robot, for its controller.")
      .def_readonly("name", &PySensor::name, "Name inside the assembly")
      .def_property_readonly(
          "type", [](const PySensor& s) { return s.get().type(); },
          "Kind of the sensor, such as 'lidar', or the name of its plugin")
      .def_property_readonly(
          "valid", [](const PySensor& s) { return s.get().valid(); },
          "False: no measurement yet, switched off, dropped out, or there is no such sensor")
      .def_property_readonly(
          "time", [](const PySensor& s) { return s.get().time(); },
          "Time of the measured frame [s]")
      .def_property_readonly(
          "sequence", [](const PySensor& s) { return s.get().sequence(); },
          "Number of readings so far")
      .def(
          "value", [](const PySensor& s, int channel) { return s.get().value(channel); },
          py::arg("channel"), "Value of a channel by its index; NaN if the reading is not valid.")
      .def_property_readonly(
          "values",
          [](const PySensor& s) {
            const std::vector<double>& values = s.get().reading().values;
            return owned(values, {static_cast<py::ssize_t>(values.size())});
          },
          "(nchannel,) float64; empty before the first reading")
      .def_property_readonly(
          "contacts",
          [](const PySensor& s) {
            const auto all = contacts(s);
            return contacts_view(*all, owner_of(all));
          },
          "Of a contact sensor, structured as Frame.contacts")
      .def_property_readonly(
          "image",
          [](const PySensor& s) {
            const PicturePtr picture = picture_of(s);
            return picture ? color_of(picture) : py::none();
          },
          "Of a camera: (height, width, 3) uint8; None: no image")
      .def_property_readonly(
          "depth",
          [](const PySensor& s) {
            const PicturePtr picture = picture_of(s);
            return picture ? depth_of(picture) : py::none();
          },
          "Of a camera with depth: (height, width) float32 [m], inf: background; otherwise None")
      .def_property_readonly(
          "labels",
          [](const PySensor& s) {
            const PicturePtr picture = picture_of(s);
            return picture ? labels_of(picture) : py::none();
          },
          "Of a camera with segmentation: (height, width) int32 body indices, -1: background; "
          "otherwise None")
      .def("_body", [](const PySensor& s) { return typed<Infrared>(s).body(); })
      .def("_bodies", [](const PySensor& s) { return typed<ContactSensor>(s).bodies(); })
      .def("_directions",
           [](const PySensor& s) {
             const Lidar lidar = typed<Lidar>(s);
             std::vector<Vec3> directions;
             for (std::size_t i = 0; i < lidar.size(); ++i)
               directions.push_back(lidar.direction(i));
             return rows_of(directions);
           })
      .def(
          "enable",
          [](PySensor& s, bool on) {
            s.get();
            s.handle.enable(on);
          },
          py::arg("on") = true, "Switch the sensor on or off.")
      .def("__repr__", [](const PySensor& s) { return "<SensorHandle '" + s.name + "'>"; });

  py::class_<PyInput>(m, "InputHandle", "An input of a controller, set by Simulation.set_input().")
      .def_readonly("name", &PyInput::name, "Its name")
      .def_property_readonly(
          "value",
          [](const PyInput& s) {
            s.gate->check("input '" + s.name + "'");
            return s.handle.value();
          },
          "The present value, within its limits")
      .def("__repr__", [](const PyInput& s) { return "<InputHandle '" + s.name + "'>"; });

  py::class_<PyAssembly>(m, "Robot", R"(The assembly of a controller, for configure() and update().

In configure(), a name that does not exist does not raise: the errors are collected, and loading the scene
fails with all of them; later it raises KeyError. Usable only inside the calls of the controller.)")
      .def_property_readonly(
          "name", [](PyAssembly& s) { return robot(s).name(); }, "Dotted name of the assembly")
      .def(
          "motor",
          [](PyAssembly& s, const std::string& name) {
            const MotorHandle motor = robot(s).motor(name);
            if (!s.gate->configuring && !motor.valid())
              raise_unknown("motor", name, robot(s).motor_names());
            return PyMotor{s.assembly, motor, s.gate, name};
          },
          py::arg("name"), "A motor by its name inside the assembly ('left', 'arm.elbow').")
      .def(
          "sensor",
          [](PyAssembly& s, const std::string& name) {
            const std::vector<std::string> names = robot(s).sensor_names();
            if (!s.gate->configuring && std::find(names.begin(), names.end(), name) == names.end())
              raise_unknown("sensor", name, names);
            return PySensor{s.assembly, robot(s).any_sensor(name), s.gate, name};
          },
          py::arg("name"), "A sensor by its name inside the assembly.")
      .def_property_readonly(
          "motors", [](PyAssembly& s) { return robot(s).motor_names(); },
          "Names of all motors, as motor() accepts them")
      .def_property_readonly(
          "sensors", [](PyAssembly& s) { return robot(s).sensor_names(); },
          "Names of all sensors, as sensor() accepts them")
      .def("parameter", &parameter, py::arg("name"),
           "Value of a declared parameter, in SI units. Raises KeyError.")
      .def_property_readonly(
          "seed", [](PyAssembly& s) { return robot(s).seed(); }, "Seed of the run")
      .def_property_readonly(
          "backend", [](PyAssembly& s) { return robot(s).backend(); },
          "Name of the backend that the run is on")
      .def_property_readonly(
          "set_parameters", [](PyAssembly& s) { return robot(s).set_parameters(); },
          "Parameters of the scene that were set when it was compiled, as a dict of texts")
      .def_property_readonly(
          "scene_folder", [](PyAssembly& s) { return robot(s).scene_folder(); },
          "Folder of the scene file, for files that a parameter names; '' for a text")
      .def(
          "input",
          [](PyAssembly& s, const std::string& name, double value, double lower, double upper,
             const std::string& unit) {
            return PyInput{s.assembly, robot(s).input(name, value, lower, upper, unit), s.gate,
                           name};
          },
          py::arg("name"), py::arg("value"), py::arg("lower"), py::arg("upper"),
          py::arg("unit") = "",
          "Declare an input, in configure(): a number with limits that is set while the run goes. "
          "Later\nit is a fault.")
      .def(
          "publish",
          [](PyAssembly& s, const std::string& output, double value) {
            robot(s).publish(output, value);
          },
          py::arg("output"), py::arg("value"), "Set the value of a declared output.")
      .def(
          "uniform",
          [](PyAssembly& s, double low, double high) { return robot(s).uniform(low, high); },
          py::arg("low"), py::arg("high"),
          "A number from [low, high), from the seeded stream of the controller.")
      .def(
          "report", [](PyAssembly& s, const std::string& message) { robot(s).report(message); },
          py::arg("message"), "Report a message to the user.")
      .def(
          "fail", [](PyAssembly& s, const std::string& message) { robot(s).fail(message); },
          py::arg("message"),
          "Report an error of the scene, in configure(): loading fails with it.")
      .def("__repr__", [](const PyAssembly& s) {
        return s.gate->open ? "<Robot '" + s.assembly.name() + "'>"
                            : std::string("<Robot, outside the calls of its controller>");
      });
}

}  // namespace cogrsim::python
