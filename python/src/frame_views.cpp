// Elements of a frame by name, and readings of sensors.
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "cogrsim/rendering/renderer.h"
#include "cogrsim/sensing/sensor_models.h"
#include "frame.h"
#include "rendering.h"
#include "scene.h"

namespace cogrsim::python {

namespace {

/// An element of a frame. Quantities are those of signals.
struct Element {
  FramePtr frame;
  std::string name, kind;
  int body = -1;  ///< index, of a body
};

double quantity(const Element& e, const std::string& what) {
  const auto signal = Signal::parse(scope_of(*e.frame), e.name + "." + what);
  if (!signal) throw py::attribute_error(e.kind + " '" + e.name + "': " + signal.error().text());
  return value_of(*signal, *e.frame);
}

py::object triple(const Element& e, const char* const (&quantities)[3]) {
  std::vector<double> out;
  for (const char* one : quantities) out.push_back(quantity(e, one));
  return owned(std::move(out), {3});
}

bool has_pose(const Element& e) {
  return e.kind == "body" || e.kind == "assembly" || e.kind == "frame";
}

py::array vector_view(const Element& e, const Vec3& v) {
  return view(py::dtype::of<double>(), {3}, {sizeof(double)}, v.data(), owner_of(e.frame));
}

py::object position(const Element& e) {
  if (e.body >= 0) return vector_view(e, e.frame->state.poses[e.body].p);
  if (has_pose(e)) return triple(e, {"x", "y", "z"});
  return py::float_(quantity(e, "position"));
}

py::object velocity(const Element& e) {
  if (e.body >= 0) return vector_view(e, e.frame->state.twists[e.body].linear);
  if (has_pose(e)) return triple(e, {"vx", "vy", "vz"});
  return py::float_(quantity(e, "velocity"));
}

py::object angular_velocity(const Element& e) {
  if (e.body >= 0) return vector_view(e, e.frame->state.twists[e.body].angular);
  return triple(e, {"wx", "wy", "wz"});
}

py::object orientation(const Element& e) {
  if (e.body < 0) throw py::attribute_error("orientation");  // attribute() gives the reason
  const Quat& q = e.frame->state.poses[e.body].q;
  return owned({q.w(), q.x(), q.y(), q.z()}, {4});
}

py::object attribute(const Element& e, const std::string& name) {
  // numpy, IPython and pickle ask for many names with underscores.
  if (!name.empty() && name[0] == '_') throw py::attribute_error(name);
  return py::float_(quantity(e, name));
}

/// A reading with the frame that owns it.
struct PyReading {
  FramePtr frame;
  std::size_t index = 0;
  const Reading& operator*() const { return frame->readings[index]; }
  const Reading* operator->() const { return &frame->readings[index]; }
  const SensorModel& sensor() const { return frame->model->sensors[frame->readings[index].sensor]; }
  const std::vector<Channel>* channels() const {
    const auto i = static_cast<std::size_t>(frame->readings[index].sensor);
    return frame->channels && i < frame->channels->size() ? (*frame->channels)[i].get() : nullptr;
  }
};

std::vector<std::string> channel_names(const PyReading& r) {
  std::vector<std::string> names;
  if (const auto* channels = r.channels()) {
    for (const Channel& channel : *channels) names.push_back(channel.name);
  }
  return names;
}

double value_by_name(const PyReading& r, const std::string& name) {
  const std::vector<std::string> names = channel_names(r);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return i < r->values.size() ? r->values[i] : std::nan("");
  }
  raise_unknown("channel of sensor '" + r.sensor().name + "' named", name, names);
}

std::string body_name(const PyReading& r, int body) {
  const std::vector<Body>& bodies = r.frame->model->bodies;
  const auto index = static_cast<std::size_t>(body);
  return r->valid && body >= 0 && index < bodies.size() ? bodies[index].name : "";
}

std::vector<std::string> contact_bodies(const PyReading& r) {
  std::set<std::string> names;
  for (const Contact& contact : r->contacts) names.insert(body_name(r, contact.body_a));
  names.erase("");
  return {names.begin(), names.end()};
}

template <class Elements>
void collect(const Elements& elements, std::vector<std::string>& names) {
  for (const auto& element : elements) {
    if (!element.removed) names.push_back(element.name);
  }
}

}  // namespace

py::object element_of(const FramePtr& frame, const std::string& name) {
  const SceneModel& model = *frame->model;
  const auto has = [&](const auto& elements) {
    for (const auto& element : elements) {
      if (!element.removed && element.name == name) return true;
    }
    return false;
  };
  Element e{frame, name, "", find_body(model, name)};
  if (e.body >= 0)
    e.kind = "body";
  else if (has(model.assemblies))
    e.kind = "assembly";
  else if (has(model.frames))
    e.kind = "frame";
  else if (has(model.joints))
    e.kind = "joint";
  else if (has(model.motors))
    e.kind = "motor";
  else if (has(model.sensors))
    e.kind = "sensor";
  else if (has(model.controllers))
    e.kind = "controller";
  else if (has(model.supervisors))
    e.kind = "supervisor";
  if (!e.kind.empty()) return py::cast(std::move(e));
  std::vector<std::string> names;
  collect(model.bodies, names);
  collect(model.assemblies, names);
  collect(model.frames, names);
  collect(model.joints, names);
  collect(model.motors, names);
  collect(model.sensors, names);
  collect(model.controllers, names);
  collect(model.supervisors, names);
  raise_unknown("element", name, names);
}

