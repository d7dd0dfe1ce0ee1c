// Simulation: stepping, frames, observers, messages.
#include "simulation.h"

#include <chrono>
#include <cmath>

#include <fmt/format.h>

namespace cogrsim::python {

namespace {

using Clock = std::chrono::steady_clock;

/// Time between two looks at signals of the system such as Ctrl-C.
constexpr auto kPatience = std::chrono::milliseconds(20);

/// Raises what a signal handler or an observer left behind. The caller does not hold the lock.
void raise_pending(Session& session, InterruptLater& interrupt) {
  const Lock lock;
  if (session.observer_failed.exchange(false)) {
    const Held error = std::move(session.observer_error);
    PyErr_SetObject(py::type::handle_of(*error).ptr(), error->ptr());
    throw py::error_already_set();
  }
  interrupt.check();
}

/// The line of progress of a run, cogrsim._progress.Progress. The caller does not hold the lock.
class ProgressLine {
 public:
  ProgressLine(double start, double end) {
    const Lock lock;
    line_ = hold(py::module_::import("cogrsim._progress").attr("Progress")(start, end));
  }
  ~ProgressLine() {
    const Lock lock;
    try {
      line_->attr("end")();
    } catch (py::error_already_set& error) {
      error.discard_as_unraisable("cogrsim._progress");
    }
  }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(double time) {
    const Lock lock;
    line_->attr("show")(time);
  }

