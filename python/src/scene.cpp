// Compiling scenes: compile(), compile_string(), check(), Scene, Diagnostic.
#include "scene.h"

#include <algorithm>

#include "cogrsim/core/units.h"
#include "cogrsim/dsl/compiler.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/dsl/schema.h"

namespace cogrsim::python {

namespace {

std::string setting_text(const std::string& name, const py::handle& value, int depth = 0) {
  if (py::isinstance<py::str>(value)) return text_of(value, "set['" + name + "']");
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::int_>(value)) return py::str(value).cast<std::string>();
  if (py::hasattr(value, "__float__"))
    return units::number_text(py::float_(py::reinterpret_borrow<py::object>(value)));
  if (py::isinstance<py::sequence>(value) && depth < 8) {
    std::string out;
    for (const py::handle& entry : value)
      out += (out.empty() ? "" : ", ") + setting_text(name, entry, depth + 1);
    return "[" + out + "]";
  }
  throw py::type_error("set['" + name +
                       "']: expected a text as in a scene (\"4 cm\"), a number, a "
                       "boolean or a list of these, given " +
                       type_name(value));
}

/// The options that compile(), compile_string() and check() share.
struct Request {
  dsl::CompileOptions options;
  std::shared_ptr<PluginLoader> loader;

  Request(const py::object& set, const std::optional<std::uint64_t>& seed,
          const std::vector<py::object>& plugin_path, const std::vector<py::object>& library_path) {
    std::vector<std::string> folders;
    for (const py::object& folder : plugin_path) folders.push_back(path_of(folder));
    loader = std::make_shared<PluginLoader>(std::move(folders));
    options.set_parameters = settings_of(set);
    options.seed = seed;
    for (const py::object& folder : library_path)
      options.library_folders.push_back(path_of(folder));
  }

  template <class Compile>
  ScenePtr finish(const std::string& path, Compile&& compile) {
    dsl::LoaderCatalog catalog(loader);
    options.plugins = &catalog;
    dsl::CompileResult result;
    {
      const Unlock unlock;
      result = compile(options);
    }
    auto scene = std::make_shared<Scene>();
    scene->model = std::move(result.model);
    scene->diagnostics = std::move(result.diagnostics);
    scene->files = std::move(result.files_read);
    scene->path = path;
    scene->set = options.set_parameters;
    scene->seed = options.seed;
    scene->loader = std::move(loader);
    return scene;
  }
};

ScenePtr compiled(ScenePtr scene) {
  if (!scene->model) raise("CompileError", scene->diagnostics);
  return scene;
}

ScenePtr compile_path(const py::object& path, const py::object& set,
                      const std::optional<std::uint64_t>& seed,
                      const std::vector<py::object>& plugin_path,
                      const std::vector<py::object>& library_path) {
  const std::string file = path_of(path);
  return Request(set, seed, plugin_path, library_path).finish(file, [&](const auto& options) {
    return dsl::compile_file(file, options);
  });
}

py::dict body_info(const Scene& scene, const std::string& name) {
  const Body& body = scene.model->bodies[index_of(scene.model->bodies, "body", name)];
  const char* const kinds[] = {"dynamic", "kinematic", "static"};
  py::dict out;
  out["name"] = body.name;
  out["kind"] = kinds[static_cast<int>(body.kind)];
  out["mass"] = body.mass;
  out["com"] = to_python(body.com);
  std::vector<double> inertia;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) inertia.push_back(body.inertia(row, column));
  }
  out["inertia"] = owned(std::move(inertia), {3, 3});
  out["position"] = to_python(body.X_WB.p);
  out["orientation"] = to_python(body.X_WB.q);
  out["place"] = source_position(*scene.model, body.origin).position_text();
  return out;
}

py::dict motor_info(const Scene& scene, const std::string& name) {
  const Motor& motor = scene.model->motors[index_of(scene.model->motors, "motor", name)];
  const Joint& joint = scene.model->joints[motor.joint];
  py::dict out;
  out["name"] = motor.name;
  out["joint"] = joint.name;
  out["axis"] = motor.axis;
  out["mode"] = to_string(motor.mode);
  out["max_effort"] = motor.max_effort;
  out["max_speed"] = motor.max_speed;
  out["max_voltage"] = motor.max_voltage;
  const auto axis = static_cast<std::size_t>(motor.axis);
  if (axis < joint.axes.size()) {
    out["max_effort"] = std::min(motor.max_effort, joint.axes[axis].max_effort);
    out["max_speed"] = std::min(motor.max_speed, joint.axes[axis].max_speed);
    out["lower"] = joint.axes[axis].lower;
    out["upper"] = joint.axes[axis].upper;
  }
  return out;
}

constexpr const char* kCompileDoc = R"(Compile a scene file.

path: str or os.PathLike, of a .scene.xml file.
set: values of the scene's <param>s by name, as written in a scene ("4 cm"), or numbers in SI units.
seed: replaces the seed of <physics>.
plugin_path: folders in which plugins (also modules of "py:MODULE.CLASS") are searched first.
library_path: folders from which files may be imported, beside the scene's own.

