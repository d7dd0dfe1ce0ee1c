// Robots from and to other formats.
#include "cogrsim/dsl/export_model.h"
#include "cogrsim/dsl/import_model.h"
#include "cogrsim/dsl/loader_catalog.h"

#include <filesystem>

#include "cogrsim/core/output_file.h"
#include "common.h"
#include "scene.h"

namespace cogrsim::python {

namespace {

namespace fs = std::filesystem;

/// The value of a word. Raises ValueError with the words that there are.
template <class Value, std::size_t kCount>
Value chosen(const char* argument, const std::string& word,
             const std::pair<const char*, Value> (&words)[kCount]) {
  std::string known;
  for (const auto& [name, value] : words) {
    if (word == name) return value;
    known += (known.empty() ? "'" : ", '") + std::string(name) + "'";
  }
  throw py::value_error(std::string(argument) + ": expected one of " + known + ", given '" + word +
                        "'");
}

/// What was read, and how it can be read again.
struct Imported : dsl::ImportResult {
  std::string file;
  dsl::ImportOptions options;
};

/// Raises CompileError if nothing could be made of it.
std::shared_ptr<Imported> read_model(const std::string& file, dsl::ImportOptions options) {
  dsl::LoaderCatalog catalog;
  options.plugins = &catalog;
  auto result = std::make_shared<Imported>();
  {
    const Unlock unlock;
    static_cast<dsl::ImportResult&>(*result) = dsl::import_model(file, options);
  }
  if (result->scene.empty()) raise("CompileError", result->diagnostics);
  options.plugins = nullptr;
  result->file = file;
  result->options = std::move(options);
  return result;
}

std::shared_ptr<Imported> import_model(const py::object& path,
                                       const std::map<std::string, py::object>& packages,
                                       const std::map<std::string, std::string>& arguments,
                                       const std::string& drives, bool fixed_base, bool floor,
                                       const py::object& semantics, const std::string& keyframe,
                                       int convex_parts) {
  dsl::ImportOptions options;
  for (const auto& [name, folder] : packages) options.packages[name] = path_of(folder);
  options.arguments = arguments;
  options.fixed_base = fixed_base;
  options.floor = floor;
  options.keyframe = keyframe;
  if (convex_parts < 0 || convex_parts > 64)
    throw py::value_error("convex_parts: expected 0 to 64, given " + std::to_string(convex_parts));
  options.convex_parts = convex_parts;
  if (!semantics.is_none()) options.semantics = path_of(semantics);
  const std::pair<const char*, dsl::ImportDrives> kinds[] = {
      {"none", dsl::ImportDrives::none},
      {"position", dsl::ImportDrives::position},
      {"torque", dsl::ImportDrives::torque},
      {"velocity", dsl::ImportDrives::velocity}};
  options.drives = chosen("drives", drives, kinds);
  return read_model(path_of(path), std::move(options));
}

/// Writes a model's text, and the files that belong beside it. What it was made of is not replaced.
template <class Model>
void write(const Model& model, const std::string& text, OutputKind kind, const fs::path& to,
           bool overwrite) {
  OutputRules rules;
  rules.overwrite = overwrite;
  rules.inputs = model.files_read;
  check(check_output(to.string(), kind, rules));
  check(dsl::write_beside(to.parent_path().string(), model.files, rules));
  check(write_output_file(to.string(), kind, text, rules));
}

/// Writes the scene, whose meshes are referred to from the folder it lies in, or are copied there.
void write_import(const Imported& model, const fs::path& to, bool overwrite) {
  const fs::path folder = fs::absolute(to).parent_path();
  if (folder.lexically_normal() == fs::absolute(model.file).parent_path().lexically_normal())
    return write(model, model.scene, OutputKind::xml, to, overwrite);
  dsl::ImportOptions options = model.options;
  options.scene_folder = folder.string();
  const std::shared_ptr<Imported> moved = read_model(model.file, std::move(options));
  write(*moved, moved->scene, OutputKind::xml, to, overwrite);
}

struct Exported : dsl::ExportResult {
  std::vector<std::string> files_read;  ///< of the scene
};

std::shared_ptr<Exported> export_model(const py::object& scene, const std::string& format,
                                       const std::string& assembly) {
  dsl::ExportOptions options;
  options.assembly = assembly;
  const std::pair<const char*, dsl::ExportFormat> formats[] = {{"urdf", dsl::ExportFormat::urdf},
                                                               {"sdf", dsl::ExportFormat::sdf},
                                                               {"mjcf", dsl::ExportFormat::mjcf}};
  options.format = chosen("format", format, formats);
  const ScenePtr source = scene_of(scene);
  auto result = [&] {
    const Unlock unlock;
    return dsl::export_model(*source->model, options);
  }();
  return std::make_shared<Exported>(Exported{value_of(std::move(result)), source->files});
}

std::string name_of(const dsl::ImportResult& model) { return "ImportedModel " + model.format; }
std::string name_of(const Exported&) { return "ExportedModel"; }

/// What imported and exported models have alike.
template <class Model>
void bind_conversion(py::class_<Model, std::shared_ptr<Model>>& type, const char* order) {
  type.def_readonly("report", &Model::entries, order)
      .def_property_readonly(
          "files",
          [](const Model& m) {
            py::dict out;
            for (const dsl::ImportedFile& file : m.files)
              out[py::str(file.name)] = py::bytes(file.bytes);
            return out;
          },
          "Contents of the files that belong beside it, by name")
      .def(
          "count",
          [](const Model& m, const std::string& fidelity) {
            for (const auto one :
                 {dsl::Fidelity::exact, dsl::Fidelity::approximate, dsl::Fidelity::left_out})
              if (fidelity == dsl::fidelity_name(one)) return m.count(one);
            raise_unknown("fidelity", fidelity, {"exact", "approximate", "left out"});
          },
          py::arg("fidelity"), "Number of elements that are 'exact', 'approximate' or 'left out'.")
      .def("__repr__", [](const Model& m) {
        return "<" + name_of(m) + ": " + std::to_string(m.count(dsl::Fidelity::exact)) +
               " exact, " + std::to_string(m.count(dsl::Fidelity::approximate)) + " approximate, " +
               std::to_string(m.count(dsl::Fidelity::left_out)) + " left out>";
      });
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
  py::class_<Imported, std::shared_ptr<Imported>> imported(
      m, "ImportedModel", "A robot or world in another format, as a scene.");
  imported.def_readonly("format", &dsl::ImportResult::format, "'URDF', 'MJCF' or 'SDF'")
      .def_readonly("scene", &dsl::ImportResult::scene, "The scene, XML")
      .def_readonly("diagnostics", &dsl::ImportResult::diagnostics, "Warnings and notes")
      .def_readonly("files_read", &dsl::ImportResult::files_read,
                    "Paths of all files that were read")
      .def(
          "write",
          [](const Imported& r, const py::object& path, bool overwrite) {
            write_import(r, path_of(path), overwrite);
          },
          py::arg("path"), py::kw_only(), py::arg("overwrite") = false,
          "Write the scene to a file, and the files that belong beside it. In another folder than "
          "the model's its "
          "meshes are copied beside it, too.");
  bind_conversion(imported, "list of ImportEntry, in the order of the source");
  py::class_<Exported, std::shared_ptr<Exported>> exported(
      m, "ExportedModel", "A scene, or one assembly of it, in another format.");
  exported.def_readonly("text", &Exported::text, "The file, XML")
      .def(
          "write",
          [](const Exported& r, const py::object& path, bool overwrite) {
            write(r, r.text, OutputKind::other, path_of(path), overwrite);
          },
          py::arg("path"), py::kw_only(), py::arg("overwrite") = false,
          "Write the text to a file, and the meshes into a folder beside it.");
  bind_conversion(exported, "list of ImportEntry, in the order of the scene");
  m.def(
      "import_model", &import_model, py::arg("path"), py::kw_only(),
      py::arg("packages") = std::map<std::string, py::object>(),
      py::arg("arguments") = std::map<std::string, std::string>(), py::arg("drives") = "none",
      py::arg("fixed_base") = false, py::arg("floor") = true, py::arg("semantics") = py::none(),
      py::arg("keyframe") = "", py::arg("convex_parts") = 0,
      "Read a URDF (also xacro), MJCF or SDF file as a scene.\n\n"
      "packages: folders of ROS packages by name. arguments: of xacro. drives: motors of joints "
      "for which\n"
      "the source names none: 'none', 'position', 'torque' or 'velocity'. semantics: an SRDF "
      "file.\n"
      "keyframe: of an MJCF, in which the robot starts: its name, or, if it has none, its number "
      "from 1.\n"
      "convex_parts: moving meshes of URDF and SDF collide as up to so many convex parts, 1 to 64; "
      "0: as their\n"
      "hull. Takes seconds for each mesh.\n"
      "Raises CompileError (.diagnostics): nothing could be made of it.");
  m.def("export_model", &export_model, py::arg("scene"), py::arg("format"), py::kw_only(),
        py::arg("assembly") = "",
        "A Scene, or a scene file, at time 0 as 'urdf', 'sdf' or 'mjcf'; an ExportedModel.\n\n"
        "assembly: dotted name of the one to write; '': the whole scene.\n"
        "Raises ValueError: an unknown format; Error: no such assembly, or no body to write.");
}

}  // namespace cogrsim::python
