// Supervisors and sensors in Python.
#include "cogrsim/control/supervisor.h"

#include <cmath>

#include <fmt/format.h>

#include "cogrsim/rays/ray_caster.h"
#include "cogrsim/sensing/sensor.h"
#include "commands.h"
#include "frame.h"
#include "python_plugins.h"

namespace cogrsim::python {

namespace {

Slots& supervisor_slots() {
  static Slots all;
  return all;
}
Slots& sensor_slots() {
  static Slots all;
  return all;
}

FrameContents needs_of(const Held& instance) {
  FrameContents out;
  if (!instance) return out;
  const auto flag = [&](const char* name) { return py::bool_(instance->attr(name)).cast<bool>(); };
  out.contacts = flag("contacts");
  out.joint_reactions = flag("joint_reactions");
  out.accelerations = flag("accelerations");
  return out;
}

/// The frame of a context, copied once per call: Python may keep it.
struct FrameCopy {
  FramePtr frame;
  std::uint64_t call = 0;  ///< of the gate, when it was made
  PyFrame get(const Frame& now, const Gate& gate) {
    if (!frame || call != gate.call) frame = std::make_shared<const Frame>(now);
    call = gate.call;
    return {frame};
  }
};

/// What a supervisor or a sensor gets in a call; it is valid during the call.
template <class Context>
struct PyCallContext {
  Context* context = nullptr;
  GatePtr gate;
  FrameCopy copy;
  static constexpr bool kSupervisor = std::is_same_v<Context, SupervisorContext>;
  Context& get() const {
    gate->check(kSupervisor ? "the context of a supervisor" : "the context of a sensor");
    return *context;
  }
  std::string text() const {
    const std::string name = kSupervisor ? "SupervisorContext" : "SensorContext";
    return gate->open ? fmt::format("<{} at {:.6g} s>", name, context->frame().time)
                      : "<" + name + ", outside its call>";
  }
};
using PyContext = PyCallContext<SupervisorContext>;
using PySensing = PyCallContext<SensorContext>;

class PySupervisor final : public Supervisor {
 public:
  explicit PySupervisor(PluginClassPtr cls) : class_(std::move(cls)) {
    call_python(*gate_, [&] {
      instance_ = hold((*class_->type)());
      needs_ = needs_of(instance_);
    });
  }
  FrameContents needs() const override { return needs_; }
  void configure(SupervisorContext& context) override {
    if (!instance_) return;
    call_python(*gate_, [&] { instance_->attr("configure")(PyContext{&context, gate_, {}}); });
  }
  void update(const Tick& tick, SupervisorContext& context) override {
    if (!instance_)
      throw std::runtime_error("it was interrupted while it was made; restart the run");
    call_python(*gate_, [&] { instance_->attr("update")(tick, PyContext{&context, gate_, {}}); });
  }
  std::optional<std::string> save() const override {
    std::optional<std::string> memory;
    if (!instance_) return memory;
    call_python(*gate_, [&] { memory = memory_of(instance_->attr("save")()); });
    return memory;
  }
  void restore(const std::string& memory) override {
    if (!instance_) return;
    call_python(*gate_, [&] { instance_->attr("restore")(memory); });
  }

