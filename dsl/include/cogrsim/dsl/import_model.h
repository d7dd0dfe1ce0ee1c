// Robots and worlds in other formats, as scenes: URDF with xacro and SRDF, MJCF, SDF.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/export.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/dsl/compiler.h"

namespace cogrsim::dsl {

/// What became of an element of the source.
enum class Fidelity {
  exact,        ///< the scene has it with the same meaning, to rounding
  approximate,  ///< the scene has something near; the message states how, and by how much
  left_out      ///< the scene does not have it; the message states why
};

/// "exact", "approximate" or "left out".
COGRSIM_API const char* fidelity_name(Fidelity fidelity);

/// Its file is as the user named it, or relative to the model's folder.
struct ImportEntry : SourcePosition {
  Fidelity fidelity = Fidelity::exact;
  std::string element;  ///< "joint 'elbow'"
  std::string message;  ///< empty where there is nothing to add
  /// Whether it may change how the model moves; false: sensors, looks, what other programs use.
  bool moves = true;
};

/// What became of every element of a conversion.
struct FidelityReport {
  std::vector<ImportEntry> entries;  ///< in the order of the source
  COGRSIM_API std::size_t count(Fidelity fidelity) const;
  /// What changes the motion first, then what is left out, then what is approximate.
  COGRSIM_API std::vector<const ImportEntry*> by_weight() const;
};

/// Motors that an imported joint gets where the source names none.
enum class ImportDrives { none, position, torque, velocity };

struct ImportOptions {
  /// ROS packages by name: the folder of each. Beside these, a package is looked for in the folders
  /// above the model (by package.xml or model.config), in ROS_PACKAGE_PATH and in AMENT_PREFIX_PATH.
  std::map<std::string, std::string> packages;
  /// Arguments of xacro, `<xacro:arg>`.
  std::map<std::string, std::string> arguments;
  ImportDrives drives = ImportDrives::none;
  /// Of an MJCF: the keyframe in which the robot starts, by its name, or by its number counted from 1
  /// where it has none. Empty: it starts at its zero.
  std::string keyframe;
  bool fixed_base = false;  ///< the root link is static
  bool floor = true;        ///< a plane below the model
  /// Folder of the scene, absolute; meshes are referred to relative to it. Empty: that of the model.
  std::string scene_folder;
  /// Folder, relative to `scene_folder`, into which all meshes are copied. Empty: meshes below
  /// `scene_folder` are referred to, others are copied to "meshes".
  std::string copy_meshes;
  /// Meshes are referred to by their path from `scene_folder`, wherever they are, and never copied.
  bool refer = false;
  /// Only the prototype: no instance, floor and `<physics>`, as `<import>` in a scene needs it.
  bool prototype_only = false;
  /// Canonical folders below which all files must lie, those of packages too. Empty: the model's
  /// folder and those of its packages.
  std::vector<std::string> only_below;
  /// An SRDF file beside a URDF; empty: none.
  std::string semantics;
  /// Meshes that move, of URDF and SDF, collide as up to so many convex parts, 1 to 64, written as
  /// files of the result; 0: as their hull, as all of MJCF do.
  int convex_parts = 0;
  /// Called with the name of each mesh before it is decomposed, which may take seconds.
  std::function<void(const std::string&)> decomposing;
  Limits limits;
  /// Not owned: which engines there are. Settings of one that is not there are left out, as a scene
  /// cannot have them. nullptr: all are there.
  PluginCatalog* plugins = nullptr;
  /// Not owned: the work that may still be done for the scene that imports the model. nullptr: the
  /// model has all that a scene may take for itself.
  std::size_t* work = nullptr;
};

/// A file that belongs beside the scene.
struct ImportedFile {
  std::string name;  ///< relative to the scene's folder
  std::string bytes;
};

struct ImportResult : FidelityReport {
  std::string format;                   ///< "URDF", "MJCF" or "SDF"
  std::string scene;                    ///< XML; empty: nothing could be made, see diagnostics
  std::vector<ImportedFile> files;      ///< to be written beside the scene
  std::vector<Diagnostic> diagnostics;  ///< errors of the source, with their position
  std::vector<std::string> files_read;  ///< canonical paths of the model and of all that it names
};

/// Whether a text is of a format that import_model() reads, by its root element.
COGRSIM_API bool is_foreign_model(std::string_view text);

/// Reads a model and writes it as a scene. Reads the file, what it includes, and its meshes, each
/// below the model's folder, its package or a folder of `options.packages`, and nothing else;
/// writes nothing. The format follows from the root element.
COGRSIM_API ImportResult import_model(const std::string& path, const ImportOptions& options = {});

/// Writes the files of a conversion below `folder`: none where one of them cannot be written. A file that
/// has these bytes already stays. Errors: a name leads out of the folder, also by a link; those of
/// write_output_file().
COGRSIM_API Result<> write_beside(const std::string& folder, const std::vector<ImportedFile>& files,
                                  const OutputRules& rules);

}  // namespace cogrsim::dsl
