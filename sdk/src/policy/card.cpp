#include "cogrsim/policy/card.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/core/shown_text.h"
#include "model/motor_limits.h"
#include "policy/yaml_text.h"

namespace cogrsim {

namespace fs = std::filesystem;
namespace dim = units::dim;
using policy::YamlText;

namespace {

constexpr const char* kTerms[] = {"base-linear-velocity",
                                  "base-angular-velocity",
                                  "projected-gravity",
                                  "base-height",
                                  "joint-positions",
                                  "joint-velocities",
                                  "last-action",
                                  "command",
                                  "phase",
                                  "constant"};

// What every term has, and what some have besides.
std::vector<std::string> keys_of(PolicyTerm term) {
  std::vector<std::string> out = {"scale",        "mean",  "clip", "history",
                                  "newest-first", "delay", "noise"};
  switch (term) {
    case PolicyTerm::base_linear_velocity:
    case PolicyTerm::base_angular_velocity:
      out.push_back("frame");
      break;
    case PolicyTerm::joint_positions:
      out.push_back("relative");
      break;
    case PolicyTerm::last_action:
      out.push_back("clipped");
      break;
    case PolicyTerm::phase:
      for (const char* key : {"frequency", "fastest-at", "still-below", "offsets", "order"})
        out.emplace_back(key);
      break;
    case PolicyTerm::constant:
      out.push_back("value");
      break;
    default:
      break;
  }
  return out;
}

std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

class Reader {
 public:
  Reader(std::string file, std::string text, const CardChanges& changes)
      : changes_(changes), yaml_(file, text), folder_(fs::path(file).parent_path().string()) {
    card_.file = std::move(file);
    card_.text = std::move(text);
  }

  std::shared_ptr<const PolicyCard> read(std::vector<Diagnostic>& found) {
    try {
      if (yaml_.parse()) {
        for (const auto& [key, value] : changes_) yaml_.change(key, value);
        everything();
      }
    } catch (const YAML::Exception& e) {
      yaml_.error(yaml_.root(), "CG1501", "the file cannot be read: " + one_line(e.msg));
    }
    const bool good = yaml_.found.empty();
    std::string changed;
    for (const auto& [key, value] : changes_)
      changed += fmt::format("{}{}={}", changed.empty() ? "with " : ", ", one_line(key),
                             one_line(value.substr(0, 60)));
    for (Diagnostic& d : yaml_.found)
      if (!changed.empty()) d.message = changed + ": " + d.message;
    found.insert(found.end(), yaml_.found.begin(), yaml_.found.end());
    return good ? std::make_shared<const PolicyCard>(std::move(card_)) : nullptr;
  }

 private:
  void everything() {
    const YAML::Node& root = yaml_.root();
    yaml_.check_keys(root,
                     {"policy", "robot", "keyframe", "base", "network", "input", "output", "state",
                      "rate", "step", "joints", "default-pose", "observations", "observation-clip",
                      "actions", "command", "command-limits", "command-names", "fallen"},
                     "a policy card");
    if (const auto version = yaml_.word(
            yaml_.required(root, "policy", "a card begins with \"policy: 1\", its version"),
            "the version");
        version && *version != "1")
      yaml_.error(root["policy"], "CG1503", "this version of cards is not known",
                  "write \"policy: 1\"");
    card_.robot = path("robot", "the scene or model of the robot: \"robot: robot.scene.xml\"");
    card_.network = path("network", "the file of the network: \"network: policy.onnx\"");
    text("keyframe", card_.keyframe);
    text("input", card_.input);
    text("output", card_.output);
    if (const auto base = yaml_.word(
            yaml_.required(root, "base",
                           "the body or frame whose motion is observed: \"base: trunk\""),
            "base"))
      card_.base = *base;
    place("base", root["base"]);
    if (const auto rate =
            yaml_.quantity(yaml_.required(root, "rate", "decisions per second: \"rate: 50 Hz\""),
                           dim::kFrequency, "rate")) {
      if (*rate > 0.0)
        card_.period = 1.0 / *rate;
      else
        yaml_.error(root["rate"], "CG1503", "rate is above 0");
    }
    place("rate", root["rate"]);
    if (const auto step = yaml_.quantity(root["step"], dim::kTime, "step")) {
      if (*step > 0.0)
        card_.step = *step;
      else
        yaml_.error(root["step"], "CG1503", "step is above 0");
    }
    place("step", root["step"]);
    states();
    joints();
    if (root["actions"].IsDefined())
      actions();
    else
      yaml_.required(root, "actions",
                     "what the network's output means: \"actions: {kind: position, scale: 0.5}\"");
    command();
    observations();
    rest();
  }

