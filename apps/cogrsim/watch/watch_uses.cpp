#include "watch/watch_uses.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "cogrsim/sensing/sensor.h"
#include "common/quantities.h"
#include "watch/watch_files.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;

// NAME.so where it is found; empty: nowhere.
std::string found_plugin(const PluginLoader& loader, const std::string& name) {
  for (const std::string& folder : loader.folders()) {
    const std::string file = full_path(fs::path(folder) / (name + ".so"));
    std::error_code fault;
    if (fs::exists(file, fault)) return file;
  }
  return {};
}

// The same, and where it would be found first if it were there.
void add_plugin(const PluginLoader& loader, const std::string& name, std::set<std::string>& out) {
  const std::string found = found_plugin(loader, name);
  for (const std::string& folder : loader.folders()) {
    const std::string file = full_path(fs::path(folder) / (name + ".so"));
    out.insert(file);
    if (file == found) return;
  }
}

// Text parameters of plugins name files (tables, plans) and other plugins (algorithms); which of
// them do is not known, so that every one that could be a file counts.
void add_parameters(const PluginLoader& loader, const Parameters& parameters,
                    const fs::path& folder, std::set<std::string>& out) {
  constexpr std::size_t kLongest = 255;
  for (const auto& entry : parameters) {
    const auto* text = std::get_if<std::string>(&entry.second);
    if (text == nullptr || text->empty() || text->size() > kLongest) continue;
    if (text->find_first_of("\n\r\t") != std::string::npos) continue;
    if (text->find('.') != std::string::npos) {
      out.insert(full_path(folder / *text));
    } else if (text->find('/') == std::string::npos) {
      const std::string plugin = found_plugin(loader, *text);
      if (!plugin.empty()) out.insert(plugin);
    }
  }
}

// As PluginLoader reads it.
void add_folders_of_variable(std::set<std::string>& out) {
  const char* variable = std::getenv("COGRSIM_PLUGIN_PATH");
  if (variable == nullptr) return;
  for (const std::string& folder : split(variable, ':')) {
    if (!folder.empty()) out.insert(full_path(folder));
  }
}

// Files that the compiler reads or looks for: a new file there would change the scene.
void add_scene_files(const LoadedScene& scene, const std::string& file,
                     std::set<std::string>& out) {
  out.insert(scene.files_read.begin(), scene.files_read.end());
  for (const Diagnostic& missing : scene.diagnostics) {
    // "there is no file \"meshes/hull.stl\"": beside the file that names it, or the scene.
    const std::size_t begin = missing.message.find('"'), end = missing.message.rfind('"');
    if (missing.code != "CG0301" || end == begin) continue;
    const std::string name = missing.message.substr(begin + 1, end - begin - 1);
    for (const std::string& beside : {missing.file, file}) {
      out.insert(full_path(fs::path(beside).parent_path() / name));
    }
  }
}

}  // namespace

std::vector<std::string> used_files(const LoadedScene& scene, const RunOptions& options) {
  std::set<std::string> out = {full_path(options.scene.scene)};
  add_scene_files(scene, options.scene.scene, out);
  if (!options.from.empty()) out.insert(full_path(options.from));
  if (!scene.model) {
    // Perhaps a plugin is missing, or has other parameters than the scene thinks.
    for (const std::string& folder : options.scene.plugin_paths) out.insert(full_path(folder));
    add_folders_of_variable(out);
    return {out.begin(), out.end()};
  }
  const SceneModel& model = *scene.model;
  const fs::path folder = fs::path(options.scene.scene).parent_path();
  const std::string& backend = options.backend.empty() ? model.physics.backend : options.backend;
  if (!backend.empty()) add_plugin(*scene.loader, backend, out);
  for (const auto* controllers : {&model.controllers, &model.supervisors}) {
    for (const ControllerModel& controller : *controllers) {
      add_plugin(*scene.loader, controller.plugin, out);
      add_parameters(*scene.loader, controller.parameters, folder, out);
    }
  }
  for (const SensorModel& sensor : model.sensors) {
    if (built_in_sensor(sensor.type) != nullptr) continue;
    add_plugin(*scene.loader, sensor.type, out);
    add_parameters(*scene.loader, sensor.parameters, folder, out);
  }
  return {out.begin(), out.end()};
}

std::vector<std::string> plugin_files(const PluginLoader& loader, const std::string& name) {
  std::set<std::string> out;
  add_plugin(loader, name, out);
  return {out.begin(), out.end()};
}

}  // namespace cogrsim::cli