 private:
  Held line_;
};

PyFrame frame_of(Session& session) { return to_python(session.simulation->frame()); }

double finite_time(double time, const char* name) {
  if (!std::isfinite(time))
    throw py::value_error(std::string(name) + ": expected a finite time [s]");
  return time;
}

SessionPtr make_session(const py::object& scene, const py::object& backend, double step,
                        const std::optional<std::uint64_t>& seed, double speed,
                        const std::string& isolation, std::vector<std::string> without) {
  auto session = std::make_shared<Session>();
  session->scene = scene_of(scene);
  const SimulationOptions options =
      simulation_options(backend, step, seed, speed, isolation, std::move(without));
  auto created = [&] {
    const Unlock unlock;
    return Simulation::create(session->scene->model, options, session->scene->loader);
  }();
  if (!created) raise("Error", created.error());
  session->simulation = std::move(*created);
  return session;
}

Observation observe(const SessionPtr& session, const py::function& callback, bool contacts,
                    bool joint_reactions, bool accelerations, bool for_sensors) {
  const Use use(*session);
  const Held held = hold(callback);
  // The observer belongs to the simulation, which belongs to the session.
  Session* const owner = session.get();
  ++session->observers;
  return session->simulation->observe({contacts, joint_reactions, accelerations, for_sensors},
                                      [held, owner](const FramePtr& frame) {
                                        const Lock lock;
                                        if (owner->observer_failed.load()) return;
                                        try {
                                          (*held)(to_python(frame));
                                        } catch (py::error_already_set& error) {
                                          if (error.matches(PyExc_KeyboardInterrupt)) {
                                            interrupted();
                                            return;
                                          }
                                          py::object value = error.value();
                                          if (error.trace())
                                            value.attr("__traceback__") = error.trace();
                                          owner->observer_error = hold(std::move(value));
                                          owner->observer_failed.store(true);
                                        }
                                      });
}

}  // namespace

std::vector<std::string> new_errors(const Simulation& run, std::size_t& known) {
  const std::vector<RunMessage>& messages = run.messages();
  if (known > messages.size()) known = 0;  // restarted
  std::vector<std::string> out;
  while (known < messages.size()) {
    const RunMessage& message = messages[known++];
    if (message.severity != Severity::error) continue;
    out.push_back(
        fmt::format("at {:.6g} s, {}: {}", message.time, message.source, message.message));
  }
  return out;
}

void warn(const std::vector<std::string>& errors) {
  for (const std::string& text : errors) {
    const py::object type = py::module_::import("cogrsim._errors").attr("RunWarning");
    if (PyErr_WarnEx(type.ptr(), text.c_str(), 1) != 0) throw py::error_already_set();
  }
}

Use::Use(Usage& usage, const char* what) : usage_(usage) {
  refuse_at_exit();
  if (usage.made_after && *usage.made_after != forks)
    throw std::runtime_error(fmt::format(
        "the {} was made before this process was forked, and its threads stayed there: make it "
        "here, or start processes by \"spawn\"",
        what));
  if (!usage.busy.exchange(true)) {
    ++calls_under_way;
    usage.thread.store(std::this_thread::get_id());
    return;
  }
  if (usage.thread.load() == std::this_thread::get_id()) {
    throw std::runtime_error(fmt::format(
        "the {0} is in the middle of a step: an observer, controller or supervisor cannot use the "
        "{0} that calls it; use the frame it is given, and queue commands",
        what));
  }
  throw std::runtime_error(
      fmt::format("the {} is in use by another thread; give every thread one of its own", what));
}

SimulationOptions simulation_options(const py::object& backend, double step,
                                     const std::optional<std::uint64_t>& seed, double speed,
                                     const std::string& isolation,
                                     std::vector<std::string> without) {
  SimulationOptions options;
  options.without = std::move(without);
  if (!backend.is_none()) options.backend = text_of(backend, "backend");
  options.step = step;
  options.seed = seed;
  options.speed = speed;
  if (isolation == "process") {
    options.isolation = Isolation::process;
  } else if (isolation != "none") {
    throw py::value_error("isolation: expected 'none' or 'process', given '" + isolation + "'");
  }
  return options;
}

PyFrame advance(Session& session, double end, std::uint64_t most, bool progress) {
  PyFrame frame;
  std::vector<std::string> errors;
  {
    const Use use(session);
    InterruptLater interrupt;
    const Unlock unlock;
    Simulation& run = *session.simulation;
    auto looked = Clock::now();
    std::optional<ProgressLine> line;
    if (progress) line.emplace(run.time(), end);
    // Pieces of about kPatience; a single step where an observer may raise. The results do not
    // depend on the pieces.
    std::uint64_t piece = 1;
    for (std::uint64_t made = 0; made < most;) {
      const bool over = run.time() + 0.5 * run.dt() >= end;
      if (over) break;
      const auto start = Clock::now();
      const std::uint64_t before = run.step_count();
      if (std::isinf(end)) {
        run.step();
        ++made;
      } else {
        run.run_until(std::min(end, run.time() + static_cast<double>(piece) * run.dt()));
      }
      const auto now = Clock::now();
      if (session.observer_failed.load() || interrupt.waiting() || now - looked >= kPatience) {
        if (line) line->show(run.time());
        raise_pending(session, interrupt);
        looked = Clock::now();
      }
      if (run.status() != RunStatus::running) break;
      if (run.paused() && run.step_count() == before) break;
      if (session.observers > 0) continue;
      const double took = std::chrono::duration<double>(now - start).count();
      if (took < 0.005) piece = std::min<std::uint64_t>(2 * piece, 1u << 20);
      if (took > 0.02) piece = std::max<std::uint64_t>(piece / 2, 1);
    }
    if (std::isfinite(end)) run.run_until(end);  // shows the start where no step was needed
    if (line) line->show(run.time());
    raise_pending(session, interrupt);
    frame = frame_of(session);
    errors = new_errors(*session.simulation, session.warned);
  }
  warn(errors);
  return frame;
}

void bind_simulation(py::module_& m) {
  m.def("_end_calls", &end_calls);
  count_forks();
  py::class_<ControllerInput>(m, "ControllerInput", "An input of a controller; see set_input().")
      .def_readonly("name", &ControllerInput::name, "Its name")
      .def_readonly("unit", &ControllerInput::unit, "'' if it has none")
      .def_readonly("lower", &ControllerInput::lower, "Smallest value")
      .def_readonly("upper", &ControllerInput::upper, "Largest value")
      .def_readonly("value", &ControllerInput::value, "The present one")
      .def_readonly("start", &ControllerInput::start, "The one at the start of a run")
      .def("__repr__", [](const ControllerInput& i) {
        return fmt::format("<ControllerInput '{}': {:.6g}>", i.name, i.value);
      });
  py::class_<RunMessage>(m, "Message", "A message of a run: a fault, a rejected command, a report.")
      .def_readonly("time", &RunMessage::time, "[s]")
      .def_property_readonly(
          "severity", [](const RunMessage& r) { return severity_name(r.severity); },
          "'error', 'warning' or 'note'")
      .def_readonly("source", &RunMessage::source, "Name of the robot, controller, command …")
      .def_readonly("message", &RunMessage::message, "What happened")
      .def("__repr__", [](const RunMessage& r) {
        return fmt::format("<Message {} at {:.6g} s, {}: {}>", severity_name(r.severity), r.time,
                           r.source, r.message);
      });
  py::class_<Observation>(m, "Observation", "An observer that can be removed.")
      .def("end", &Observation::end,
           "Remove the observer: it is not called from the next frame on. Call it in the thread "
           "that\n"
           "steps, also in the observer itself.")
      .def("__repr__", [](const Observation&) { return "<Observation>"; });

  py::class_<Session, SessionPtr> type(m, "Simulation",
                                       R"(A running simulation of a scene on one engine.

scene: a Scene, or the path of a scene file.
backend: 'cogrsim', 'bullet', 'mujoco', 'ode', 'simbody', also with options,
    'bullet(iterations=50)'; None: that of the scene.
step: time step [s]; 0: that of the scene. seed: None: that of the scene.
speed: simulated seconds per second; inf: no limit.
isolation: 'process' runs controllers in processes of their own.
without: features of the scene that are left out, as `cogrsim run --without` has them, such as
    ["couplings"]; ["lacking"]: what the engine lacks. .provenance["left_out"] says what that was.

One thread at a time: a call while another thread is inside one raises RuntimeError. Stepping releases the
interpreter's lock; different simulations run in different threads at once. Ctrl-C raises KeyboardInterrupt
between two steps, and the run can be continued.
Raises Error (.diagnostics) if the engine cannot simulate the scene or a plugin is missing.)");
  type.def(py::init(&make_session), py::arg("scene"), py::arg("backend") = py::none(),
           py::kw_only(), py::arg("step") = 0.0, py::arg("seed") = py::none(),
           py::arg("speed") = std::numeric_limits<double>::infinity(),
           py::arg("isolation") = "none", py::arg("without") = std::vector<std::string>())
      .def(
          "step",
          [](const SessionPtr& s, std::int64_t n) {
            if (n < 0)
              throw py::value_error("n: expected 0 or more steps, given " + std::to_string(n));
            return advance(*s, std::numeric_limits<double>::infinity(),
                           static_cast<std::uint64_t>(n));
          },
          py::arg("n") = 1,
          "Make n steps, as fast as possible, and return the frame after them. Fewer if the run "
          "ends or\n"
          "is paused: see status. Errors of the run are shown as RunWarning.")
      .def(
          "run_until",
          [](const SessionPtr& s, double time, bool progress) {
            return advance(*s, finite_time(time, "time"), std::numeric_limits<std::uint64_t>::max(),
                           progress);
          },
          py::arg("time"), py::kw_only(), py::arg("progress") = false,
          "Run until the simulated time [s] and return the frame there; earlier if the run ends or "
          "is\n"
          "paused: see status. progress: show a line of progress on standard error, in a terminal "
          "or\n"
          "notebook. Errors of the run are shown as RunWarning.")
      .def(
          "run_for",
          [](const SessionPtr& s, double duration, bool progress) {
            const double start = [&] {
              const Use use(*s);
              return s->simulation->time();
            }();
            return advance(*s, start + finite_time(duration, "duration"),
                           std::numeric_limits<std::uint64_t>::max(), progress);
          },
          py::arg("duration"), py::kw_only(), py::arg("progress") = false,
          "Run for a simulated duration [s], as run_until().")
      .def_property_readonly(
          "frame",
          [](const SessionPtr& s) {
            const Use use(*s);
            return frame_of(*s);
          },
          "The present Frame")
      .def_property_readonly(
          "time",
          [](const SessionPtr& s) {
            const Use use(*s);
            return s->simulation->time();
          },
          "Simulated time [s]")
      .def_property_readonly(
          "dt",
          [](const SessionPtr& s) {
            const Use use(*s);
            return s->simulation->dt();
          },
          "Time step [s]")
      .def_property_readonly(
          "step_count",
          [](const SessionPtr& s) {
            const Use use(*s);
            return s->simulation->step_count();
          },
          "Number of steps since the start")
      .def_property_readonly(
          "status",
          [](const SessionPtr& s) {
            const Use use(*s);
            return to_string(s->simulation->status());
          },
          "'running', 'completed', 'stopped', 'fault' or 'diverged'")
      .def_property_readonly(
          "paused",
          [](const SessionPtr& s) {
            const Use use(*s);
            return s->simulation->paused();
          },
          "Whether the run is paused")
      .def_property_readonly(
          "state_hash",
          [](const SessionPtr& s) {
            const Use use(*s);
            return fmt::format("{:016x}", state_hash(s->simulation->frame()->state));
          },
          "Hash of the state, as `cogrsim run` prints it: equal hashes mean equal states")
      .def_property_readonly(
          "messages",
          [](const SessionPtr& s) {
            const Use use(*s);
            return s->simulation->messages();
          },
          "list of Message: faults, rejected commands, reports of controllers")
      .def_property_readonly(
          "controller_inputs",
          [](const SessionPtr& s) {
            const Use use(*s);
            py::dict out;
            for (const ControllerInputs& it : s->simulation->controller_inputs())
              out[py::str(it.controller)] = it.inputs;
            return out;
          },
          "dict of lists of ControllerInput by the dotted name of the controller: those that "
          "set_input()\ncan set")
      .def_property_readonly(
          "scene", [](const SessionPtr& s) { return std::const_pointer_cast<Scene>(s->scene); },
          "The Scene")
      .def_property_readonly(
          "backend", [](const SessionPtr& s) { return s->simulation->backend().name(); },
          "Name of the engine")
      .def_property_readonly(
          "engine_version",
          [](const SessionPtr& s) { return s->simulation->backend().engine_version(); },
          "Version of the engine's own library")
      .def_property_readonly(
          "seed",
          [](const SessionPtr& s) {
            const Use use(*s);
            return s->simulation->model()->physics.seed;
          },
          "Seed of this run")
      .def_property_readonly(
          "drawn",
          [](const SessionPtr& s) {
            const Use use(*s);
            py::dict out;
            for (const DrawnValue& it : s->simulation->model()->drawn)
              out[py::str(it.quantity)] = it.value;
            return out;
          },
          "Values that <randomize> has drawn for this run, in SI units, as a dict")
      .def_property_readonly(
          "provenance",
          [](const SessionPtr& s) {
            return py::module_::import("json").attr("loads")(
                to_json_text(s->simulation->provenance()));
          },
          "Which code computes each stage of a step, and all options in use, as a dict")
      .def_property_readonly(
          "notes", [](const SessionPtr& s) { return s->notes; },
          "What resume() could not transfer; empty otherwise")
      .def(
          "observe", &observe, py::arg("callback"), py::kw_only(), py::arg("contacts") = false,
          py::arg("joint_reactions") = false, py::arg("accelerations") = false,
          py::arg("for_sensors") = false,
          "Call callback(frame) with every new frame; the first observer also gets the present "
          "one.\n"
          "The flags ask for contents beside state, readings and events. An exception ends the\n"
          "call that steps, after the step, and is raised there. Returns an Observation. A "
          "callback that\n"
          "refers to this simulation keeps it until Observation.end(): use a weak reference there.")
      .def(
          "reload_controller",
          [](const SessionPtr& s, const std::string& name) {
            const Use use(*s);
            const Reloaded done = value_of([&] {
              const Unlock unlock;
              return s->simulation->reload_controller(name);
            }());
            py::dict out;
            out["controller"] = done.controller;
            out["plugin"] = done.plugin;
            out["version"] = done.version;
            out["memory_kept"] = done.memory_kept;
            out["note"] = done.note;
            return out;
          },
          py::arg("name"),
          "Replace the library of a controller by the file that is there now; `name` may be its "
          "assembly.\n"
          "The new one gets what save() of the old one returns, or restarts. Returns a dict: "
          "controller,\n"
          "plugin, version, memory_kept, and note: why it restarted. Raises Error, after which "
          "nothing\n"
          "has changed: no such controller, or the new library does not fit the scene.")
      .def(
          "stop", [](const SessionPtr& s) { s->simulation->stop(); },
          "End the run at the next step boundary. From any thread.")
      .def("__repr__", [](const SessionPtr& s) {
        return fmt::format("<Simulation of '{}' on {}>", s->scene->model->name,
                           s->simulation->backend().name());
      });
  bind_commands(type);
  bind_snapshots(m, type);
}

}  // namespace cogrsim::python