  void place(const std::string& key, const YAML::Node& node) {
    if (node.IsDefined()) card_.places[key] = yaml_.at(node);
  }

  void text(const char* key, std::string& to) {
    const YAML::Node node = yaml_.root()[key];
    if (const auto word = yaml_.word(node, key)) to = *word;
    place(key, node);
  }

  // A card may come from somebody else: it names what lies with it, and nothing above.
  std::string path(const char* key, const char* help) {
    const YAML::Node node = yaml_.required(yaml_.root(), key, help);
    const auto name = yaml_.word(node, key);
    if (!name) return {};
    place(key, node);
    std::error_code error;
    const fs::path folder =
        fs::weakly_canonical(folder_.empty() ? fs::path(".") : fs::path(folder_), error);
    const fs::path full = fs::weakly_canonical(folder / *name, error);
    const fs::path inside = full.lexically_relative(folder);
    if (fs::path(*name).is_absolute() || inside.empty() || *inside.begin() == "..") {
      yaml_.error(node, "CG1503",
                  fmt::format("'{}' lies outside of the card's folder", one_line(*name)),
                  "put the card into a folder above all that it names");
      return {};
    }
    if (!fs::is_regular_file(full, error)) {
      yaml_.error(
          node, "CG1503", fmt::format("there is no file '{}'", one_line(*name)),
          fmt::format("paths are relative to the card's folder, {}", one_line(folder.string())));
      return {};
    }
    return (folder_.empty() ? fs::path(*name) : fs::path(folder_) / *name).string();
  }

  void states() {
    const YAML::Node node = yaml_.root()["state"];
    if (!node.IsDefined()) return;
    if (!node.IsMap()) {
      yaml_.error(node, "CG1503", "state is a map of inputs to outputs",
                  "write \"state: {h_in: h_out}\"");
      return;
    }
    for (const auto& entry : node) {
      const auto from = yaml_.word(entry.first, "an input"),
                 to = yaml_.word(entry.second, "an output");
      if (!from || !to) continue;
      card_.state[*from] = *to;
      place("state." + *from, entry.first);
    }
  }

  void joints() {
    const YAML::Node& root = yaml_.root();
    const YAML::Node node =
        yaml_.required(root, "joints", "the joints' names, in the order of the network's output");
    if (const auto names = yaml_.words(node, "joints")) {
      card_.joints = *names;
      for (std::size_t i = 0; i < names->size(); ++i) {
        place(fmt::format("joints.{}", i), node[i]);
        if (std::count(names->begin(), names->begin() + static_cast<std::ptrdiff_t>(i),
                       (*names)[i]) > 0)
          yaml_.error(node[i], "CG1503",
                      fmt::format("joint '{}' stands twice", one_line((*names)[i])));
      }
      if (names->empty()) yaml_.error(node, "CG1503", "joints is empty");
    }
    const YAML::Node pose = yaml_.required(
        root, "default-pose",
        "joint positions that the network calls 0: \"default-pose: 0 0.9 -1.8 rad\"");
    if (const auto values = per_joint(pose, {dim::kAngle, dim::kLength}, "default-pose"))
      card_.pose = *values;
    place("default-pose", pose);
  }

  // One entry for all joints, one for each, or a map by their names.
  std::optional<std::vector<double>> per_joint(const YAML::Node& node,
                                               const std::vector<units::Dimension>& allowed,
                                               const std::string& what) {
    if (!node.IsDefined()) return std::nullopt;
    const std::size_t count = card_.joints.size();
    if (node.IsMap()) {
      std::vector<double> out(count, 0.0);
      yaml_.check_keys(node, card_.joints, what);
      for (std::size_t i = 0; i < count; ++i) {
        const auto value = yaml_.quantities(
            yaml_.required(node, card_.joints[i], "each joint has its entry"), allowed, what);
        if (!value || value->size() != 1) return std::nullopt;
        out[i] = value->front();
      }
      return out;
    }
    auto values = yaml_.quantities(node, allowed, what);
    if (!values) return std::nullopt;
    if (values->size() == 1) values->resize(count, values->front());
    if (values->size() == count) return values;
    if (count > 0)
      yaml_.error(node, "CG1506",
                  fmt::format("{} has {} entries for {} joints", what, values->size(), count),
                  "it has one for all, or one for each");
    return std::nullopt;
  }

