// Robots in other formats.
#include "cogrsim/dsl/import_model.h"

#include <filesystem>

#include "cogrsim/core/output_file.h"
#include "common.h"

namespace cogrsim::python {

namespace {

namespace fs = std::filesystem;

std::shared_ptr<dsl::ImportResult> import_model(const py::object& path,
                                                const std::map<std::string, py::object>& packages,
                                                const std::map<std::string, std::string>& arguments,
                                                const std::string& drives, bool fixed_base,
                                                bool floor, const py::object& semantics) {
  dsl::ImportOptions options;
  for (const auto& [name, folder] : packages) options.packages[name] = path_of(folder);
  options.arguments = arguments;
  options.fixed_base = fixed_base;
  options.floor = floor;
  if (!semantics.is_none()) options.semantics = path_of(semantics);
  const std::pair<const char*, dsl::ImportDrives> kinds[] = {
      {"none", dsl::ImportDrives::none},
      {"position", dsl::ImportDrives::position},
      {"torque", dsl::ImportDrives::torque},
      {"velocity", dsl::ImportDrives::velocity}};
  bool known = false;
  for (const auto& [name, kind] : kinds) {
    if (drives != name) continue;
    options.drives = kind;
    known = true;
  }
  if (!known) {
    throw py::value_error("drives: expected 'none', 'position', 'torque' or 'velocity', given '" +
                          drives + "'");
  }
  const std::string file = path_of(path);
  auto result = std::make_shared<dsl::ImportResult>([&] {
    const py::gil_scoped_release unlock;
    return dsl::import_model(file, options);
  }());
  if (result->scene.empty()) raise("CompileError", result->diagnostics);
  return result;
}

void write(const dsl::ImportResult& self, const py::object& path, bool overwrite) {
  const fs::path scene = path_of(path);
  OutputRules rules;
  rules.overwrite = overwrite;
  check(write_output_file(scene.string(), OutputKind::xml, self.scene, rules));
  for (const dsl::ImportedFile& file : self.files) {
    const auto to =
        output_in(scene.has_parent_path() ? scene.parent_path().string() : ".", file.name);
    if (!to) raise(to.error());
    std::error_code error;
    fs::create_directories(fs::path(*to).parent_path(), error);
    check(write_output_file(*to, OutputKind::other, file.bytes, rules));
  }
}

}  // namespace

void bind_import(py::module_& m) {
  py::class_<dsl::ImportEntry>(m, "ImportEntry", "What became of one element of the source.")
      .def_property_readonly(
          "fidelity", [](const dsl::ImportEntry& e) { return dsl::fidelity_name(e.fidelity); },
          "'exact', 'approximate' or 'left out'")
      .def_readonly("element", &dsl::ImportEntry::element, "Kind and name, such as \"joint 'arm'\"")
      .def_readonly("message", &dsl::ImportEntry::message, "What differs; '': nothing")
      .def_readonly("file", &dsl::ImportEntry::file, "Path of the source")
      .def_readonly("line", &dsl::ImportEntry::line, "From 1; 0: unknown")
      .def_readonly("column", &dsl::ImportEntry::column, "From 1; 0: unknown")
      .def("__repr__", [](const dsl::ImportEntry& e) {
        return "<" + std::string(dsl::fidelity_name(e.fidelity)) + ": " + e.element +
               (e.message.empty() ? "" : ": " + e.message) + ">";
      });
  py::class_<dsl::ImportResult, std::shared_ptr<dsl::ImportResult>>(
      m, "ImportedModel", "A robot or world in another format, as a scene.")
      .def_readonly("format", &dsl::ImportResult::format, "'URDF', 'MJCF' or 'SDF'")
      .def_readonly("scene", &dsl::ImportResult::scene, "The scene, XML")
      .def_readonly("report", &dsl::ImportResult::entries,
                    "list of ImportEntry, in the order of the source")
      .def_readonly("diagnostics", &dsl::ImportResult::diagnostics, "Warnings and notes")
      .def_readonly("files_read", &dsl::ImportResult::files_read,
                    "Paths of all files that were read")
      .def_property_readonly(
          "files",
          [](const dsl::ImportResult& r) {
            py::dict out;
            for (const dsl::ImportedFile& file : r.files)
              out[py::str(file.name)] = py::bytes(file.bytes);
            return out;
          },
          "Contents of the files that belong beside the scene, by name")
      .def(
          "count",
          [](const dsl::ImportResult& r, const std::string& fidelity) {
            for (const auto one :
                 {dsl::Fidelity::exact, dsl::Fidelity::approximate, dsl::Fidelity::left_out}) {
              if (fidelity == dsl::fidelity_name(one)) return r.count(one);
            }
            raise_unknown("fidelity", fidelity, {"exact", "approximate", "left out"});
          },
          py::arg("fidelity"), "Number of elements that are 'exact', 'approximate' or 'left out'.")
      .def("write", &write, py::arg("path"), py::kw_only(), py::arg("overwrite") = false,
           "Write the scene to a file, and the files that belong beside it.")
      .def("__repr__", [](const dsl::ImportResult& r) {
        return "<ImportedModel " + r.format + ": " + std::to_string(r.count(dsl::Fidelity::exact)) +
               " exact, " + std::to_string(r.count(dsl::Fidelity::approximate)) + " approximate, " +
               std::to_string(r.count(dsl::Fidelity::left_out)) + " left out>";
      });
  m.def("import_model", &import_model, py::arg("path"), py::kw_only(),
        py::arg("packages") = std::map<std::string, py::object>(),
        py::arg("arguments") = std::map<std::string, std::string>(), py::arg("drives") = "none",
        py::arg("fixed_base") = false, py::arg("floor") = true, py::arg("semantics") = py::none(),
        "Read a URDF (also xacro), MJCF or SDF file as a scene.\n\n"
        "packages: folders of ROS packages by name. arguments: of xacro. drives: motors of joints "
        "for which\n"
        "the source names none: 'none', 'position', 'torque' or 'velocity'. semantics: an SRDF "
        "file.\n"
        "Raises CompileError (.diagnostics): nothing could be made of it.");
}

}  // namespace cogrsim::python
