#include "cogrsim/dsl/policy_robot.h"

#include <filesystem>
#include <fstream>
#include <string_view>

#include <fmt/format.h>

#include "cogrsim/core/shown_text.h"
#include "cogrsim/dsl/import_model.h"

namespace cogrsim::dsl {

namespace fs = std::filesystem;

namespace {

bool is_model_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(Limits().file_bytes, '\0');  // beyond it no file is read
  file.read(text.data(), std::streamsize(text.size()));
  return is_foreign_model(std::string_view(text).substr(0, std::size_t(file.gcount())));
}

}  // namespace

CompileResult compile_policy_robot(const PolicyCard& card, PluginCatalog& plugins,
                                   std::vector<Diagnostic>& found,
                                   std::vector<std::string>& files) {
  CompileOptions compile;
  compile.plugins = &plugins;
  if (!is_model_file(card.robot)) return compile_file(card.robot, compile);
  ImportOptions options;
  options.keyframe = card.keyframe;
  options.refer = true;
  options.plugins = &plugins;
  const bool gains = !card.actions.kp.empty() || !card.actions.kd.empty();
  options.drives = gains || card.actions.kind == PolicyActionKind::torque ? ImportDrives::torque
                   : card.actions.kind == PolicyActionKind::velocity      ? ImportDrives::velocity
                                                                          : ImportDrives::position;
  const ImportResult imported = import_model(card.robot, options);
  found.insert(found.end(), imported.diagnostics.begin(), imported.diagnostics.end());
  files = imported.files_read;
  if (imported.scene.empty()) return {};
  if (!imported.files.empty()) {
    found.push_back(policy_finding(
        card, "robot", "CG1505", "some of the robot's meshes must be written beside its scene",
        fmt::format("import it: cogrsim import {} -o robot.scene.xml, and name that scene",
                    one_line(card.robot))));
    return {};
  }
  for (const ImportEntry& entry : imported.entries) {
    if (entry.fidelity != Fidelity::left_out || !entry.moves) continue;
    Diagnostic d =
        policy_finding(card, "robot", "CG1508",
                       fmt::format("the import leaves out {}: {}", entry.element, entry.message),
                       "`cogrsim import` reports all");
    d.severity = Severity::warning;
    found.push_back(std::move(d));
  }
  const std::string name = (fs::path(card.robot).parent_path() / "robot.scene.xml").string();
  return compile_text(imported.scene, name, compile);
}

}  // namespace cogrsim::dsl