  std::optional<std::pair<double, double>> clip(const YAML::Node& node, const std::string& what) {
    const auto values = yaml_.quantities(node, {dim::kNone}, what);
    if (!values) return std::nullopt;
    if (values->size() == 1 && values->front() > 0.0)
      return std::make_pair(-values->front(), values->front());
    if (values->size() == 2 && (*values)[0] < (*values)[1])
      return std::make_pair((*values)[0], (*values)[1]);
    yaml_.error(node, "CG1503",
                what + " is one number above 0, for both sides, or the lower and the upper one");
    return std::nullopt;
  }

  double seconds(const YAML::Node& node, const std::string& what) {
    const auto value = yaml_.quantity(node, dim::kTime, what);
    if (!value) return 0.0;
    if (*value >= 0.0 && *value <= 10.0) return *value;
    yaml_.error(node, "CG1503", what + " is from 0 to 10 s");
    return 0.0;
  }

  void actions() {
    const YAML::Node node = yaml_.root()["actions"];
    PolicyActions& a = card_.actions;
    a.locate(yaml_.at(node));
    place("actions", node);
    if (!node.IsMap()) {
      yaml_.error(node, "CG1503", "actions is a map",
                  "write \"actions: {kind: position, scale: 0.5}\"");
      return;
    }
    yaml_.check_keys(node,
                     {"kind", "scale", "offset", "clip", "kp", "kd", "effort-limit", "stall-effort",
                      "no-load-speed", "delay", "law"},
                     "actions");
    const YAML::Node kind = yaml_.required(node, "kind", "kind: position, velocity or torque");
    if (const auto word = yaml_.word(kind, "kind")) {
      const std::vector<std::string> kinds = {"position", "velocity", "torque"};
      const auto at = std::find(kinds.begin(), kinds.end(), *word);
      if (at == kinds.end())
        yaml_.error(kind, "CG1502", fmt::format("there are no actions '{}'", one_line(*word)),
                    "there are " + listed(kinds));
      else
        a.kind = static_cast<PolicyActionKind>(at - kinds.begin());
    }
    const std::size_t count = card_.joints.size();
    if (const auto scale =
            per_joint(yaml_.required(node, "scale",
                                     "targets per output: \"scale: 0.5\"; 1 where there is none"),
                      {dim::kNone}, "scale"))
      a.scale = *scale;
    const YAML::Node offset = node["offset"];
    const bool named = offset.IsDefined() && offset.IsScalar() &&
                       (offset.Scalar() == "default" || offset.Scalar() == "none");
    if (a.kind == PolicyActionKind::position && !offset.IsDefined())
      yaml_.required(node, "offset",
                     "what is added to positions: \"offset: default\" for the default pose, "
                     "\"none\", or a list");
    a.offset.assign(count, 0.0);
    if (named) {
      if (offset.Scalar() == "default") a.offset = card_.pose;
    } else if (const auto values = per_joint(offset, {dim::kAngle, dim::kLength}, "offset")) {
      a.offset = *values;
    }
    a.clip = clip(node["clip"], "clip");
    place("actions.clip", node["clip"]);
    const bool velocity = a.kind == PolicyActionKind::velocity;
    if (const auto kp =
            per_joint(node["kp"], {dim::kAngularStiffness, dim::kStiffness, dim::kNone}, "kp"))
      a.kp = *kp;
    if (const auto kd =
            per_joint(node["kd"], {dim::kAngularDamping, dim::kDamping, dim::kNone}, "kd"))
      a.kd = *kd;
    place("actions.kp", node["kp"]);
    place("actions.kd", node["kd"]);
    for (const auto* gains : {&a.kp, &a.kd})
      if (std::any_of(gains->begin(), gains->end(), [](double g) { return g < 0.0; }))
        yaml_.error(node[gains == &a.kp ? "kp" : "kd"], "CG1503", "gains are not below 0");
    if (a.kind == PolicyActionKind::torque && (!a.kp.empty() || !a.kd.empty()))
      yaml_.error(node["kp"].IsDefined() ? node["kp"] : node["kd"], "CG1502",
                  "torques need no gains");
    if (a.kind == PolicyActionKind::position && a.kp.empty() != a.kd.empty())
      yaml_.required(
          node, a.kp.empty() ? "kp" : "kd",
          "drives towards positions have kp and kd, or neither: then they are the robot's");
    if (velocity && !a.kp.empty())
      yaml_.error(node["kp"], "CG1502", "drives towards velocities have kd only");
    const auto limit = [&](const char* key, const std::vector<units::Dimension>& dimensions,
                           std::vector<double>& out) {
      if (const auto values = per_joint(node[key], dimensions, key)) {
        out = *values;
        if (std::any_of(out.begin(), out.end(), [](double x) { return !(x > 0.0); }))
          yaml_.error(node[key], "CG1503", fmt::format("{} is above 0", key));
      }
      place(fmt::format("actions.{}", key), node[key]);
    };
    limit("effort-limit", {dim::kTorque, dim::kForce}, a.effort_limit);
    limit("stall-effort", {dim::kTorque, dim::kForce}, a.stall_effort);
    limit("no-load-speed", {dim::kAngularSpeed, dim::kSpeed, dim::kNone}, a.no_load_speed);
    if (a.stall_effort.empty() != a.no_load_speed.empty())
      yaml_.required(node, a.stall_effort.empty() ? "stall-effort" : "no-load-speed",
                     "a curve has both ends: stall-effort and no-load-speed");
    a.delay = seconds(node["delay"], "delay");
    place("actions.law", node["law"]);
    if (const auto law = yaml_.word(node["law"], "law")) {
      a.per_decision = *law == "per-decision";
      if (!a.per_decision && *law != "per-step")
        yaml_.error(node["law"], "CG1503", "law is per-step or per-decision");
      else if (a.per_decision && a.kp.empty() && a.kd.empty())
        yaml_.required(node, "kd", "a law of the card's own has gains");
    }
  }

