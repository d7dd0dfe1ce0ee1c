// A scene, or one assembly of it, as URDF, SDF or MJCF, with a report of what those cannot say.
#pragma once

#include <string>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"
#include "cogrsim/dsl/import_model.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::dsl {

enum class ExportFormat { urdf, sdf, mjcf };

/// "URDF", "SDF" or "MJCF".
COGRSIM_API const char* format_name(ExportFormat format);

struct ExportResult : FidelityReport {
  std::string text;                 ///< the file
  std::vector<ImportedFile> files;  ///< meshes, to be written beside it
};

struct ExportOptions {
  ExportFormat format = ExportFormat::urdf;
  /// Dotted name of the assembly to write. Empty: the whole scene.
  std::string assembly;
  /// Folder of the meshes, relative to the file that is written.
  std::string mesh_folder = "meshes";
};

/// Writes a model at its state at time 0. Meshes become OBJ files among the result's files. Every
/// element that was selected has an entry in the report; elements of the whole scene (rules, plots,
/// tests, …) have one only if the whole scene is written.
///
/// URDF describes a tree: a joint that closes a loop is left out, and several free bodies become
/// floating links of the link "world". Joints with several axes become chains of joints with links
/// without mass.
///
/// Errors: no such assembly; no bodies to write.
COGRSIM_API Result<ExportResult> export_model(const SceneModel& model,
                                              const ExportOptions& options);

}  // namespace cogrsim::dsl