 private:
  PluginClassPtr class_;
  GatePtr gate_ = std::make_shared<Gate>();
  Held instance_;
  FrameContents needs_;
};

template <std::size_t I>
struct MakeSupervisor {
  static SupervisorEntry entry() {
    return {[](Supervisor*& out) {
              return detail::guarded([&] { out = new PySupervisor(supervisor_slots().get(I)); });
            },
            [](Supervisor* s) { detail::guarded([&] { delete s; }); },
            [](Supervisor& s, SupervisorContext& context) {
              return detail::guarded([&] { s.configure(context); });
            },
            [](Supervisor& s, const Tick& tick, SupervisorContext& context) {
              return detail::guarded([&] { s.update(tick, context); });
            },
            [](const Supervisor& s, std::optional<std::string>& memory) {
              return detail::guarded([&] { memory = s.save(); });
            },
            [](Supervisor& s, const std::string& memory) {
              return detail::guarded([&] { s.restore(memory); });
            }};
  }
};

/// Distances and bodies along rays from one point, (n,) each.
py::tuple cast(const PySensing& self, const py::object& origin, const py::object& directions,
               double max_distance, const std::string& ignore) {
  const Vec3 from = vector_of(origin, "origin");
  const py::array_t<double> rows = numbers(directions, "directions", {-1, 3});
  std::vector<int> ignored;
  if (!ignore.empty()) {
    const SceneModel& model = *self.get().frame().model;
    const int body = find_body(model, ignore);
    if (body < 0) {
      std::vector<std::string> names;
      for (const Body& b : model.bodies)
        if (!b.removed) names.push_back(b.name);
      raise_unknown("body", ignore, names);
    }
    ignored.push_back(body);
  }
  if (!from.allFinite()) throw py::value_error("origin: expected finite numbers [m]");
  if (!(max_distance >= 0.0))
    throw py::value_error("max_distance: expected a distance of 0 m or more");
  std::vector<Ray> rays(static_cast<std::size_t>(rows.shape(0)));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double* const v = rows.data(static_cast<py::ssize_t>(i), 0);
    const double length = Vec3(v[0], v[1], v[2]).norm();
    if (!(length > 0.0) || !std::isfinite(length))
      throw py::value_error("directions: expected finite vectors that are not zero; row " +
                            std::to_string(i) + " is none");
    rays[i] = {from, Vec3(v[0], v[1], v[2]), 0.0, max_distance};
  }
  std::vector<RayHit> hits;
  self.get().rays().cast(rays, hits, ignored);
  std::vector<double> distances;
  std::vector<int> bodies;
  for (const RayHit& hit : hits) {
    distances.push_back(hit.distance);
    bodies.push_back(hit.body);
  }
  return py::make_tuple(owned(std::move(distances), {rows.shape(0)}),
                        py::array_t<int>(static_cast<py::ssize_t>(bodies.size()), bodies.data()));
}

class PySensorModel final : public Sensor {
 public:
  explicit PySensorModel(PluginClassPtr cls) : class_(std::move(cls)) {}

  Result<> configure(const SceneModel& model, const SensorModel& sensor,
                     const Parameters& parameters) override {
    return guarded([&] {
      instance_ = hold((*class_->type)());
      py::dict info, values;
      const auto name_at = [](const auto& elements, int index) {
        return index < 0 ? std::string() : elements[index].name;
      };
      info["name"] = sensor.name;
      info["body"] = name_at(model.bodies, sensor.body);
      info["joint"] = name_at(model.joints, sensor.joint);
      info["position"] = to_python(sensor.X_BS.p);
      info["orientation"] = to_python(sensor.X_BS.q);
      info["rate"] = sensor.rate;
      for (const auto& [name, value] : parameters) values[py::str(name)] = to_python(value);
      instance_->attr("configure")(info, values);
      needs_ = needs_of(instance_);
      channels_.clear();
      for (const py::handle& one : instance_->attr("channels")) {
        channels_.push_back({one.attr("name").cast<std::string>(),
                             one.attr("unit").cast<std::string>(), one.attr("noisy").cast<bool>(),
                             one.attr("group").cast<int>()});
      }
    });
  }
  std::vector<Channel> channels() const override { return channels_; }
  FrameContents needs() const override { return needs_; }
  Result<> read(SensorContext& context, Reading& reading) override {
    if (!instance_) return fail("it was interrupted while being configured");
    return guarded([&] {
      const py::object got = instance_->attr("read")(PySensing{&context, gate_, {}});
      const auto count = static_cast<py::ssize_t>(channels_.size());
      const py::array_t<double> values = numbers(got, "read()", {count});
      reading.values.assign(values.data(), values.data() + count);
    });
  }