  void observations() {
    const YAML::Node node = yaml_.required(yaml_.root(), "observations",
                                           "the terms of the network's input, in their order");
    if (!node.IsDefined()) return;
    place("observations", node);
    if (!node.IsSequence() || node.size() == 0) {
      yaml_.error(node, "CG1503", "observations is a list of terms",
                  "there are " + listed({std::begin(kTerms), std::end(kTerms)}));
      return;
    }
    if (node.size() > 200) yaml_.error(node, "CG1503", "there are over 200 terms");
    for (const auto& entry : node) {
      if (card_.observations.size() < 200) observation(entry);
    }
  }

  void observation(const YAML::Node& entry) {
    YAML::Node name = entry, settings;
    if (entry.IsMap() && entry.size() == 1) {
      // reset(), as an assignment would change the tree.
      name.reset(entry.begin()->first);
      settings.reset(entry.begin()->second);
    }
    const auto word = yaml_.word(name, "a term");
    if (!word) return;
    const std::vector<std::string> terms(std::begin(kTerms), std::end(kTerms));
    const auto at = std::find(terms.begin(), terms.end(), *word);
    if (at == terms.end()) {
      const std::string near = nearest_name(*word, terms);
      yaml_.error(
          name, "CG1502", fmt::format("there is no term '{}'", one_line(*word)),
          near.empty() ? "there are " + listed(terms) : fmt::format("did you mean '{}'?", near));
      return;
    }
    PolicyObservation o;
    o.locate(yaml_.at(name));
    o.term = static_cast<PolicyTerm>(at - terms.begin());
    o.commands = card_.command.size();
    const bool has_settings = settings.IsDefined() && !settings.IsNull();
    if (has_settings && !settings.IsMap()) {
      yaml_.error(settings, "CG1503", "settings of a term are a map",
                  fmt::format("write \"- {}: {{scale: 2}}\"", *word));
      return;
    }
    const YAML::Node map = has_settings ? settings : YAML::Node(YAML::NodeType::Map);
    yaml_.check_keys(map, keys_of(o.term), *word);
    own_settings(o, map, name);
    common_settings(o, map);
    card_.observations.push_back(std::move(o));
  }