Returns a Scene; its warnings are in scene.diagnostics.
Raises CompileError: the scene has errors (also a file that cannot be read, or a wrong name, unit or
value in `set`); its text names file, line, column, code, message and remedy, and .diagnostics lists
them as objects. TypeError: a value of `set` has another type.)";

}  // namespace

std::map<std::string, std::string> settings_of(const py::object& set) {
  std::map<std::string, std::string> out;
  if (set.is_none()) return out;
  if (!py::isinstance<py::dict>(set)) {
    throw py::type_error("set: expected a dict of parameters by name, given " + type_name(set));
  }
  for (const auto& [name, value] : py::dict(set)) {
    const std::string key = text_of(py::str(name), "set");
    out[key] = setting_text(key, value);
  }
  return out;
}

ScenePtr scene_of(const py::object& scene) {
  if (py::isinstance<Scene>(scene)) return scene.cast<std::shared_ptr<Scene>>();
  if (py::isinstance<py::str>(scene) || py::hasattr(scene, "__fspath__")) {
    return compiled(compile_path(scene, py::none(), std::nullopt, {}, {}));
  }
  throw py::type_error("scene: expected a Scene or the path of a scene file, given " +
                       type_name(scene));
}

namespace {

/// Texts may quote bytes that are no UTF-8.
py::tuple position_of(const SourcePosition& at) {
  return py::make_tuple(py::bytes(at.file), at.line, at.column, at.length);
}
void locate(SourcePosition& at, const py::tuple& state) {
  at.file = state[0].cast<std::string>();
  at.line = state[1].cast<int>();
  at.column = state[2].cast<int>();
  at.length = state[3].cast<int>();
}

py::tuple state_of(const Diagnostic& d) {
  py::list notes;
  for (const DiagnosticNote& note : d.notes)
    notes.append(py::make_tuple(position_of(note), py::bytes(note.message)));
  return py::make_tuple(position_of(d), static_cast<int>(d.severity), py::bytes(d.code),
                        py::bytes(d.message), py::bytes(d.source_line), py::bytes(d.help), notes);
}

Diagnostic diagnostic_of(const py::tuple& state) {
  Diagnostic d;
  locate(d, state[0]);
  d.severity = static_cast<Severity>(state[1].cast<int>());
  d.code = state[2].cast<std::string>();
  d.message = state[3].cast<std::string>();
  d.source_line = state[4].cast<std::string>();
  d.help = state[5].cast<std::string>();
  for (const py::handle& note : state[6]) {
    const auto parts = note.cast<py::tuple>();
    DiagnosticNote made(parts[1].cast<std::string>());
    locate(made, parts[0]);
    d.notes.push_back(std::move(made));
  }
  return d;
}

}  // namespace