py::dict sensors_of(const FramePtr& frame) {
  py::dict out;
  for (std::size_t i = 0; i < frame->readings.size(); ++i) {
    if (frame->readings[i].sensor < 0) continue;
    const PyReading reading{frame, i};
    if (!reading.sensor().removed) out[py::str(reading.sensor().name)] = reading;
  }
  return out;
}

void bind_frame_views(py::module_& m) {
  py::class_<Element>(m, "Element", R"(An element of a frame.

position, velocity: (3,) of a body, assembly or named frame [m], [m/s]; a number of a joint [rad] or [m].
angular_velocity: (3,) [rad/s]; orientation: (4,) w x y z, of a body.
All other attributes are the quantities of signals: x y z roll pitch yaw vx vy vz speed wx wy wz spin of a
body, assembly or named frame; position velocity effort of a joint; effort of a motor; the channels of a
sensor; the outputs of a controller. NaN: no value. AttributeError: no such quantity.)")
      .def_readonly("name", &Element::name, "Dotted name")
      .def_readonly("kind", &Element::kind, "'body', 'assembly', 'frame', 'joint', 'motor', …")
      .def_property_readonly("position", &position,
                             "(3,) float64 [m], of a body a view; of a joint a number [rad] or [m]")
      .def_property_readonly(
          "velocity", &velocity,
          "(3,) float64 [m/s], of a body a view; of a joint a number [rad/s] or [m/s]")
      .def_property_readonly("angular_velocity", &angular_velocity,
                             "(3,) float64 [rad/s], of a body a view; AttributeError: of a joint")
      .def_property_readonly("orientation", &orientation,
                             "(4,) float64 w x y z, of a body; AttributeError: of another element")
      .def("__getattr__", &attribute)
      .def("__repr__", [](const Element& e) {
        return fmt::format("<{} '{}' at {:.6g} s>", e.kind, e.name, e.frame->time);
      });

  py::class_<PyReading>(m, "Reading", R"(The latest measurement of one sensor; immutable.

reading['distance'] is the value of a channel; values, the array of all.)")
      .def_property_readonly(
          "name", [](const PyReading& r) { return r.sensor().name; }, "Dotted name of the sensor")
      .def_property_readonly(
          "type", [](const PyReading& r) { return r.sensor().type; },
          "Kind of the sensor, such as 'lidar', or the name of its plugin")
      .def_property_readonly(
          "time", [](const PyReading& r) { return r->time; }, "Time of the measured frame [s]")
      .def_property_readonly(
          "sequence", [](const PyReading& r) { return r->sequence; },
          "Number of measurements so far; 0: none yet")
      .def_property_readonly(
          "valid", [](const PyReading& r) { return r->valid; },
          "False: no measurement yet, switched off, or dropped out")
      .def_property_readonly(
          "enabled", [](const PyReading& r) { return r->enabled; },
          "Whether the sensor is switched on")
      .def_property_readonly("channels", &channel_names, "Names of the values, in order")
      .def_property_readonly(
          "units",
          [](const PyReading& r) {
            std::vector<std::string> units;
            if (const auto* channels = r.channels()) {
              for (const Channel& channel : *channels) units.push_back(channel.unit);
            }
            return units;
          },
          "Units of the values, '1': none")
      .def_property_readonly(
          "values",
          [](const PyReading& r) {
            return view(py::dtype::of<double>(), {static_cast<py::ssize_t>(r->values.size())},
                        {sizeof(double)}, r->values.data(), owner_of(r.frame));
          },
          "(nchannel,) float64, a view")
      .def_property_readonly(
          "contacts",
          [](const PyReading& r) { return contacts_view(r->contacts, owner_of(r.frame)); },
          "Of a contact sensor: structured, as Frame.contacts")
      .def_property_readonly(
          "image",
          [](const PyReading& r) { return r->picture ? color_of(r->picture) : py::none(); },
          "Of a camera: (height, width, 3) uint8, a view; None: no image")
      .def_property_readonly(
          "depth",
          [](const PyReading& r) { return r->picture ? depth_of(r->picture) : py::none(); },
          "Of a camera with depth: (height, width) float32 [m], inf: background; otherwise None")
      .def_property_readonly(
          "labels",
          [](const PyReading& r) { return r->picture ? labels_of(r->picture) : py::none(); },
          "Of a camera with segmentation: (height, width) int32 body indices, -1: background; "
          "otherwise None")
      .def_property_readonly(
          "sensor_pose",
          [](const PyReading& r) -> py::object {
            if (!r->pose) return py::none();
            const auto& [p, q] = *r->pose;
            return py::make_tuple(owned({p.x(), p.y(), p.z()}, {3}),
                                  owned({q.w(), q.x(), q.y(), q.z()}, {4}));
          },
          "Where the sensor measured, in the world: position (3,) [m], quaternion (4,) w x y z; "
          "None: no\nmeasurement yet")
      .def("_body",
           [](const PyReading& r) {
             return r->values.size() > 1 ? body_name(r, static_cast<int>(r->values[1])) : "";
           })
      .def("_bodies", &contact_bodies)
      .def("_directions", [](const PyReading& r) { return rows_of(ray_directions(r.sensor())); })
      .def("__getitem__", &value_by_name, py::arg("channel"),
           "Value of a channel; NaN: no measurement yet. Raises KeyError naming the channels.")
      .def("__len__", [](const PyReading& r) { return r->values.size(); })
      .def("__repr__", [](const PyReading& r) {
        return fmt::format("<Reading of '{}': {} values{}>", r.sensor().name, r->values.size(),
                           r->valid ? "" : ", not valid");
      });
}

}  // namespace cogrsim::python