  void common_settings(PolicyObservation& o, const YAML::Node& map) {
    const std::size_t width = o.width(card_.joints.size());
    o.scale.assign(width, 1.0);
    o.mean.assign(width, 0.0);
    for (const auto& [key, to] : {std::pair{"scale", &o.scale}, {"mean", &o.mean}}) {
      const auto values = yaml_.quantities(map[key], {dim::kNone}, key);
      if (!values) continue;
      if (values->size() == 1)
        to->assign(width, values->front());
      else if (values->size() == width)
        *to = *values;
      else
        yaml_.error(map[key], "CG1506",
                    fmt::format("{} has {} numbers for {} values", key, values->size(), width),
                    "it has one for all, or one for each");
    }
    if (const auto newest = yaml_.truth(map["newest-first"], "newest-first"))
      o.newest_first = *newest;
    o.clip = clip(map["clip"], "clip");
    if (const auto history = yaml_.quantity(map["history"], dim::kNone, "history")) {
      if (*history >= 1.0 && *history <= 1000.0 && *history == static_cast<int>(*history))
        o.history = static_cast<int>(*history);
      else
        yaml_.error(map["history"], "CG1503", "history is a whole number from 1 to 1000");
    }
    o.delay = seconds(map["delay"], "delay");
    const YAML::Node noise = map["noise"];
    if (!noise.IsDefined()) return;
    if (!noise.IsMap()) {
      yaml_.error(noise, "CG1503", "noise is a map",
                  "write \"noise: {uniform: 0.1}\", half its width, or \"noise: {normal: 0.1}\"");
      return;
    }
    yaml_.check_keys(noise, {"uniform", "normal"}, "noise");
    const auto size = [&](const char* key) {
      const auto value = yaml_.quantity(noise[key], dim::kNone, key);
      if (value && *value < 0.0) yaml_.error(noise[key], "CG1503", "noise is not below 0");
      return value.value_or(0.0);
    };
    o.uniform = size("uniform");
    o.normal = size("normal");
  }

  void own_settings(PolicyObservation& o, const YAML::Node& map, const YAML::Node& name) {
    if (const auto frame = yaml_.word(map["frame"], "frame")) {
      o.world = *frame == "world";
      if (*frame != "world" && *frame != "base")
        yaml_.error(map["frame"], "CG1503",
                    "frame is base or world: whose axes the velocity is in");
    } else if (o.term == PolicyTerm::base_linear_velocity ||
               o.term == PolicyTerm::base_angular_velocity) {
      yaml_.error(name, "CG1504",
                  "'frame' is missing: a velocity may be in the axes of the base or of the world",
                  fmt::format("write \"- {}: {{frame: base}}\"", to_string(o.term)));
    }
    if (const auto relative = yaml_.truth(map["relative"], "relative")) o.relative = *relative;
    if (const auto clipped = yaml_.truth(map["clipped"], "clipped"))
      o.clipped = *clipped;
    else if (o.term == PolicyTerm::last_action && card_.actions.clip)
      yaml_.error(name, "CG1504",
                  "'clipped' is missing: actions are clipped, and the last one may be observed "
                  "before or after that",
                  "write \"- last-action: {clipped: true}\" or false");
    if (o.term == PolicyTerm::constant) {
      const auto value = yaml_.quantities(map["value"], {dim::kNone}, "value");
      if (value)
        o.value = *value;
      else if (!map["value"].IsDefined())
        yaml_.error(name, "CG1504", "'value' is missing", "write \"- constant: {value: 0 0}\"");
    }
    if (o.term == PolicyTerm::phase) phase(o, map, name);
  }

  void phase(PolicyObservation& o, const YAML::Node& map, const YAML::Node& name) {
    const auto frequency = yaml_.quantities(map["frequency"], {dim::kFrequency}, "frequency");
    if (!map["frequency"].IsDefined())
      yaml_.error(name, "CG1504", "'frequency' is missing",
                  "write \"- phase: {frequency: 1.25 Hz}\"");
    if (frequency) {
      if (frequency->size() > 2 || *std::min_element(frequency->begin(), frequency->end()) < 0.0)
        yaml_.error(map["frequency"], "CG1503",
                    "frequency is one, or that at rest and that at 'fastest-at'");
      o.lowest = frequency->front();
      o.highest = frequency->back();
      if (frequency->size() == 2 && !map["fastest-at"].IsDefined())
        yaml_.required(map, "fastest-at",
                       "the size of the command at which the second frequency holds");
    }
    if (const auto at = yaml_.quantity(map["fastest-at"], dim::kNone, "fastest-at"))
      o.fastest_at = *at;
    if (const auto still = yaml_.quantity(map["still-below"], dim::kNone, "still-below"))
      o.still = *still;
    if (const auto offsets = yaml_.quantities(map["offsets"], {dim::kNone}, "offsets"))
      o.offsets = *offsets;
    if (const auto order = yaml_.word(map["order"], "order")) {
      if (*order == "cos sin")
        o.cosines_first = true;
      else if (*order != "sin cos")
        yaml_.error(map["order"], "CG1503", "order is \"sin cos\" or \"cos sin\"");
    }
  }

