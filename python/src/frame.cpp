// Frame: the observable state at one time, as read-only views.
#include "frame.h"

#include <fmt/format.h>

#include "scene.h"

namespace cogrsim::python {

namespace {

using Strides = std::vector<py::ssize_t>;

/// (rows, columns) doubles, of which the first is at `first` of every element of `elements`.
template <class Element>
py::array columns(const FramePtr& frame, const std::vector<Element>& elements, const double* first,
                  py::ssize_t count) {
  return view(py::dtype::of<double>(), {static_cast<py::ssize_t>(elements.size()), count},
              Strides{sizeof(Element), sizeof(double)}, elements.empty() ? nullptr : first,
              owner_of(frame));
}

py::array flat(const FramePtr& frame, const std::vector<double>& values) {
  return view(py::dtype::of<double>(), {static_cast<py::ssize_t>(values.size())},
              Strides{sizeof(double)}, values.data(), owner_of(frame));
}

const double* first_of(const std::vector<Twist>& twists, bool angular) {
  if (twists.empty()) return nullptr;
  return angular ? twists.front().angular.data() : twists.front().linear.data();
}

py::array orientations(const PyFrame& self) {
  const std::vector<Pose>& poses = self.frame->state.poses;
  std::vector<double> out;
  out.reserve(4 * poses.size());
  for (const Pose& X : poses) out.insert(out.end(), {X.q.w(), X.q.x(), X.q.y(), X.q.z()});
  return owned(std::move(out), {static_cast<py::ssize_t>(poses.size()), 4});
}

/// The frame, if it has the contents of the member.
const Frame& having(const PyFrame& self, bool FrameContents::*member, const char* name) {
  FrameContents wanted;
  wanted.*member = true;
  check_contents(*self.frame, wanted, name);
  return *self.frame;
}

}  // namespace

void check_contents(const Frame& frame, const FrameContents& wanted, const std::string& who) {
  if (covers(frame.contents, wanted)) return;
  const char* what = wanted.contacts && !frame.contents.contacts             ? "contacts"
                     : wanted.accelerations && !frame.contents.accelerations ? "accelerations"
                                                                             : "joint_reactions";
  raise("Error",
        fmt::format("{}: this frame has no {}, because nobody asked for them before the step{}; "
                    "write observe(callback, {}=True), or {} = True in the class of a supervisor "
                    "or sensor{}",
                    who, what,
                    wanted.joint_reactions ? ", or because the engine does not report them" : "",
                    what, what, wanted.contacts ? ", or record(path, contacts=True)" : ""));
}

double value_of(const Signal& signal, const Frame& frame) {
  check_contents(frame, signal.needs(), "signal '" + signal.text() + "'");
  return signal.evaluate(frame);
}

SignalScope scope_of(const Frame& frame) {
  return {*frame.model,
          [&frame](int sensor) -> const std::vector<Channel>* {
            if (!frame.channels || sensor < 0) return nullptr;
            const auto index = static_cast<std::size_t>(sensor);
            return index < frame.channels->size() ? (*frame.channels)[index].get() : nullptr;
          },
          {},
          {}};
}

Signal parse_signal(const SignalScope& scope, const std::string& text) {
  auto signal = Signal::parse(scope, text);
  if (!signal) throw py::value_error("signal '" + text + "': " + signal.error().text());
  return std::move(*signal);
}

py::array contacts_view(const std::vector<Contact>& contacts, const py::object& owner) {
  // No initialiser of a static variable may wait for the interpreter's lock.
  static const py::object* type = nullptr;
  if (!type) {
    const Contact c;
    const auto offset = [&](const void* member) {
      return reinterpret_cast<const char*>(member) - reinterpret_cast<const char*>(&c);
    };
    py::dict d;
    d["names"] = py::make_tuple("body_a", "body_b", "shape_a", "shape_b", "point", "normal",
                                "depth", "force");
    const auto vector = py::make_tuple("f8", py::make_tuple(3));
    d["formats"] = py::make_tuple("i4", "i4", "i4", "i4", vector, vector, "f8", vector);
    d["offsets"] = py::make_tuple(
        offset(&c.body_a), offset(&c.body_b), offset(&c.shape_a), offset(&c.shape_b),
        offset(c.point.data()), offset(c.normal.data()), offset(&c.depth), offset(c.force.data()));
    d["itemsize"] = sizeof(Contact);
    type = new py::object(py::module_::import("numpy").attr("dtype")(d));
  }
  return view(type->cast<py::dtype>(), {static_cast<py::ssize_t>(contacts.size())},
              Strides{sizeof(Contact)}, contacts.data(), owner);
}

void bind_frame(py::module_& m) {
  py::class_<Event>(m, "Event", "Something that occurred in a step.")
      .def_readonly("time", &Event::time, "[s]")
      .def_readonly("kind", &Event::kind, "'enter', 'added', 'fault', …")
      .def_readonly("source", &Event::source, "Dotted name of the element that caused it")
      .def_readonly("subject", &Event::subject, "Dotted name of the affected element; '': none")
      .def_readonly("message", &Event::message, "Further text; may be ''")
      .def("__repr__", [](const Event& e) {
        return fmt::format("<Event {} at {:.6g} s: {}{}{}>", e.kind, e.time, e.source,
                           e.subject.empty() ? "" : " ", e.subject);
      });

  py::class_<PyFrame>(m, "Frame", R"(The observable state of a simulation at one time; immutable.

Arrays are read-only numpy views of the frame's own memory, which they keep alive. Row i of a body array
is body i of `bodies`; elements that were removed keep their last values. SI units, world axes.)")
      .def_property_readonly(
          "time", [](const PyFrame& f) { return f.frame->time; }, "[s]")
      .def_property_readonly(
          "step", [](const PyFrame& f) { return f.frame->step; }, "Number of steps since the start")
      .def_property_readonly(
          "dt", [](const PyFrame& f) { return f.frame->dt; },
          "Duration of the last step [s]; 0 at the start")
      .def_property_readonly(
          "bodies",
          [](const PyFrame& f) {
            std::vector<std::string> names;
            for (const Body& body : f.frame->model->bodies) names.push_back(body.name);
            return names;
          },
          "Names of all bodies, in the order of the rows; also of removed ones")
      .def_property_readonly(
          "position",
          [](const PyFrame& f) {
            const auto& poses = f.frame->state.poses;
            return columns(f.frame, poses, poses.empty() ? nullptr : poses.front().p.data(), 3);
          },
          "(nbody, 3) float64: origins of the bodies [m]")
      .def_property_readonly(
          "orientation", &orientations,
          "(nbody, 4) float64: unit quaternions w x y z, as in scenes. The memory holds\n"
          "x y z w, so this is the one array that is made when it is read; see\n"
          "orientation_xyzw for the view.")
      .def_property_readonly(
          "orientation_xyzw",
          [](const PyFrame& f) {
            const auto& poses = f.frame->state.poses;
            return columns(f.frame, poses,
                           poses.empty() ? nullptr : poses.front().q.coeffs().data(), 4);
          },
          "(nbody, 4) float64: unit quaternions x y z w, a view")
      .def_property_readonly(
          "velocity",
          [](const PyFrame& f) {
            return columns(f.frame, f.frame->state.twists, first_of(f.frame->state.twists, false),
                           3);
          },
          "(nbody, 3) float64: velocities of the origins [m/s]")
      .def_property_readonly(
          "angular_velocity",
          [](const PyFrame& f) {
            return columns(f.frame, f.frame->state.twists, first_of(f.frame->state.twists, true),
                           3);
          },
          "(nbody, 3) float64 [rad/s]")
      .def_property_readonly(
          "acceleration",
          [](const PyFrame& f) {
            const auto& all =
                having(f, &FrameContents::accelerations, "acceleration").accelerations;
            return columns(f.frame, all, first_of(all, false), 3);
          },
          "(nbody, 3) float64: mean over the last step [m/s^2]; (0, 3) at the start. Raises Error: "
          "nobody\nasked for accelerations before the step")
      .def_property_readonly(
          "angular_acceleration",
          [](const PyFrame& f) {
            const auto& all =
                having(f, &FrameContents::accelerations, "angular_acceleration").accelerations;
            return columns(f.frame, all, first_of(all, true), 3);
          },
          "(nbody, 3) float64 [rad/s^2], as acceleration")
      .def_property_readonly(
          "joint_position",
          [](const PyFrame& f) { return flat(f.frame, f.frame->state.joint_positions); },
          "(nq,) float64: coordinates of all joints [rad] or [m]; balls have a quaternion w x y z")
      .def_property_readonly(
          "joint_velocity",
          [](const PyFrame& f) { return flat(f.frame, f.frame->state.joint_velocities); },
          "(nu,) float64: speeds of all joints [rad/s] or [m/s]")
      .def_property_readonly(
          "joint_effort",
          [](const PyFrame& f) { return flat(f.frame, f.frame->state.joint_efforts); },
          "(nu,) float64: mean over the last step [N m] or [N]")
      .def_property_readonly(
          "motor_effort",
          [](const PyFrame& f) { return flat(f.frame, f.frame->state.motor_efforts); },
          "(nmotor,) float64: mean over the last step [N m] or [N]")
      .def_property_readonly(
          "joint_reaction",
          [](const PyFrame& f) {
            const auto& all =
                having(f, &FrameContents::joint_reactions, "joint_reaction").joint_reactions;
            return columns(f.frame, all, all.empty() ? nullptr : all.front().force.data(), 6);
          },
          "(njoint, 6) float64: force [N] and torque [N m]. Raises Error: nobody asked for "
          "joint_reactions, or\nthe engine reports none")
      .def_property_readonly(
          "contacts",
          [](const PyFrame& f) {
            return contacts_view(having(f, &FrameContents::contacts, "contacts").contacts,
                                 owner_of(f.frame));
          },
          "(ncontact,) structured: body_a, body_b, shape_a, shape_b (int32), point [m], normal "
          "from a to b,\n"
          "depth [m], force on b [N]. Raises Error: nobody asked for contacts.")
      .def_property_readonly(
          "sensors", [](const PyFrame& f) { return sensors_of(f.frame); },
          "dict of Reading by the dotted name of the sensor")
      .def_property_readonly(
          "events", [](const PyFrame& f) { return f.frame->events; },
          "Events of this step, for observers")
      .def_property_readonly(
          "state_hash",
          [](const PyFrame& f) { return fmt::format("{:016x}", state_hash(f.frame->state)); },
          "Hash of the state, as `cogrsim run` prints it: equal hashes mean equal states")
      .def_property_readonly(
          "energy",
          [](const PyFrame& f) {
            const Energy energy = energy_of(*f.frame->model, f.frame->state);
            return py::make_tuple(energy.kinetic, energy.potential);
          },
          "(kinetic, potential) [J]")
      .def_property_readonly(
          "momentum",
          [](const PyFrame& f) {
            const Momentum momentum = momentum_of(*f.frame->model, f.frame->state);
            return py::make_tuple(to_python(momentum.linear), to_python(momentum.angular));
          },
          "(linear [kg m/s], angular about the world origin [kg m^2/s])")
      .def(
          "value",
          [](const PyFrame& f, const std::string& signal) {
            return value_of(parse_signal(scope_of(*f.frame), signal), *f.frame);
          },
          py::arg("signal"),
          "Value of a signal such as 'distance(robot, wall)' in SI units; NaN: it has none.\n"
          "Raises ValueError: the signal is wrong, with the most similar names; Error: it needs "
          "contacts, and\n"
          "nobody asked for them.")
      .def(
          "__getitem__",
          [](const PyFrame& f, const std::string& name) { return element_of(f.frame, name); },
          py::arg("name"),
          "The body, assembly, frame, joint, motor, sensor or controller with this dotted name; "
          "its\n"
          "attributes are the quantities of signals: frame['robot.chassis'].speed.\n"
          "Raises KeyError naming the nearest names.")
      .def("__repr__", [](const PyFrame& f) {
        const std::string contacts = f.frame->contents.contacts
                                         ? fmt::format(", {} contacts", f.frame->contacts.size())
                                         : "";
        return fmt::format("<Frame of '{}' at {:.6g} s: {} bodies{}>", f.frame->model->name,
                           f.frame->time, f.frame->state.poses.size(), contacts);
      });
}

}  // namespace cogrsim::python
