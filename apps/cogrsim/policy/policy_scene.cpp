#include "policy/policy_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include <fmt/format.h>

#include "cogrsim/core/random.h"
#include "cogrsim/core/shown_text.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/dsl/policy_robot.h"
#include "cogrsim/dsl/study.h"
#include "common/output_file.h"
#include "common/quantities.h"
#include "sweep/sweep_plan.h"

namespace cogrsim::cli {

namespace fs = std::filesystem;

namespace {

constexpr const char* kSensor = "policy_base";

int outermost(const SceneModel& model, int body) {
  int assembly = body < 0 ? -1 : model.bodies[std::size_t(body)].assembly;
  while (assembly >= 0 && model.assemblies[std::size_t(assembly)].parent >= 0)
    assembly = model.assemblies[std::size_t(assembly)].parent;
  return assembly;
}

}  // namespace

Result<double> setting_number(const PolicySettings& settings, const std::string& name,
                              const std::string& unit, double other) {
  const auto found = settings.find(name);
  if (found == settings.end() || found->second == "~") return other;
  const auto values = dsl::parse_study_values(found->second);
  if (values && values->size() == 1 && std::isfinite(values->front().number) &&
      (values->front().unit == unit ||
       // As in a card, where times are seconds.
       (values->front().unit.empty() && (values->front().number == 0 || unit == "s"))))
    return values->front().number;
  return fail(fmt::format("{}={}: that is no {}", one_line(name), one_line(found->second),
                          unit.empty() ? "number" : "quantity in " + unit));
}

std::uint64_t hash_of_policy(const PolicyScene& scene) {
  std::uint64_t hash = hash_of_scene(*scene.model);
  std::vector<std::string> files = scene.files;
  files.insert(files.end(), {scene.card->file, scene.card->network, scene.card->robot});
  for (const std::string& file : files) {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    hash = hash_bytes(text.data(), text.size(), hash);
  }
  return hash;
}

bool is_of_robot(const SceneModel& model, const PolicyRobot& robot, int body) {
  return body >= 0 && outermost(model, body) == outermost(model, robot.base);
}

namespace {

CardChanges card_changes(const PolicySettings& settings) {
  CardChanges out;
  for (const auto& [name, value] : settings) {
    const bool own = std::any_of(std::begin(kPolicySettings), std::end(kPolicySettings),
                                 [&](const PolicySetting& s) { return name == s.name; });
    if (!own)
      out.emplace_back(name, one_line(value));
    else if (name == "delay")
      out.emplace_back("actions.delay", value);
    else if (name == "step" && value == "~")
      out.emplace_back(name, value);
  }
  return out;
}

// The robot's servos as motors that the card's law drives.
void drive_by_law(const PolicyScene& scene, const std::string& when, SceneModel& model,
                  CardChanges& changes) {
  std::string kp, kd;
  bool servos = !scene.robot.motors.empty();
  for (const int index : scene.robot.motors) {
    Motor& motor = model.motors[std::size_t(index)];
    servos = servos && motor.mode == MotorMode::servo;
    kp += fmt::format("{}{}", kp.empty() ? "" : ", ", motor.kp);
    kd += fmt::format("{}{}", kd.empty() ? "" : ", ", motor.kd);
  }
  if (servos) {
    for (const int index : scene.robot.motors) {
      Motor& motor = model.motors[std::size_t(index)];
      motor.mode = MotorMode::torque;
      motor.target.reset();
      motor.min_target = -std::numeric_limits<double>::infinity();
      motor.max_target = std::numeric_limits<double>::infinity();
    }
    changes.emplace_back("actions.kp", "[" + kp + "]");
    changes.emplace_back("actions.kd", "[" + kd + "]");
  }
  changes.emplace_back("actions.law", when);
}

// A factor for all joints, or a value for each of the card's: "[0.01, 0.02]".
Result<> change_joints(const PolicySettings& settings, const std::string& name,
                       const PolicyScene& scene, double JointAxis::*value, SceneModel& model) {
  const auto given = settings.find(name);
  if (given == settings.end()) return {};
  if (given->second.front() != '[') {
    const auto factor = setting_number(settings, name, "", 1.0);
    if (!factor) return tl::unexpected(factor.error());
    if (*factor < 0.0) return fail(fmt::format("{} is below 0", name));
    for (Joint& joint : model.joints)
      for (JointAxis& axis : joint.axes) axis.*value *= *factor;
    return {};
  }
  const auto pieces = split(given->second.substr(1, given->second.rfind(']') - 1), ',');
  if (pieces.size() != scene.robot.joints.size())
    return fail(fmt::format("{} has {} values for {} joints", name, pieces.size(),
                            scene.robot.joints.size()));
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto number = parse_number(pieces[i]);
    if (!number || *number < 0.0)
      return fail(fmt::format("{}: '{}' is no number from 0 on", name, one_line(pieces[i])));
    for (JointAxis& axis : model.joints[std::size_t(scene.robot.joints[i])].axes)
      axis.*value = *number;
  }
  return {};
}

Result<> change_model(const PolicySettings& settings, PolicyScene& scene) {
  auto model = std::make_shared<SceneModel>(*scene.model);
  Error problem;
  const auto number = [&](const char* name, const char* unit, double other) {
    const auto value = setting_number(settings, name, unit, other);
    if (!value) problem = value.error();
    return value.value_or(other);
  };
  const double friction = number("friction", "", 1.0), payload = number("payload", "kg", 0.0),
               effort = number("effort", "", 1.0),
               stiffness = number("contact-stiffness", "N/m", 0.0), step = number("step", "s", 0.0);
  if (!problem.message.empty()) return tl::unexpected(problem);
  for (const auto& [name, value] : {std::pair("friction", friction),
                                    {"payload", payload},
                                    {"effort", effort},
                                    {"contact-stiffness", stiffness},
                                    {"step", step}})
    if (value < 0.0) return fail(fmt::format("{} is below 0", name));
  for (const auto& [name, value] : {std::pair("rotor-inertia", &JointAxis::rotor_inertia),
                                    {"joint-friction", &JointAxis::friction},
                                    {"joint-damping", &JointAxis::damping}})
    if (const auto changed = change_joints(settings, name, scene, value, *model); !changed)
      return changed;
  for (Material& material : model->materials) {
    material.friction *= friction;
    if (stiffness > 0.0) material.stiffness = stiffness;
  }
  for (MaterialPair& pair : model->material_pairs)
    if (pair.friction) pair.friction = *pair.friction * friction;
  model->bodies[std::size_t(scene.robot.base)].mass += payload;
  for (Joint& joint : model->joints)
    for (JointAxis& axis : joint.axes) axis.max_effort *= effort;
  for (Motor& motor : model->motors) motor.max_effort *= effort;
  if (const auto drives = settings.find("drives");
      drives != settings.end() && drives->second != "engine") {
    if (drives->second != "per-step" && drives->second != "per-decision")
      return fail("drives are engine, per-step or per-decision");
    if (scene.card->actions.kind != PolicyActionKind::torque)
      drive_by_law(scene, drives->second, *model, scene.changes);
  }
  scene.model = std::move(model);
  return {};
}

}  // namespace