  void command() {
    const YAML::Node node = yaml_.root()["command"];
    card_.command.assign(3, 0.0);
    if (const auto values = yaml_.quantities(node, {dim::kNone}, "command"))
      card_.command = *values;
    place("command", node);
    command_limits(yaml_.root()["command-limits"]);
    command_names(yaml_.root()["command-names"]);
  }

  void command_limits(const YAML::Node& node) {
    if (!node.IsDefined()) return;
    place("command-limits", node);
    constexpr std::size_t kMost = 64;  // inputs of a controller
    const std::size_t count = card_.command.size();
    if (count > kMost)
      return yaml_.error(node, "CG1503",
                         fmt::format("a command of {} numbers cannot be changed in a run: at most "
                                     "{} can",
                                     count, kMost),
                         "leave out command-limits");
    if (!node.IsSequence() || node.size() != count)
      return yaml_.error(
          node, "CG1503",
          fmt::format("command-limits has an entry for each of the {} numbers of the "
                      "command",
                      count),
          "one number for both sides, or two: \"command-limits: [[-0.5, 1], 0.5, 1]\"");
    for (std::size_t i = 0; i < count; ++i) {
      const auto limits = clip(node[i], "an entry of command-limits");
      if (!limits) return;
      if (!(limits->first < limits->second) || card_.command[i] < limits->first ||
          card_.command[i] > limits->second)
        return yaml_.error(
            node[i], "CG1503",
            fmt::format("the command {} is not within {} and {}, or they are no range",
                        card_.command[i], limits->first, limits->second));
      card_.command_limits.push_back(*limits);
    }
  }

  void command_names(const YAML::Node& node) {
    if (!node.IsDefined()) return;
    place("command-names", node);
    constexpr std::size_t kLongest = 100;  // of an input's name and unit
    if (!node.IsMap() || node.size() != card_.command.size())
      return yaml_.error(node, "CG1503",
                         fmt::format("command-names has an entry for each of the {} numbers of the "
                                     "command",
                                     card_.command.size()),
                         "names and units: \"command-names: {forward: m/s, turn: rad/s}\"; ~ for "
                         "no unit");
    std::set<std::string> known;
    for (const auto& entry : node) {
      const auto name = yaml_.word(entry.first, "a name in command-names");
      const auto unit = entry.second.IsNull() ? std::optional<std::string>("")
                                              : yaml_.word(entry.second, "a unit in command-names");
      if (!name || !unit) return;
      for (const std::string& text : {*name, *unit})
        if (text.size() > kLongest || one_line(text) != text)
          return yaml_.error(
              entry.first, "CG1503",
              fmt::format("names and units of commands have at most {} bytes, and no "
                          "control characters",
                          kLongest));
      if (!known.insert(*name).second)
        return yaml_.error(entry.first, "CG1503",
                           "each number of the command has a name of its own");
      card_.command_names.emplace_back(*name, *unit);
    }
  }

  void rest() {
    const YAML::Node& root = yaml_.root();
    card_.clip = clip(root["observation-clip"], "observation-clip");
    const YAML::Node fallen = root["fallen"];
    if (!fallen.IsDefined()) return;
    if (!fallen.IsMap()) {
      yaml_.error(fallen, "CG1503", "fallen is a map",
                  "write \"fallen: {height: 0.2 m, tilt: 60 deg}\"");
      return;
    }
    yaml_.check_keys(fallen, {"height", "tilt"}, "fallen");
    if (const auto height = yaml_.quantity(fallen["height"], dim::kLength, "height"))
      card_.fallen_height = *height;
    if (const auto tilt = yaml_.quantity(fallen["tilt"], dim::kAngle, "tilt"))
      card_.fallen_tilt = *tilt;
  }