void bind_scene(py::module_& m) {
  py::class_<Diagnostic>(m, "Diagnostic", "One finding about a scene: where, what, and the remedy.")
      .def_property_readonly(
          "severity", [](const Diagnostic& d) { return severity_name(d.severity); },
          "'error', 'warning' or 'note'")
      .def_readonly("code", &Diagnostic::code, "Stable code such as 'CG0502'; may be ''")
      .def_property_readonly(
          "message", [](const Diagnostic& d) { return shown(d.message); }, "What is wrong")
      .def_property_readonly(
          "file", [](const Diagnostic& d) { return shown(d.file); },
          "Path as the user wrote it; '': no source location")
      .def_readonly("line", &Diagnostic::line, "From 1; 0: unknown")
      .def_readonly("column", &Diagnostic::column, "From 1, in code points; 0: unknown")
      .def_readonly("length", &Diagnostic::length, "Code points to underline")
      .def_readonly("remedy", &Diagnostic::help, "How to correct it; may be ''")
      .def_property_readonly(
          "notes",
          [](const Diagnostic& d) {
            std::vector<std::string> notes;
            for (const DiagnosticNote& note : d.notes) notes.push_back(note.message);
            return notes;
          },
          "Further lines, such as the instance of a prototype")
      .def("__str__", [](const Diagnostic& d) { return shown(dsl::to_text(d)); })
      .def("__repr__",
           [](const Diagnostic& d) {
             return shown("<Diagnostic " + std::string(severity_name(d.severity)) + " " + d.code +
                          " " + d.position_text() + ": " + d.message + ">");
           })
      .def("_state", &state_of);
  m.def("_diagnostic", &diagnostic_of);

  py::class_<Scene, std::shared_ptr<Scene>>(
      m, "Scene", "A compiled scene; immutable. Any number of simulations may share it.")
      .def_property_readonly(
          "name", [](const Scene& s) { return s.model->name; }, "Name of the scene")
      .def_readonly("path", &Scene::path, "Path of the file; '' for a text")
      .def_readonly("files", &Scene::files, "Absolute paths of all files that were read")
      .def_readonly("diagnostics", &Scene::diagnostics, "Warnings and notes of the compiler")
      .def_readonly("set", &Scene::set, "The parameters that were set, as text")
      .def_readonly("seed", &Scene::seed, "Seed given to compile(), or None: that of the scene")
      .def_property_readonly(
          "bodies", [](const Scene& s) { return names_of(s.model->bodies); },
          "Dotted names of the bodies")
      .def_property_readonly(
          "assemblies", [](const Scene& s) { return names_of(s.model->assemblies); },
          "Dotted names of the assemblies")
      .def_property_readonly(
          "joints", [](const Scene& s) { return names_of(s.model->joints); },
          "Dotted names of the joints")
      .def_property_readonly(
          "motors", [](const Scene& s) { return names_of(s.model->motors); },
          "Dotted names of the motors")
      .def_property_readonly(
          "sensors", [](const Scene& s) { return names_of(s.model->sensors); },
          "Dotted names of the sensors")
      .def_property_readonly(
          "controllers", [](const Scene& s) { return names_of(s.model->controllers); },
          "Dotted names of the controllers")
      .def_property_readonly(
          "backend", [](const Scene& s) { return s.model->physics.backend; },
          "The engine that the scene names; '': none")
      .def_property_readonly(
          "dt", [](const Scene& s) { return s.model->physics.step; }, "Time step [s]")
      .def_property_readonly(
          "duration", [](const Scene& s) { return s.model->physics.duration; },
          "Length of a run [s]; None: not given")
      .def_property_readonly(
          "seed", [](const Scene& s) { return s.model->physics.seed; },
          "Seed of runs that are given none")
      .def_property_readonly(
          "gravity", [](const Scene& s) { return to_python(s.model->physics.gravity); },
          "(x, y, z) [m/s^2]")
      .def("body", &body_info, py::arg("name"),
           "Properties of a body as a dict: kind, mass [kg], com [m], inertia (3, 3) [kg m^2] "
           "about the\n"
           "centre of mass, position [m] and orientation (w, x, y, z) at the start, place in the "
           "file.\n"
           "Raises KeyError naming the nearest names.")
      .def("motor", &motor_info, py::arg("name"),
           "Properties of a motor as a dict: joint, axis, mode, max_effort [N m] or [N], max_speed "
           "[rad/s]\n"
           "or [m/s], max_voltage [V], lower and upper limit of the joint. Raises KeyError.")
      .def("__repr__", [](const Scene& s) {
        return "<Scene '" + s.model->name + "': " + std::to_string(s.model->bodies.size()) +
               " bodies, " + std::to_string(s.model->joints.size()) + " joints>";
      });

  const auto none = py::none();
  const std::vector<py::object> no_folders;
  m.def(
      "compile",
      [](const py::object& path, const py::object& set, const std::optional<std::uint64_t>& seed,
         const std::vector<py::object>& plugin_path, const std::vector<py::object>& library_path) {
        return compiled(compile_path(path, set, seed, plugin_path, library_path));
      },
      py::arg("path"), py::kw_only(), py::arg("set") = none, py::arg("seed") = none,
      py::arg("plugin_path") = no_folders, py::arg("library_path") = no_folders, kCompileDoc);
  m.def(
      "compile_string",
      [](const std::string& text, const std::string& name, const py::object& set,
         const std::optional<std::uint64_t>& seed, const std::vector<py::object>& plugin_path,
         const std::vector<py::object>& library_path) {
        return compiled(
            Request(set, seed, plugin_path, library_path).finish("", [&](const auto& options) {
              return dsl::compile_text(text, name, options);
            }));
      },
      py::arg("text"), py::arg("name") = "scene", py::kw_only(), py::arg("set") = none,
      py::arg("seed") = none, py::arg("plugin_path") = no_folders,
      py::arg("library_path") = no_folders,
      "Compile a scene held in a text. `name` stands in diagnostics, and files are imported from "
      "its\n"
      "folder (the current one for a bare name). Otherwise as compile().");
  m.def(
      "_schema", [] { return dsl::write_schema_json(); }, "The scene language, as JSON.");
  m.def(
      "check",
      [](const py::object& path, const py::object& set, const std::optional<std::uint64_t>& seed,
         const std::vector<py::object>& plugin_path, const std::vector<py::object>& library_path) {
        return compile_path(path, set, seed, plugin_path, library_path)->diagnostics;
      },
      py::arg("path"), py::kw_only(), py::arg("set") = none, py::arg("seed") = none,
      py::arg("plugin_path") = no_folders, py::arg("library_path") = no_folders,
      "All diagnostics of a scene file, errors and warnings, without raising. Arguments as "
      "compile().");
  m.def(
      "explain",
      [](const std::string& code) {
        const std::string text = dsl::explain(code);
        if (text.empty()) raise_unknown("diagnostic", code, dsl::diagnostic_codes());
        return text;
      },
      py::arg("code"), "What a code such as 'CG0502' means: cause, remedy and an example.");
}

}  // namespace cogrsim::python