 private:
  template <class Function>
  Result<> guarded(Function&& function) {
    const auto failure = detail::guarded([&] {
      call_python(*gate_, [&] {
        try {
          function();
        } catch (const py::builtin_exception& error) {
          throw py::cast_error(error.what());
        }
      });
    });
    if (failure) return fail(*failure);
    return {};
  }

  PluginClassPtr class_;
  GatePtr gate_ = std::make_shared<Gate>();
  Held instance_;
  std::vector<Channel> channels_;
  FrameContents needs_;
};

template <std::size_t I>
struct MakeSensor {
  static SensorEntry entry() {
    return {[]() -> Sensor* { return new PySensorModel(sensor_slots().get(I)); },
            [](Sensor* sensor) { delete sensor; }};
  }
};

}  // namespace

const void* supervisor_factory(const PluginClassPtr& cls) {
  static const auto all =
      entries<SupervisorEntry, MakeSupervisor>(std::make_index_sequence<kSlots>());
  const auto slot = supervisor_slots().take(cls);
  return slot ? &all[*slot] : nullptr;
}

const void* sensor_factory(const PluginClassPtr& cls) {
  static const auto all = entries<SensorEntry, MakeSensor>(std::make_index_sequence<kSlots>());
  const auto slot = sensor_slots().take(cls);
  return slot ? &all[*slot] : nullptr;
}

void bind_supervisors(py::module_& m) {
  py::class_<PyContext> context(m, "SupervisorContext",
                                R"(The world, for a supervisor: frames and commands.

Commands are queued for the next step boundary; one that cannot be carried out there is reported as an
event. Usable only inside the calls of the supervisor.)");
  context
      .def_property_readonly(
          "frame", [](PyContext& s) { return s.copy.get(s.get().frame(), *s.gate); },
          "The present Frame, with what the class asks for and the events since the\n"
          "previous update")
      .def(
          "parameter",
          [](const PyContext& s, const std::string& name) {
            const ParameterValue* const value = s.get().parameter(name);
            if (!value) throw py::key_error("there is no declared parameter '" + name + "'");
            return to_python(*value);
          },
          py::arg("name"), "Value of a declared parameter, in SI units. Raises KeyError.")
      .def(
          "uniform",
          [](const PyContext& s, double low, double high) { return s.get().uniform(low, high); },
          py::arg("low"), py::arg("high"),
          "A number from [low, high), from the seeded stream of the supervisor.")
      .def(
          "report", [](const PyContext& s, const std::string& message) { s.get().report(message); },
          py::arg("message"), "Report a message to the user.")
      .def(
          "publish",
          [](const PyContext& s, const std::string& output, double value) {
            s.get().publish(output, value);
          },
          py::arg("output"), py::arg("value"), "Set the value of a declared output.")
      .def("__repr__", &PyContext::text);
  add_commands<PyContext&>(context,
                           [](PyContext& s, Command command) { s.get().send(std::move(command)); });

  py::class_<PySensing>(m, "SensorContext",
                        "The measured frame, for a sensor; usable only in read().")
      .def_property_readonly(
          "frame", [](PySensing& s) { return s.copy.get(s.get().frame(), *s.gate); },
          "The measured Frame, with what the class asks for")
      .def("__repr__", &PySensing::text)
      .def("cast", &cast, py::arg("origin"), py::arg("directions"), py::kw_only(),
           py::arg("max_distance") = std::numeric_limits<double>::infinity(),
           py::arg("ignore") = "",
           "Distances (n,) [m], inf: nothing, and body indices (n,), -1: nothing, along rays in "
           "the world.\n"
           "origin (3,) [m], directions (n, 3) of any length; ignore: name of a body that is not "
           "hit.");
}

}  // namespace cogrsim::python
