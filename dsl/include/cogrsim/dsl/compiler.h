// The scene compiler: XML in, SceneModel or diagnostics out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/export.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/plugin/descriptor.h"
#include "cogrsim/sensing/sensor.h"

namespace cogrsim::dsl {

/// What the compiler asks about plugins, by name only; LoaderCatalog (loader_catalog.h) answers with
/// a plugin loader. A program without plugins passes none: scenes may then name plugins, and not
/// set their parameters.
class COGRSIM_API PluginCatalog {
 public:
  virtual ~PluginCatalog();

  /// Parameter table of a controller, supervisor or sensor. Errors carry their code
  /// (CG0901 not found, CG0902 refused, CG0903 wrong kind) and the folders searched.
  virtual Result<ParameterTable> parameters(PluginKind kind, const std::string& name) = 0;

  /// What a controller or supervisor publishes, so that signals can name it; nothing where that is
  /// not known. Asked only about plugins of which parameters() said something.
  virtual std::vector<OutputModel> outputs(PluginKind kind, const std::string& name);

  /// What a plugin's sensor reads, so that the units of its signals can be checked; nothing where
  /// that is not known. Asked only about types of which parameters() said something; `model` has
  /// all bodies and joints, and its parameters are complete.
  virtual std::vector<Channel> channels(const SceneModel& model, const SensorModel& sensor);

  /// Every plugin of a kind that can be found; backends name the engine blocks `<NAME …/>`.
  virtual std::vector<std::string> names(PluginKind kind) = 0;

  /// Keys of an engine's block under `<physics>`, and of the one inside an element, see
  /// kOptionElements.
  virtual Result<ParameterTable> world_options(const std::string& backend) = 0;
  virtual Result<ParameterTable> element_options(const std::string& backend,
                                                 std::string_view element) = 0;
};

/// Bounds against hostile files; each has its coded error.
struct Limits {
  std::size_t file_bytes = 16u << 20;  ///< of one scene or imported file
  int depth = 90;                      ///< nested elements in a file; at most 90
  int elements = 500000;               ///< in a file
  int attribute_bytes = 64 << 10;      ///< of one attribute value
  /// After prototypes and repeats; an import counts as a hundred. Ten times what engines simulate
  /// in acceptable time; a file that grows without bound is refused within a second.
  int expanded_elements = 250000;
  int expansion_depth = 64;              ///< instances inside instances
  int files = 256;                       ///< scene and imports
  std::size_t asset_bytes = 256u << 20;  ///< of one mesh, heightmap or texture file
  int diagnostics = 100;                 ///< reported individually; the rest is counted
};

struct CompileOptions {
  /// `<param>`s of the scene by name, as text in the scene's own notation: "4 cm".
  std::map<std::string, std::string> set_parameters;
  /// Replaces the seed of `<physics>`.
  std::optional<std::uint64_t> seed;
  /// Not owned; nullptr: names of plugins go unchecked, parameters of plugins and of engines are
  /// refused (CG0909).
  PluginCatalog* plugins = nullptr;
  /// Folders beside the scene's own, and before the installed library, from which files may be
  /// imported.
  std::vector<std::string> library_folders;
  Limits limits;
};

struct CompileResult {
  SceneModelPtr model;                  ///< nullptr when there is an error
  std::vector<Diagnostic> diagnostics;  ///< errors and warnings, in file order
  /// Absolute paths, sorted, of all files of the scene: itself, imports, meshes, heightmaps,
  /// textures. Of a text, its own path is where it would be.
  std::vector<std::string> files_read;
  bool ok() const { return model != nullptr; }
};

/// Compiles a scene file. A file that cannot be read is a diagnostic too (CG0101).
COGRSIM_API CompileResult compile_file(const std::string& path, const CompileOptions& options = {});

/// Compiles a scene held in memory; `name` stands in diagnostics, and imports are looked up
/// below its folder (the current one for a bare name).
COGRSIM_API CompileResult compile_text(const std::string& text, const std::string& name,
                                       const CompileOptions& options = {});

// ---- diagnostics for people and programs

/// Compiler style, with the source line and a caret. `color`: ANSI escapes, for a terminal.
COGRSIM_API std::string to_text(const std::vector<Diagnostic>& diagnostics, bool color = false);
COGRSIM_API std::string to_text(const Diagnostic& diagnostic, bool color = false);

/// A JSON array; keys severity, code, message, file, line, column, length, notes, help.
COGRSIM_API std::string to_json(const std::vector<Diagnostic>& diagnostics);

/// SARIF 2.1.0, one run.
COGRSIM_API std::string to_sarif(const std::vector<Diagnostic>& diagnostics);

/// What a code means: title, cause, cure and an example; empty for an unknown code.
COGRSIM_API std::string explain(const std::string& code);

/// All codes, sorted.
COGRSIM_API std::vector<std::string> diagnostic_codes();

// ---- generated from the language's own tables

/// XML Schema 1.0 of the scene language. With a catalog, engine blocks get their elements.
COGRSIM_API std::string write_xsd(PluginCatalog* plugins = nullptr);

/// The reference page docs/guide/scene-reference.md.
COGRSIM_API std::string write_reference_markdown();

}  // namespace cogrsim::dsl