PolicyScene load_policy(const std::string& path, const std::vector<std::string>& plugin_paths,
                        const PolicySettings& settings) {
  PolicyScene out;
  out.loader = std::make_shared<PluginLoader>(plugin_paths);
  add_input(path);
  out.changes = card_changes(settings);
  out.card = read_policy_card(path, out.found, out.changes);
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
  const dsl::CompileResult compiled =
      dsl::compile_policy_robot(*out.card, catalog, out.found, out.files);
  out.found.insert(out.found.end(), compiled.diagnostics.begin(), compiled.diagnostics.end());
  out.model = compiled.model;
  if (out.model) out.robot = find_policy_robot(*out.card, *out.model, out.found);
  if (out.model && first_error(out.found) == nullptr)
    if (const auto changed = change_model(settings, out); !changed)
      out.found.push_back(to_diagnostic(changed.error()));
  return out;
}

SceneModelPtr load_policy_robot(const PolicyCard& card,
                                const std::vector<std::string>& plugin_paths,
                                std::vector<Diagnostic>& found) {
  dsl::LoaderCatalog catalog(std::make_shared<PluginLoader>(plugin_paths));
  std::vector<Diagnostic> all;
  std::vector<std::string> files;
  const dsl::CompileResult compiled = dsl::compile_policy_robot(card, catalog, all, files);
  all.insert(all.end(), compiled.diagnostics.begin(), compiled.diagnostics.end());
  // Warnings come again when the card is read.
  for (Diagnostic& d : all)
    if (d.severity == Severity::error) found.push_back(std::move(d));
  return compiled.model;
}

Result<SceneModelPtr> with_policy(const PolicyScene& scene, const std::vector<double>& command) {
  auto model = std::make_shared<SceneModel>(*scene.model);
  // The outermost assembly around the base has all motors, or the robot is in several.
  const int assembly = outermost(*model, scene.robot.base);
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
  std::string changes;
  for (const auto& [key, value] : scene.changes) changes += key + "=" + value + "\n";
  controller.parameters = {
      {"card", card}, {"base", std::string(kSensor)}, {"command", command}, {"change", changes}};
  model->controllers.push_back(std::move(controller));
  if (scene.card->step > 0.0) model->physics.step = scene.card->step;
  return SceneModelPtr(std::move(model));
}

}  // namespace cogrsim::cli
