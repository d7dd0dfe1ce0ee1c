// Commands, and the state of the whole world.
#include "commands.h"

#include "simulation.h"

namespace cogrsim::python {

Command CommandArguments::spawn(const std::string& of, const std::string& name,
                                const py::object& position, const py::object& orientation,
                                const py::object& places, double clearance, double lifetime) {
  Spawn spawn;
  spawn.of = of;
  spawn.name = name;
  spawn.pose = pose_of(position, orientation);
  if (!places.is_none()) {
    const py::array_t<double> rows = numbers(places, "places", {-1, 3});
    for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
      spawn.candidate_poses.push_back({Vec3(rows.at(i, 0), rows.at(i, 1), rows.at(i, 2)), Quat(1, 0, 0, 0)});
    }
  }
  spawn.clearance = clearance;
  spawn.lifetime = lifetime;
  return spawn;
}

Command CommandArguments::attach(const std::string& name, const std::string& parent,
                                 const std::string& child, const std::string& kind,
                                 const py::object& point, const py::object& axis, double reach) {
  Attach attach;
  attach.name = name;
  attach.parent = parent;
  attach.child = child;
  if (kind == "fixed") {
    attach.type = Attach::Type::fixed;
  } else if (kind == "hinge") {
    attach.type = Attach::Type::hinge;
  } else if (kind == "ball") {
    attach.type = Attach::Type::ball;
  } else {
    throw py::value_error("type: expected 'fixed', 'hinge' or 'ball', given '" + kind + "'");
  }
  if (!point.is_none()) attach.point = vector_of(point, "point");
  if (!axis.is_none()) attach.axis = vector_of(axis, "axis");
  attach.reach = reach;
  return attach;
}

Command CommandArguments::add_assembly(const py::object& scene, const std::string& name,
                                       const py::object& position, const py::object& orientation) {
  return AddAssembly{scene_of(scene)->model, name, pose_of(position, orientation)};
}

Command CommandArguments::kinematic_twist(const std::string& body, const py::object& velocity,
                                          const py::object& angular_velocity) {
  SetKinematicTwist twist;
  twist.body = body;
  if (!velocity.is_none()) twist.twist.linear = vector_of(velocity, "velocity");
  if (!angular_velocity.is_none())
    twist.twist.angular = vector_of(angular_velocity, "angular_velocity");
  return twist;
}

Command CommandArguments::force(const std::string& body, const py::object& force,
                                const py::object& torque, const py::object& point,
                                const std::string& axes, double duration) {
  if (axes != "world" && axes != "own")
    throw py::value_error("axes: expected 'world' or 'own', given '" + axes + "'");
  ApplyForce out;
  out.body = body;
  if (!force.is_none()) out.force = vector_of(force, "force");
  if (!torque.is_none()) out.torque = vector_of(torque, "torque");
  if (!point.is_none()) out.point = vector_of(point, "point");
  out.in_body = axes == "own";
  out.duration = duration;
  return out;
}

namespace {

void set_state(const SessionPtr& session, const py::object& frame, const py::object& position,
               const py::object& orientation, const py::object& velocity,
               const py::object& angular_velocity, const py::object& joint_position,
               const py::object& joint_velocity) {
  SetState command;
  if (frame.is_none()) {
    const Use use(*session);
    command.state = session->simulation->frame()->state;
  } else if (!py::isinstance<PyFrame>(frame)) {
    throw py::type_error("frame: expected a Frame, given " + type_name(frame));
  } else {
    command.state = frame.cast<PyFrame>().frame->state;
  }
  WorldState& state = command.state;
  const auto bodies = static_cast<py::ssize_t>(state.poses.size());
  const auto rows = [&](const py::object& given, const char* name, py::ssize_t width, auto&& put) {
    if (given.is_none()) return;
    const py::array_t<double> values = numbers(given, name, {bodies, width});
    for (py::ssize_t i = 0; i < bodies; ++i) put(static_cast<std::size_t>(i), values.data(i, 0));
  };
  rows(position, "position", 3,
       [&](std::size_t i, const double* v) { state.poses[i].p = Vec3(v[0], v[1], v[2]); });
  rows(orientation, "orientation", 4, [&](std::size_t i, const double* v) {
    const Quat q(v[0], v[1], v[2], v[3]);
    if (!(q.norm() > 1e-9)) throw py::value_error("orientation: a quaternion has the length 0");
    state.poses[i].q = q.normalized();
  });
  rows(velocity, "velocity", 3,
       [&](std::size_t i, const double* v) { state.twists[i].linear = Vec3(v[0], v[1], v[2]); });
  rows(angular_velocity, "angular_velocity", 3,
       [&](std::size_t i, const double* v) { state.twists[i].angular = Vec3(v[0], v[1], v[2]); });
  const auto list = [](const py::object& given, const char* name, std::vector<double>& out) {
    if (given.is_none()) return;
    const py::array_t<double> values = numbers(given, name, {static_cast<py::ssize_t>(out.size())});
    std::copy_n(values.data(), out.size(), out.begin());
  };
  list(joint_position, "joint_position", state.joint_positions);
  list(joint_velocity, "joint_velocity", state.joint_velocities);
  session->simulation->send(std::move(command));
}

}  // namespace

void bind_commands(py::class_<Session, SessionPtr>& type) {
  add_commands<const SessionPtr&>(type, [](const SessionPtr& session, Command command) {
    session->simulation->send(std::move(command));
  });
  const auto none = py::none();
  type.def(
      "set_state", &set_state, py::arg("frame") = none, py::kw_only(), py::arg("position") = none,
      py::arg("orientation") = none, py::arg("velocity") = none, py::arg("angular_velocity") = none,
      py::arg("joint_position") = none, py::arg("joint_velocity") = none,
      "Set the state of the whole world: that of `frame` (None: the present one), with the given\n"
      "arrays in place of its own. Shapes as in Frame; orientation is w x y z. Of bodies in a tree "
      "of\n"
      "joints, engines with reduced coordinates take the joint coordinates.\n"
      "Raises ValueError, TypeError: another shape or dtype.");
}

}  // namespace cogrsim::python
