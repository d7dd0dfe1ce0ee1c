// The commands of a running world, as methods of whatever can send them.
#pragma once

#include "cogrsim/control/command.h"
#include "common.h"

namespace cogrsim::python {

/// Adds a method per command to a class. `send(object, command)`. `Self`: how the methods take their
/// object; pybind11 refuses a shared pointer where __init__() was not called.
template <class Self, class Type, class Send>
void add_commands(Type& type, Send send);

/// What the methods are made of.
struct CommandArguments {
  static Command spawn(const std::string& of, const std::string& name, const py::object& position,
                       const py::object& orientation, const py::object& places, double clearance,
                       double lifetime);
  static Command attach(const std::string& name, const std::string& parent,
                        const std::string& child, const std::string& kind, const py::object& point,
                        const py::object& axis, double reach);
  static Command add_assembly(const py::object& scene, const std::string& name,
                              const py::object& position, const py::object& orientation);
  static Command kinematic_twist(const std::string& body, const py::object& velocity,
                                 const py::object& angular_velocity);
  static Command force(const std::string& body, const py::object& force, const py::object& torque,
                       const py::object& point, const std::string& axes, double duration);
};

template <class Self, class Type, class Send>
void add_commands(Type& type, Send send) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto none = py::none();
  type.def(
          "spawn",
          [send](Self self, const std::string& of, const std::string& name,
                 const py::object& position, const py::object& orientation,
                 const py::object& places, double clearance, double lifetime) {
            send(self, CommandArguments::spawn(of, name, position, orientation, places, clearance,
                                               lifetime));
          },
          py::arg("template"), py::arg("name") = "", py::kw_only(), py::arg("position") = none,
          py::arg("orientation") = none, py::arg("places") = none, py::arg("clearance") = 0.0,
          py::arg("lifetime") = infinity,
          "Add a copy of a <template>. name: '' takes the template's name and a number. position "
          "(3,) [m],\n"
          "orientation (w, x, y, z). places: (n, 3) positions in the world, of which a free one "
          "with the\n"
          "given clearance [m] is drawn. lifetime [s]: it is removed after that time.")
      .def(
          "remove", [send](Self self, const std::string& name) { send(self, Remove{name}); },
          py::arg("name"), "Remove an assembly, or a body without assembly, with all joints to it.")
      .def(
          "attach",
          [send](Self self, const std::string& name, const std::string& parent,
                 const std::string& child, const std::string& kind, const py::object& point,
                 const py::object& axis, double reach) {
            send(self, CommandArguments::attach(name, parent, child, kind, point, axis, reach));
          },
          py::arg("name"), py::arg("parent"), py::arg("child"), py::kw_only(),
          py::arg("type") = "fixed", py::arg("point") = none, py::arg("axis") = none,
          py::arg("reach") = infinity,
          "Create a joint at the present poses. type: 'fixed', 'hinge' or 'ball', about `point` in "
          "the\n"
          "parent's frame [m]; axis: of a hinge, in the parent's frame; reach: largest distance "
          "[m].")
      .def(
          "detach", [send](Self self, const std::string& joint) { send(self, Detach{joint}); },
          py::arg("joint"), "Remove a joint together with its motors.")
      .def(
          "set_joint_limits",
          [send](Self self, const std::string& joint, std::optional<double> lower,
                 std::optional<double> upper, int axis) {
            send(self, SetJointLimits{joint, axis, lower, upper});
          },
          py::arg("joint"), py::arg("lower") = none, py::arg("upper") = none, py::arg("axis") = 0,
          "Change the limits [rad] or [m] of a joint axis; None: unchanged.")
      .def(
          "set_static",
          [send](Self self, const std::string& body, bool on) {
            send(self, SetStatic{body, on});
          },
          py::arg("body"), py::arg("on") = true,
          "Make a body, or all bodies of an assembly, static; False: dynamic again.")
      .def(
          "set_motor",
          [send](Self self, const std::string& motor, double target) {
            send(self, SetMotor{motor, target});
          },
          py::arg("motor"), py::arg("target"),
          "Set the target of a motor, in the unit of its mode.")
      .def(
          "set_input",
          [send](Self self, const std::string& controller, const std::string& input, double value) {
            send(self, SetInput{controller, input, value});
          },
          py::arg("controller"), py::arg("input"), py::arg("value"),
          "Set an input of a controller, by its dotted name or that of its assembly. A value "
          "outside of\nits limits is refused.")
      .def(
          "enable_sensor",
          [send](Self self, const std::string& sensor, bool on) {
            send(self, EnableSensor{sensor, on});
          },
          py::arg("sensor"), py::arg("on") = true, "Switch a sensor on or off.")
      .def(
          "move_door",
          [send](Self self, const std::string& door, bool open) {
            send(self, MoveDoor{door, open});
          },
          py::arg("door"), py::arg("open") = true, "Move a door to its open or closed position.")
      .def(
          "raise_event",
          [send](Self self, const std::string& event, const std::string& message) {
            send(self, Raise{event, message});
          },
          py::arg("event"), py::arg("message") = "", "Emit an event of kind 'raised'.")
      .def(
          "end_run", [send](Self self, const std::string& reason) { send(self, EndRun{reason}); },
          py::arg("reason") = "", "End the run.")
      .def(
          "log", [send](Self self, const std::string& message) { send(self, LogMessage{message}); },
          py::arg("message"), "Write a line to the log of the run.")
      .def(
          "pause", [send](Self self) { send(self, Pause{}); },
          "Pause until resume() or step_once().")
      .def(
          "resume", [send](Self self) { send(self, Resume{}); }, "Resume a paused run.")
      .def(
          "step_once", [send](Self self) { send(self, StepOnce{}); }, "Make one step while paused.")
      .def(
          "set_speed", [send](Self self, double factor) { send(self, SetSpeed{factor}); },
          py::arg("factor"), "Simulated seconds per second; inf: no limit. Results are the same.")
      .def(
          "set_step", [send](Self self, double dt) { send(self, SetStep{dt}); }, py::arg("dt"),
          "Set the time step [s]; results differ.")
      .def(
          "restart",
          [send](Self self, std::optional<std::uint64_t> seed) { send(self, Restart{seed}); },
          py::arg("seed") = none,
          "Restart at time 0 with new controllers; None: with the same seed.")
      .def(
          "add_assembly",
          [send](Self self, const py::object& scene, const std::string& name,
                 const py::object& position, const py::object& orientation) {
            send(self, CommandArguments::add_assembly(scene, name, position, orientation));
          },
          py::arg("scene"), py::arg("name"), py::kw_only(), py::arg("position") = none,
          py::arg("orientation") = none,
          "Add the elements of another Scene (or scene file) as one assembly at a pose in the "
          "world.")
      .def(
          "set_kinematic_twist",
          [send](Self self, const std::string& body, const py::object& velocity,
                 const py::object& angular_velocity) {
            send(self, CommandArguments::kinematic_twist(body, velocity, angular_velocity));
          },
          py::arg("body"), py::arg("velocity") = none, py::arg("angular_velocity") = none,
          "Set the constant velocity (3,) [m/s] and angular velocity (3,) [rad/s] of a kinematic "
          "body, in\n"
          "world axes.")
      .def(
          "apply_force",
          [send](Self self, const std::string& body, const py::object& force,
                 const py::object& torque, const py::object& point, const std::string& axes,
                 double duration) {
            send(self, CommandArguments::force(body, force, torque, point, axes, duration));
          },
          py::arg("body"), py::arg("force") = none, py::kw_only(), py::arg("torque") = none,
          py::arg("point") = none, py::arg("axes") = "world", py::arg("duration") = 0.0,
          "Apply a force (3,) [N] and a torque (3,) [N m] to a body. point: where the force acts,\n"
          "in the frame of the body [m]. axes: 'world', or 'own': they turn with the body.\n"
          "duration [s]; 0: one step.");
}

}  // namespace cogrsim::python
