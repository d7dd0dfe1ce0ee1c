// Finds the classes behind names such as "py:steer.Steer".
#include "cogrsim/plugin/source.h"

#include "cogrsim/core/units.h"
#include "python_plugins.h"
#include "scene.h"

namespace cogrsim::python {

namespace {

/// A descriptor with what it refers to.
struct Declared {
  PluginDescriptor descriptor;
  PluginClassPtr cls;
};

ParameterValue default_of(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::int_>(value)) return value.cast<std::int64_t>();
  if (py::isinstance<py::float_>(value)) return value.cast<double>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  return value.cast<std::vector<double>>();
}

ParameterTable table_of(const py::object& cls) {
  ParameterTable table;
  for (const py::handle& one : cls.attr("parameters")) {
    ParameterSpec spec;
    spec.name = one.attr("name").cast<std::string>();
    spec.default_value = default_of(one.attr("default"));
    spec.unit = one.attr("unit").cast<std::string>();
    spec.description = one.attr("description").cast<std::string>();
    spec.minimum = one.attr("minimum").cast<double>();
    spec.maximum = one.attr("maximum").cast<double>();
    spec.choices = one.attr("choices").cast<std::vector<std::string>>();
    spec.required = one.attr("required").cast<bool>();
    table.push_back(std::move(spec));
  }
  return table;
}

/// The message of an exception that _plugins.py raises.
std::string first_argument(const py::error_already_set& error) {
  return py::str(error.value().attr("args")[py::int_(0)]).cast<std::string>();
}

using Found = Result<std::shared_ptr<const PluginDescriptor>>;

Found declare(PluginKind kind, const std::string& name, const std::vector<std::string>& folders) {
  const py::object cls =
      py::module_::import("cogrsim._plugins").attr("find")(to_string(kind), name, folders);
  auto declared = std::make_shared<Declared>();
  PluginDescriptor& d = declared->descriptor;
  d.kind = kind;
  d.name = name;
  d.parameters = table_of(cls);
  if (kind != PluginKind::sensor) {
    for (const py::handle& one : cls.attr("outputs")) {
      d.outputs.push_back({one.attr("name").cast<std::string>(),
                           one.attr("unit").cast<std::string>(),
                           one.attr("description").cast<std::string>()});
    }
  }
  declared->cls = std::make_shared<const PluginClass>(
      PluginClass{hold(cls), std::make_shared<const ParameterTable>(d.parameters)});
  d.factory = kind == PluginKind::controller   ? controller_factory(declared->cls)
              : kind == PluginKind::supervisor ? supervisor_factory(declared->cls)
                                               : sensor_factory(declared->cls);
  if (!d.factory) {
    return fail("more than " + std::to_string(kSlots) + " Python classes are in use", "",
                "delete scenes and simulations that are not needed", "CG0902");
  }
  return std::shared_ptr<const PluginDescriptor>(declared, &declared->descriptor);
}

Found find(PluginKind kind, const std::string& name, const std::vector<std::string>& folders) {
  if (kind != PluginKind::controller && kind != PluginKind::supervisor &&
      kind != PluginKind::sensor) {
    return fail(std::string(to_string(kind)) + " '" + name + "' cannot be a Python class", "", "",
                "CG0903");
  }
  const Lock lock;
  try {
    return declare(kind, name, folders);
  } catch (py::error_already_set& error) {
    const py::object ours = py::module_::import("cogrsim._plugins");
    for (const auto& [kind_of_error, code] :
         {std::pair("NotFound", "CG0901"), std::pair("WrongKind", "CG0903")})
      if (error.matches(ours.attr(kind_of_error))) return fail(first_argument(error), "", "", code);
    return fail(std::string(to_string(kind)) + " '" + name +
                    "' cannot be imported: " + exception_text(error),
                "", "", "CG0902");
  } catch (const std::exception& error) {
    return fail(std::string(to_string(kind)) + " '" + name + "': " + error.what(), "",
                "declare parameters with cogrsim.parameter() and outputs with cogrsim.output()",
                "CG0902");
  }
}

Result<std::vector<std::string>> host(const std::string& name) {
  const Lock lock;
  try {
    return py::module_::import("cogrsim._plugins")
        .attr("host_command")(name)
        .cast<std::vector<std::string>>();
  } catch (py::error_already_set& error) {
    return fail(error.matches(py::module_::import("cogrsim._plugins").attr("NotFound"))
                    ? first_argument(error)
                    : exception_text(error),
                "", "", "CG0902");
  }
}

}  // namespace

void bind_controllers(py::module_& m) {
  set_plugin_source("py:", find, host);
  m.def("_is_unit",
        [](const std::string& text) { return text == "1" || units::parse_unit(text).has_value(); });
  m.def("_serve_isolated_controller", &serve_isolated_controller, py::call_guard<Unlock>());
}

}  // namespace cogrsim::python