  const CardChanges& changes_;
  YamlText yaml_;
  std::string folder_;
  PolicyCard card_;
};

}  // namespace

const char* to_string(PolicyTerm term) { return kTerms[static_cast<std::size_t>(term)]; }

double PolicyActions::limited(std::size_t i, double effort, double speed) const {
  const double most = effort_limit.empty() ? kInfinity : effort_limit[i];
  const EffortLimits left = stall_effort.empty()
                                ? EffortLimits{most, most}
                                : limits_on_curve(stall_effort[i], no_load_speed[i], most, speed);
  return std::clamp(effort, -left.backward, left.forward);
}

std::size_t PolicyObservation::width(std::size_t joints) const {
  switch (term) {
    case PolicyTerm::base_linear_velocity:
    case PolicyTerm::base_angular_velocity:
    case PolicyTerm::projected_gravity:
      return 3;
    case PolicyTerm::base_height:
      return 1;
    case PolicyTerm::joint_positions:
    case PolicyTerm::joint_velocities:
    case PolicyTerm::last_action:
      return joints;
    case PolicyTerm::command:
      return commands;
    case PolicyTerm::phase:
      return 2 * offsets.size();
    case PolicyTerm::constant:
      break;
  }
  return value.size();
}

std::size_t PolicyCard::observed() const {
  std::size_t out = 0;
  for (const PolicyObservation& o : observations)
    out += o.width(joints.size()) * static_cast<std::size_t>(o.history);
  return out;
}

namespace {

std::optional<std::string> text_of(const std::string& path, std::vector<Diagnostic>& found) {
  std::error_code error;
  std::ifstream file;
  if (fs::is_regular_file(path, error)) file.open(path, std::ios::binary);
  Diagnostic d;
  d.file = path;
  d.code = "CG1501";
  if (!file.is_open()) {
    d.message = "there is no such file";
    found.push_back(d);
    return std::nullopt;
  }
  // One byte more than a card may have shows that it has too many.
  std::string text(fs::file_size(path, error) > (1u << 20)
                       ? (1u << 20) + 1
                       : static_cast<std::size_t>(fs::file_size(path, error)),
                   '\0');
  if (!file.read(text.data(), static_cast<std::streamsize>(text.size()))) {
    d.message = "the file cannot be read";
    found.push_back(d);
    return std::nullopt;
  }
  return text;
}

std::string in_one_line(const YAML::Node& node) {
  YAML::Emitter out;
  out.SetMapFormat(YAML::Flow);
  out.SetSeqFormat(YAML::Flow);
  out << node;
  return one_line(out.c_str());
}

void add_values(const std::string& prefix, const YAML::Node& map, CardChanges& out) {
  for (const auto& entry : map)
    out.emplace_back(prefix + entry.first.Scalar(), in_one_line(entry.second));
}

}  // namespace

std::shared_ptr<const PolicyCard> read_policy_card(const std::string& path,
                                                   std::vector<Diagnostic>& found,
                                                   const CardChanges& changes) {
  const auto text = text_of(path, found);
  return text ? Reader(path, *text, changes).read(found) : nullptr;
}

CardChanges policy_card_values(const std::string& path) {
  CardChanges out;
  std::vector<Diagnostic> found;
  const auto text = text_of(path, found);
  if (!text) return out;
  YamlText yaml(path, *text);
  if (!yaml.parse()) return out;
  for (const auto& entry : yaml.root()) {
    const std::string key = entry.first.Scalar();
    if (entry.second.IsMap()) {
      add_values(key + ".", entry.second, out);
    } else if (key == "observations" && entry.second.IsSequence()) {
      std::string names;
      for (const YAML::Node& term : entry.second) {
        const bool map = term.IsMap() && term.size() == 1;
        const std::string name = map ? term.begin()->first.Scalar() : in_one_line(term);
        names += name + " ";
        if (map && term.begin()->second.IsMap())
          add_values("observations." + name + ".", term.begin()->second, out);
      }
      out.emplace_back(key, names);
      out.emplace_back("observations.all", in_one_line(entry.second));
    } else {
      out.emplace_back(key, in_one_line(entry.second));
    }
  }
  return out;
}

Diagnostic policy_finding(const PolicyCard& card, const std::string& place, std::string code,
                          std::string message, std::string help) {
  Diagnostic d;
  d.file = card.file;
  if (const auto at = card.places.find(place); at != card.places.end()) d.locate(at->second);
  d.code = std::move(code);
  d.message = std::move(message);
  d.help = std::move(help);
  policy::add_source_line(d, card.text);
  return d;
}

}  // namespace cogrsim
