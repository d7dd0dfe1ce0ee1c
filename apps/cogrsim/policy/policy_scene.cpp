#include "policy/policy_scene.h"

#include <filesystem>
#include <fstream>
#include <string_view>

#include <fmt/format.h>

#include "cogrsim/core/shown_text.h"
#include "cogrsim/dsl/import_model.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "common/output_file.h"

namespace cogrsim::cli {

namespace fs = std::filesystem;

namespace {

constexpr const char* kSensor = "policy_base";

bool is_model_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(dsl::Limits().file_bytes, '\0');  // beyond it no file is read
  file.read(text.data(), std::streamsize(text.size()));
  return dsl::is_foreign_model(std::string_view(text).substr(0, std::size_t(file.gcount())));
}

// A robot in another format, as a scene in memory that refers to its meshes where they are.
dsl::CompileResult compile_robot(const PolicyCard& card, dsl::LoaderCatalog& catalog,
                                 std::vector<Diagnostic>& found) {
  dsl::CompileOptions compile;
  compile.plugins = &catalog;
  if (!is_model_file(card.robot)) return dsl::compile_file(card.robot, compile);
  dsl::ImportOptions options;
  options.keyframe = card.keyframe;
  options.refer = true;
  options.plugins = &catalog;
  const bool gains = !card.actions.kp.empty() || !card.actions.kd.empty();
  options.drives = gains || card.actions.kind == PolicyActionKind::torque
                       ? dsl::ImportDrives::torque
                   : card.actions.kind == PolicyActionKind::velocity ? dsl::ImportDrives::velocity
                                                                     : dsl::ImportDrives::position;
  const dsl::ImportResult imported = dsl::import_model(card.robot, options);
  found.insert(found.end(), imported.diagnostics.begin(), imported.diagnostics.end());
  if (imported.scene.empty()) return {};
  if (!imported.files.empty()) {
    found.push_back(policy_finding(
        card, "robot", "CG1505", "some of the robot's meshes must be written beside its scene",
        fmt::format("import it: cogrsim import {} -o robot.scene.xml, and name that scene",
                    one_line(card.robot))));
    return {};
  }
  for (const dsl::ImportEntry& entry : imported.entries) {
    if (entry.fidelity != dsl::Fidelity::left_out || !entry.moves) continue;
    Diagnostic d =
        policy_finding(card, "robot", "CG1508",
                       fmt::format("the import leaves out {}: {}", entry.element, entry.message),
                       "`cogrsim import` reports all");
    d.severity = Severity::warning;
    found.push_back(std::move(d));
  }
  const std::string name = (fs::path(card.robot).parent_path() / "robot.scene.xml").string();
  return dsl::compile_text(imported.scene, name, compile);
}

}  // namespace

PolicyScene load_policy(const std::string& path, const std::vector<std::string>& plugin_paths) {
  PolicyScene out;
  out.loader = std::make_shared<PluginLoader>(plugin_paths);
  add_input(path);
  out.card = read_policy_card(path, out.found);
  if (!out.card) return out;
  if (auto network = PolicyNetwork::read(out.card->network)) {
    out.network = *network;
    const auto sizes = check_policy_network(*out.card, *out.network);
    out.found.insert(out.found.end(), sizes.begin(), sizes.end());
  } else {
    const Error& e = network.error();
    out.found.push_back(
        policy_finding(*out.card, "network", e.code, e.where + ": " + e.message, e.hint));
  }
  dsl::LoaderCatalog catalog(out.loader);
  const dsl::CompileResult compiled = compile_robot(*out.card, catalog, out.found);
  out.found.insert(out.found.end(), compiled.diagnostics.begin(), compiled.diagnostics.end());
  out.model = compiled.model;
  if (out.model) out.robot = find_policy_robot(*out.card, *out.model, out.found);
  return out;
}

Result<SceneModelPtr> with_policy(const PolicyScene& scene, const std::vector<double>& command) {
  auto model = std::make_shared<SceneModel>(*scene.model);
  // The outermost assembly around the base has all motors, or the robot is in several.
  int assembly = model->bodies[static_cast<std::size_t>(scene.robot.base)].assembly;
  while (assembly >= 0 && model->assemblies[static_cast<std::size_t>(assembly)].parent >= 0)
    assembly = model->assemblies[static_cast<std::size_t>(assembly)].parent;
  if (assembly < 0)
    return fail("the robot is in no assembly, so no controller can drive it", scene.card->robot,
                "put its bodies, joints and motors into <assembly name=\"robot\">");
  const std::string prefix = model->assemblies[static_cast<std::size_t>(assembly)].name + ".";
  SensorModel sensor;
  sensor.name = prefix + kSensor;
  sensor.type = "pose";
  sensor.body = scene.robot.base;
  sensor.X_BS = scene.robot.X_BF;
  sensor.assembly = assembly;
  model->sensors.push_back(sensor);
  ControllerModel controller;
  controller.name = prefix + "policy";
  controller.plugin = "policy";
  controller.assembly = assembly;
  controller.on_fault = FaultPolicy::end_run;
  const std::string card = fs::absolute(scene.card->file).string();
  model->set_parameters["card"] = card;  // which lets a card outside of the robot's folder be read
  controller.parameters = {{"card", card}, {"base", std::string(kSensor)}, {"command", command}};
  model->controllers.push_back(std::move(controller));
  if (scene.card->step > 0.0) model->physics.step = scene.card->step;
  return SceneModelPtr(std::move(model));
}

}  // namespace cogrsim::cli
