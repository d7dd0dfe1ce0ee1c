// Isaac Lab's IO_descriptors.yaml and env.yaml, and deploy.yaml, which unitree_rl_lab makes of them.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <regex>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "cogrsim/core/shown_text.h"
#include "policy/import_readers.h"

namespace cogrsim::policy {

namespace {

using Numbers = std::vector<double>;

// What an observation function of Isaac Lab is in a card.
struct Known {
  const char *function, *term, *key, *value, *units;
};
constexpr Known kKnown[] = {
    {"base_lin_vel", "base-linear-velocity", "frame", "base", "m/s"},
    {"base_ang_vel", "base-angular-velocity", "frame", "base", "rad/s"},
    {"root_lin_vel_w", "base-linear-velocity", "frame", "world", "m/s"},
    {"root_ang_vel_w", "base-angular-velocity", "frame", "world", "rad/s"},
    {"projected_gravity", "projected-gravity", "", "", "m/s^2"},
    {"base_pos_z", "base-height", "", "", "m"},
    {"joint_pos_rel", "joint-positions", "", "", "rad"},
    {"joint_pos", "joint-positions", "relative", "false", "rad"},
    {"joint_vel_rel", "joint-velocities", "", "", "rad/s"},
    {"joint_vel", "joint-velocities", "", "", "rad/s"},
    {"last_action", "last-action", "", "", ""},
    {"generated_commands", "command", "", "", ""},
    {"velocity_commands", "command", "", "", ""},
    {"gait_phase", "phase", "", "", ""},
};

std::string scalar(const YAML::Node& node) {
  return node.IsDefined() && node.IsScalar() ? node.Scalar() : std::string();
}

bool is_null(const YAML::Node& node) { return !node.IsDefined() || node.IsNull(); }

YAML::Node child(const YAML::Node& node, const std::string& key) {
  return node.IsDefined() && node.IsMap() ? node[key] : YAML::Node(YAML::NodeType::Undefined);
}

class IsaacReader {
 public:
  IsaacReader(YamlText& yaml, YamlText* env, CardDraft& draft)
      : yaml_(yaml), env_(env), draft_(draft) {}

  void descriptors() {
    const YAML::Node root = yaml_.root();
    const YAML::Node terms = yaml_.required(root, "actions", "Isaac Lab lists the actions here");
    if (terms.IsDefined()) actions(terms);
    if (!joints_.empty()) articulation(child(root, "articulations"));
    const YAML::Node groups =
        yaml_.required(root, "observations", "Isaac Lab lists the observations here, by group");
    const YAML::Node group =
        groups.IsDefined() && groups.IsMap()
            ? yaml_.required(groups, "policy", "the group that the policy reads")
            : YAML::Node(YAML::NodeType::Undefined);
    if (group.IsDefined()) {
      if (!group.IsSequence() || group.size() > 200)
        yaml_.error(group, "CG1503", "the group's terms are a list of at most 200");
      else
        for (const auto& term : group) descriptor(term);
    }
    const YAML::Node scene = child(root, "scene");
    times(seconds(child(scene, "dt")), seconds(child(scene, "physics_dt")), root);
    finish(child(root, "articulations"));
  }

  void deploy() {
    const YAML::Node root = yaml_.root();
    const auto map = plain_numbers(yaml_, root["joint_ids_map"], "joint_ids_map");
    const auto stiffness = plain_numbers(yaml_, root["stiffness"], "stiffness"),
               damping =
                   plain_numbers(yaml_, yaml_.required(root, "damping", "the gains kd"), "damping"),
               pose = plain_numbers(yaml_,
                                    yaml_.required(root, "default_joint_pos", "the default pose"),
                                    "default_joint_pos");
    if (!map || !stiffness || !damping || !pose) return;
    const std::size_t count = map->size();
    for (const double i : *map) {
      if (i != std::floor(i) || i < 0 || i >= static_cast<double>(stiffness->size()) ||
          i >= static_cast<double>(damping->size())) {
        yaml_.error(root["joint_ids_map"], "CG1506",
                    fmt::format("joint_ids_map has {}, and the gains have {} entries",
                                number_text(i), stiffness->size()));
        return;
      }
      draft_.sdk_order.push_back(static_cast<int>(i));
    }
    if (!same_size(root["default_joint_pos"], "default_joint_pos", *pose, count)) return;
    draft_.joint_count = count;
    draft_.counted = yaml_.at(root["joint_ids_map"]);
    pose_ = *pose;
    kp_.resize(count);
    kd_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      kp_[i] = (*stiffness)[static_cast<std::size_t>(draft_.sdk_order[i])];
      kd_[i] = (*damping)[static_cast<std::size_t>(draft_.sdk_order[i])];
    }
    names_of_sdk(root["joint_ids_map"]);
    deploy_actions(yaml_.required(root, "actions", "what the network's output means"), count);
    const YAML::Node terms =
        yaml_.required(root, "observations", "the terms of the network's input");
    if (terms.IsDefined()) {
      if (!terms.IsMap() || terms.size() > 200) {
        yaml_.error(terms, "CG1503", "observations is a map of at most 200 terms");
      } else {
        for (const auto& entry : terms)
          term(entry.first, scalar(entry.first), entry.second, entry.second, 0);
      }
    }
    times(seconds(root["step_dt"]), 0.0, root);
    finish(root);
  }

 private:
  bool same_size(const YAML::Node& at, const std::string& what, const Numbers& values,
                 std::size_t count) {
    if (values.size() == count) return true;
    yaml_.error(at, "CG1506",
                fmt::format("{} has {} entries for {} joints", what, values.size(), count));
    return false;
  }

  double seconds(const YAML::Node& node) {
    const auto value =
        is_null(node) ? std::nullopt : yaml_.quantity(node, units::dim::kTime, "a time");
    if (value && !(*value > 0.0)) yaml_.error(node, "CG1503", "a time is above 0");
    return value.value_or(0.0);
  }

  void times(double period, double step, const YAML::Node& at) {
    if (env_) {
      const YAML::Node dt = child(child(env_->root(), "sim"), "dt"),
                       decimation = child(env_->root(), "decimation");
      if (step <= 0.0 && !is_null(dt))
        step = env_->quantity(dt, units::dim::kTime, "dt").value_or(0.0);
      if (period <= 0.0 && step > 0.0 && !is_null(decimation))
        period = step * env_->quantity(decimation, units::dim::kNone, "decimation").value_or(0.0);
    }
    put_times(draft_, period, step);
    if (period <= 0.0)
      ask(draft_, yaml_, at, "rate", "how often the policy decides is not in the file",
          "--set 'rate=50 Hz'");
    if (step <= 0.0)
      ask(draft_, yaml_, at, "step",
          "the step of the physics is not in the file; the env.yaml of the training has it, as "
          "sim.dt",
          "--set 'step=5 ms', or --set step=~ for that of the scene");
  }

  // The last of a path such as isaaclab.envs.mdp.actions.joint_actions.JointPositionAction, or :Name.
  static std::string last_name(const std::string& path) {
    return path.substr(path.find_last_of(".:") + 1);
  }

  void actions(const YAML::Node& terms) {
    if (!terms.IsSequence() || terms.size() == 0 || terms.size() > 50) {
      yaml_.error(terms, "CG1503", "actions is a list of at most 50");
      return;
    }
    Numbers scale, offset, low, high;
    bool clipped = false;
    std::string kind;
    for (const auto& term : terms) {
      if (!term.IsMap()) {
        yaml_.error(term, "CG1503", "an action is a map");
        return;
      }
      const YAML::Node path = yaml_.required(term, "full_path", "the class of the action");
      if (!path.IsDefined()) return;
      const std::string type = last_name(scalar(path));
      const std::string its = kind_of(type);
      if (its.empty() || (!kind.empty() && its != kind)) {
        refuse(draft_, yaml_, path,
               its.empty() ? fmt::format("actions of the class '{}' have no meaning in a card",
                                         one_line(type))
                           : fmt::format("actions are {}s here, and {}s before", its, kind),
               "a card has actions of JointPositionAction, JointVelocityAction or "
               "JointEffortAction, one "
               "kind for all joints");
        return;
      }
      kind = its;
      const YAML::Node names =
          yaml_.required(term, "joint_names", "the joints, in the order of the output");
      const auto joints = yaml_.words(names, "joint_names");
      if (!joints) return;
      joints_.insert(joints_.end(), joints->begin(), joints->end());
      if (joints_.size() > 1000) {
        yaml_.error(names, "CG1503", "there are over 1000 joints");
        return;
      }
      if (!per_joint(term["scale"], "scale", joints->size(), 1.0, scale)) return;
      if (!per_joint(term["offset"], "offset", joints->size(), 0.0, offset)) return;
      if (!limits(term["clip"], joints->size(), low, high, clipped)) return;
    }
    joints_at_ = yaml_.at(terms[0]["joint_names"]);
    draft_.top.set("joints", names_text(joints_));
    put_actions(terms, kind, scale, offset, low, high, clipped);
  }

  static std::string kind_of(const std::string& type) {
    return type == "JointPositionAction"   ? "position"
           : type == "JointVelocityAction" ? "velocity"
           : type == "JointEffortAction"   ? "torque"
                                           : "";
  }

  bool per_joint(const YAML::Node& node, const std::string& what, std::size_t count, double other,
                 Numbers& out) {
    Numbers values(1, other);
    if (!is_null(node)) {
      const auto read = plain_numbers(yaml_, node, what);
      if (!read) return false;
      values = *read;
    }
    if (values.size() == 1) values.resize(count, values.front());
    if (!same_size(node.IsDefined() ? node : yaml_.root(), what, values, count)) return false;
    out.insert(out.end(), values.begin(), values.end());
    return true;
  }

  // Isaac Lab clips the target of each joint: a list of [lowest, highest].
  bool limits(const YAML::Node& node, std::size_t count, Numbers& low, Numbers& high, bool& any) {
    const std::size_t before = low.size();
    low.resize(before + count, -HUGE_VAL);
    high.resize(before + count, HUGE_VAL);
    if (is_null(node)) return true;
    if (!node.IsSequence() || node.size() != count) {
      yaml_.error(node, "CG1503", fmt::format("clip is a list of {} pairs", count));
      return false;
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (!node[i].IsSequence() || node[i].size() != 2) {
        yaml_.error(node[i], "CG1503", "a clip is a pair of numbers");
        return false;
      }
      for (std::size_t k = 0; k < 2; ++k) {
        const std::string word = scalar(node[i][k]);
        if (word == ".inf" || word == "-.inf" || word == "inf" || word == "-inf") continue;
        const auto value = yaml_.quantity(node[i][k], units::dim::kNone, "clip");
        if (!value) return false;
        (k == 0 ? low : high)[before + i] = *value;
        any = true;
      }
    }
    return true;
  }

  void put_actions(const YAML::Node& at, const std::string& kind, const Numbers& scale,
                   const Numbers& offset, const Numbers& low, const Numbers& high, bool clipped) {
    draft_.actions.set("kind", kind);
    draft_.actions.set("scale", value_text(scale));
    offset_ = offset;
    kind_ = kind;
    if (!clipped) return;
    // A card clips the output instead: (limit - offset) / scale, the same for all joints.
    double least = -HUGE_VAL, most = HUGE_VAL;
    bool same = true;
    for (std::size_t i = 0; i < scale.size(); ++i) {
      double a = (low[i] - offset[i]) / scale[i], b = (high[i] - offset[i]) / scale[i];
      if (scale[i] < 0.0) std::swap(a, b);
      same = same && std::isfinite(a) && std::isfinite(b) &&
             (i == 0 || (std::fabs(a - least) < 1e-6 * (1 + std::fabs(a)) &&
                         std::fabs(b - most) < 1e-6 * (1 + std::fabs(b))));
      if (i == 0) {
        least = a;
        most = b;
      }
    }
    clip_ = true;
    if (same)
      draft_.actions.set("clip", list_text({least, most}));
    else
      refuse(draft_, yaml_, at, "each joint's target is clipped to limits of its own",
             "a card clips the network's output, alike for all: --set 'actions.clip=LOW HIGH', or "
             "--set actions.clip=~ if the limits are never reached",
             "actions.clip");
  }

  void deploy_actions(const YAML::Node& terms, std::size_t count) {
    if (!terms.IsDefined()) return;
    if (!terms.IsMap() || terms.size() != 1) {
      refuse(draft_, yaml_, terms, fmt::format("there are {} actions", terms.size()),
             "a card has one kind of actions, for all joints");
      return;
    }
    const YAML::Node name = terms.begin()->first, term = terms.begin()->second;
    const std::string kind = kind_of(scalar(name));
    if (kind.empty()) {
      refuse(draft_, yaml_, name,
             fmt::format("actions of the class '{}' have no meaning in a card",
                         one_line(scalar(name))),
             "there are JointPositionAction, JointVelocityAction and JointEffortAction");
      return;
    }
    all_joints(child(term, "joint_ids"), count, "the actions are");
    Numbers scale, offset, low, high;
    bool clipped = false;
    if (!per_joint(child(term, "scale"), "scale", count, 1.0, scale) ||
        !per_joint(child(term, "offset"), "offset", count, 0.0, offset) ||
        !limits(child(term, "clip"), count, low, high, clipped))
      return;
    put_actions(terms, kind, scale, offset, low, high, clipped);
  }

  // "joint_ids" of actions and of terms: all in the order of the articulation (null, [null], a slice, 0 to n - 1).
  void all_joints(const YAML::Node& ids, std::size_t count, const std::string& what) {
    if (is_null(ids) || !ids.IsSequence() || ids.size() == 0 || ids[0].IsNull() ||
        scalar(ids[0]) == "null")
      return;
    bool all = ids.size() == count;
    for (std::size_t i = 0; all && i < count; ++i) all = scalar(ids[i]) == std::to_string(i);
    if (!all)
      refuse(draft_, yaml_, ids, what + " of some of the joints only, or in another order",
             "a card has one list of joints, for actions and observations");
  }

  // deploy.yaml numbers the joints by the maker's SDK, whose names are in the env.yaml of the training.
  void names_of_sdk(const YAML::Node& at) {
    const YAML::Node names =
        env_ ? child(child(child(env_->root(), "scene"), "robot"), "joint_sdk_names")
             : YAML::Node(YAML::NodeType::Undefined);
    if (!is_null(names)) {
      // A motor that is not there has an empty name.
      const std::size_t all = names.IsSequence() ? names.size() : 0;
      for (const int i : draft_.sdk_order) {
        const auto number = static_cast<std::size_t>(i);
        const std::string name = number < all ? scalar(names[number]) : std::string();
        if (name.empty()) {
          env_->error(names, "CG1506",
                      fmt::format("joint_sdk_names has no name of joint {}, which deploy.yaml has "
                                  "(it has {} entries)",
                                  i, all));
          return;
        }
        joints_.push_back(name);
      }
      draft_.top.set("joints", names_text(joints_));
      return;
    }
    ask(draft_, yaml_, at, "joints",
        "the file has the joints' numbers in the maker's SDK, not their names; the env.yaml of the "
        "training "
        "has them, as scene.robot.joint_sdk_names",
        "--set 'joints=[NAME, …]' in the order of the output");
  }

  void articulation(const YAML::Node& all) {
    if (is_null(all) || !all.IsMap()) {
      ask(draft_, yaml_, yaml_.root(), "default-pose", "the file has no articulations",
          "--set 'default-pose=… rad'");
      return;
    }
    for (const auto& entry : all) {
      const YAML::Node names = child(entry.second, "joint_names");
      if (is_null(names)) continue;
      const auto joints = yaml_.words(names, "joint_names");
      if (!joints) return;
      std::vector<std::size_t> places;
      for (const std::string& joint : joints_) {
        const auto at = std::find(joints->begin(), joints->end(), joint);
        if (at != joints->end()) places.push_back(static_cast<std::size_t>(at - joints->begin()));
      }
      if (places.size() != joints_.size()) continue;
      const auto read = [&](const char* key, Numbers& out) {
        const YAML::Node node = child(entry.second, key);
        if (is_null(node)) return;
        const auto values = plain_numbers(yaml_, node, key);
        if (!values || !same_size(node, key, *values, joints->size())) return;
        for (const std::size_t i : places) out.push_back((*values)[i]);
      };
      read("default_joint_pos", pose_);
      read("default_joint_stiffness", kp_);
      read("default_joint_damping", kd_);
      Numbers speeds;
      read("default_joint_vel", speeds);
      if (std::any_of(speeds.begin(), speeds.end(), [](double v) { return v != 0.0; }))
        refuse(draft_, yaml_, child(entry.second, "default_joint_vel"),
               "the default velocities are not 0", "a card's joint-velocities are as they are");
      articulation_.reset(entry.first);
      return;
    }
    yaml_.error(all, "CG1506", "no articulation has all joints of the actions");
  }

  void descriptor(const YAML::Node& node) {
    if (!node.IsMap()) {
      yaml_.error(node, "CG1503", "a term is a map");
      return;
    }
    const YAML::Node path = yaml_.required(node, "full_path", "the function of the term");
    if (!path.IsDefined()) return;
    const YAML::Node overloads = child(node, "overloads"), extras = child(node, "extras");
    std::size_t width = 0;
    if (const YAML::Node shape = child(node, "shape"); !is_null(shape)) {
      if (const auto sizes = plain_numbers(yaml_, shape, "shape")) {
        double product = 1.0;
        for (const double s : *sizes) product *= s;
        if (!(product >= 1.0 && product <= 1e6)) {
          yaml_.error(shape, "CG1503", "a shape has from 1 to 1000000 values");
          return;
        }
        width = static_cast<std::size_t>(product);
      }
    }
    const std::string function = last_name(scalar(path));
    for (const YAML::Node& modifiers : {child(extras, "modifiers"), child(overloads, "modifiers")})
      if (!is_null(modifiers) && modifiers.size() > 0)
        refuse(draft_, yaml_, modifiers, "a term has modifiers",
               "what they do is not in a card: export the policy with them inside");
    const YAML::Node flat = child(overloads, "flatten_history_dim");
    if (scalar(flat) == "false" && scalar(child(overloads, "history_length")) > "0")
      refuse(draft_, yaml_, flat, "the history is a dimension of its own",
             "a card's observations are one list of numbers");
    if (const YAML::Node names = child(node, "joint_names"); !is_null(names)) {
      const auto joints = yaml_.words(names, "joint_names");
      if (!joints) return;
      if (*joints != joints_ && std::string(function).compare(0, 5, "joint") == 0)
        refuse(draft_, yaml_, names,
               fmt::format("'{}' has other joints than the actions, or another order",
                           one_line(function)),
               "a card has one list of joints, for actions and observations");
    }
    for (const Known& known : kKnown) {
      const std::string units = scalar(child(extras, "units"));
      if (function == known.function && !units.empty() && units != known.units && *known.units &&
          std::string(known.term) != "projected-gravity")
        refuse(draft_, yaml_, child(extras, "units"),
               fmt::format("'{}' is in {}, and in a card in {}", function, one_line(units),
                           known.units),
               "a card's observations are in SI units");
    }
    term(path, function, node, overloads, width);
  }

  static bool out_of_joints(const std::string& term) { return term.compare(0, 5, "joint") == 0; }

  // Numbers of an angle, with the unit that a card wants.
  static std::string with_unit(const Numbers& values) {
    std::string out;
    for (const double v : values) out += (out.empty() ? "[" : ", ") + number_text(v) + " rad";
    return out + "]";
  }

  void term(const YAML::Node& at, const std::string& function, const YAML::Node& node,
            const YAML::Node& settings, std::size_t width) {
    const auto known = std::find_if(std::begin(kKnown), std::end(kKnown),
                                    [&](const Known& k) { return function == k.function; });
    if (known == std::end(kKnown)) {
      std::vector<std::string> names;
      std::string all;
      for (const Known& k : kKnown) {
        names.emplace_back(k.function);
        all += std::string(all.empty() ? "" : ", ") + k.function;
      }
      const std::string near = nearest_name(function, names);
      refuse(draft_, yaml_, at, fmt::format("a card has no observation '{}'", one_line(function)),
             near.empty() ? "it has " + all : fmt::format("did you mean '{}'?", near),
             "observations");
      return;
    }
    const YAML::Node asset = child(child(node, "params"), "asset_cfg");
    if (out_of_joints(known->term))
      all_joints(child(asset, "joint_ids"), std::max(joints_.size(), draft_.joint_count),
                 fmt::format("'{}' is", one_line(function)));
    DraftTerm out;
    out.name = known->term;
    out.width = width;
    if (*known->key) out.settings.set(known->key, known->value);
    if (out.name == "last-action" && clip_) out.settings.set("clipped", "false");
    if (out.name == "phase") {
      const YAML::Node period = child(child(node, "params"), "period");
      const double length = seconds(period);
      if (length > 0.0)
        out.settings.set("frequency", fmt::format("{:.9g} Hz", 1.0 / length));
      else
        ask(draft_, yaml_, at, "observations.phase.frequency",
            "the period of the gait is not in the file",
            "--set 'observations.phase.frequency=1.25 Hz'");
    }
    if (out.name == "command" && width > 0) commands_ = width;
    if (out.name == "base-linear-velocity")
      draft_.comments.push_back(
          "base-linear-velocity: Isaac Lab's is that of the base's centre of mass, the card's that "
          "of its "
          "origin.");
    if (const YAML::Node clip = child(settings, "clip"); !is_null(clip)) {
      const auto values = plain_numbers(yaml_, clip, "clip");
      if (values && values->size() == 2)
        out.settings.set("clip", list_text(*values));
      else if (values)
        yaml_.error(clip, "CG1503", "clip has two numbers");
    }
    if (const YAML::Node scale = child(settings, "scale"); !is_null(scale)) {
      const auto values = plain_numbers(yaml_, scale, "scale");
      if (!values) return;
      if (const std::string text = value_text(*values); text != "1")
        out.settings.set("scale", text);
    }
    if (const YAML::Node history = child(settings, "history_length"); !is_null(history)) {
      const auto length = yaml_.quantity(history, units::dim::kNone, "history_length");
      if (length && *length > 1.0) out.settings.set("history", number_text(*length));
    }
    draft_.observations.push_back(std::move(out));
  }

  // Pose, gains and what the training alone knows.
  void finish(const YAML::Node& at) {
    const YAML::Node place = at.IsDefined() ? at : yaml_.root();
    const std::size_t count = std::max(joints_.size(), draft_.joint_count);
    if (pose_.size() == count && count > 0)
      draft_.top.set("default-pose", numbers_text(pose_, true) + " rad");
    if (!offset_.empty()) {
      const bool is_pose = offset_ == pose_;
      const bool zero =
          std::all_of(offset_.begin(), offset_.end(), [](double v) { return v == 0.0; });
      if (kind_ == "position" || !zero)
        draft_.actions.set("offset", is_pose && kind_ == "position" ? "default"
                                     : zero                         ? "none"
                                                                    : with_unit(offset_));
    }
    gains(place, count);
    fallen(place);
    if (commands_ > 0 && commands_ != 3) {
      std::vector<double> zeros(commands_, 0.0);
      draft_.top.set("command", numbers_text(zeros, false));
    }
    const YAML::Node spawn =
        env_ ? child(child(child(env_->root(), "scene"), "robot"), "spawn") : YAML::Node();
    std::string asset = scalar(child(spawn, "asset_path"));
    if (asset.empty()) asset = scalar(child(spawn, "usd_path"));
    ask(draft_, yaml_, place, "robot",
        asset.empty() ? "no file of the robot is named"
                      : fmt::format("the training had '{}'", one_line(asset.substr(0, 200))),
        "--robot FILE: its URDF, MJCF or scene");
    ask(draft_, yaml_, place, "network", "no network is named",
        "--network FILE: the exported ONNX file");
    ask(draft_, yaml_, articulation_.IsDefined() && !articulation_.IsNull() ? articulation_ : place,
        "base", "the body whose motion is observed is not named; it is the articulation's root",
        "--base NAME");
  }

  void gains(const YAML::Node& at, std::size_t count) {
    if (kind_ == "torque" || kind_.empty() || count == 0) return;
    Numbers effort(count, 0.0);
    stall_.assign(count, 0.0);
    no_load_.assign(count, 0.0);
    kp_.resize(count, 0.0);
    kd_.resize(count, 0.0);
    if (env_)
      for (std::size_t i = 0; i < joints_.size(); ++i) actuator(i, kp_[i], kd_[i], effort[i]);
    std::size_t limp = 0, limited = 0, curves = 0;
    for (std::size_t i = 0; i < count; ++i) {
      limp += kp_[i] == 0.0 && kd_[i] == 0.0 ? 1u : 0u;
      limited += effort[i] > 0.0 ? 1u : 0u;
      curves += stall_[i] > 0.0 && no_load_[i] > 0.0 ? 1u : 0u;
    }
    if (limp == count) {
      const std::string why =
          "the gains in the file are 0: the joints were driven by a model of actuators of their "
          "own; the "
          "env.yaml of the training may have its gains";
      if (kind_ == "position")
        ask(draft_, yaml_, at, "actions.kp", why,
            "--set actions.kp=80 or a list per joint; ~ for the robot's own servos");
      ask(draft_, yaml_, at, "actions.kd", why, "--set actions.kd=2 or a list; ~ likewise");
    } else if (limp > 0) {
      const std::string why =
          fmt::format("{} of {} joints have no gains in the files", limp, count);
      if (kind_ == "position")
        ask(draft_, yaml_, at, "actions.kp", why, "--set 'actions.kp=[…]', one for each joint");
      ask(draft_, yaml_, at, "actions.kd", why, "--set 'actions.kd=[…]', one for each joint");
    } else {
      if (kind_ == "position") draft_.actions.set("kp", value_text(kp_));
      draft_.actions.set("kd", value_text(kd_));
    }
    if (curves == count) {
      draft_.actions.set("stall-effort", value_text(stall_));
      draft_.actions.set("no-load-speed", value_text(no_load_));
    } else if (falling_ > 0) {
      draft_.comments.push_back(
          fmt::format("effort-limit: {} of {} joints have a DCMotor, whose limit falls with its "
                      "speed, and {} say "
                      "how far; in a card all do, or none.",
                      falling_, count, curves));
    }
    if (limited == count)
      draft_.actions.set("effort-limit", value_text(effort));
    else if (limited > 0)
      ask(draft_, yaml_, at, "actions.effort-limit",
          fmt::format("{} of {} joints have a limit of effort in the files", limited, count),
          "--set 'actions.effort-limit=[…]', one for each joint; ~ for the robot's own");
  }

  // A Python regular expression that names whole joints. It may be hostile: libstdc++'s polynomial matcher
  // needs time in proportion to the pattern's states times the name, and a stack as deep as they are many. Counts in
  // braces, which make many states of a short pattern, name no joint; the tries are bounded.
  bool matches(const YAML::Node& node, const std::string& name) {
    if (!node.IsDefined() || !node.IsScalar() || ++tries_ > kMostTries) {
      if (tries_ == kMostTries + 1)
        env_->error(env_->root(), "CG1503", "the actuators have too many patterns");
      return false;
    }
    const std::string& pattern = node.Scalar();
    if (pattern == name) return true;
    if (pattern.empty() || pattern.size() > 100 || name.size() > 200 ||
        pattern.find('{') != std::string::npos)
      return false;
    try {
      return std::regex_match(
          name, std::regex(pattern, std::regex::ECMAScript | std::regex_constants::__polynomial));
    } catch (const std::regex_error&) {
      return false;
    }
  }

  // A value of an actuator: one for all, or by patterns of names.
  double value_of(const YAML::Node& node, const std::string& joint) {
    if (is_null(node)) return 0.0;
    if (!node.IsMap()) return env_->quantity(node, units::dim::kNone, "a gain").value_or(0.0);
    for (const auto& entry : node)
      if (tries_ <= kMostTries && matches(entry.first, joint))
        return env_->quantity(entry.second, units::dim::kNone, "a gain").value_or(0.0);
    return 0.0;
  }

  void actuator(std::size_t index, double& kp, double& kd, double& effort) {
    const std::string& joint = joints_[index];
    const YAML::Node all = child(child(child(env_->root(), "scene"), "robot"), "actuators");
    if (is_null(all) || !all.IsMap() || all.size() > 200) return;
    for (const auto& entry : all) {
      const YAML::Node names = child(entry.second, "joint_names_expr");
      if (tries_ > kMostTries) return;
      bool its = matches(names, joint);
      if (names.IsDefined() && names.IsSequence() && names.size() <= 1000)
        for (const auto& name : names) {
          if (its || tries_ > kMostTries) break;
          its = matches(name, joint);
        }
      if (!its) continue;
      if (kp == 0.0 && kd == 0.0) {
        kp = value_of(child(entry.second, "stiffness"), joint);
        kd = value_of(child(entry.second, "damping"), joint);
      }
      effort = value_of(child(entry.second, "effort_limit"), joint);
      if (effort == 0.0) effort = value_of(child(entry.second, "effort_limit_sim"), joint);
      if (last_name(scalar(child(entry.second, "class_type"))) == "DCMotor") {
        stall_[index] = value_of(child(entry.second, "saturation_effort"), joint);
        no_load_[index] = value_of(child(entry.second, "velocity_limit"), joint);
        ++falling_;
      }
      const std::string name = scalar(entry.first);
      if (std::find(seen_.begin(), seen_.end(), name) != seen_.end()) return;
      seen_.push_back(name);
      about_actuator(entry.second, last_name(scalar(child(entry.second, "class_type"))));
      return;
    }
  }

  void about_actuator(const YAML::Node& node, const std::string& type) {
    const YAML::Node at = child(node, "class_type");
    if (type.compare(0, 11, "ActuatorNet") == 0)
      refuse(draft_, *env_, at,
             fmt::format("the actuators were networks ({}), which a card does not have",
                         one_line(type)),
             "give gains that come near: --set actions.kp=…", "actions.kp");
    if (type == "RemotizedPDActuator")
      draft_.comments.push_back(
          "effort-limit: of a RemotizedPDActuator; the card has no such table.");
    const YAML::Node delay = child(node, "max_delay");
    if (!is_null(delay) && scalar(delay) != "0")
      ask(draft_, *env_, delay, "actions.delay",
          fmt::format("actions were delayed by {} to {} steps of the physics, drawn per episode",
                      one_line(scalar(child(node, "min_delay"))), one_line(scalar(delay))),
          "--set 'actions.delay=10 ms'");
  }

  // Of the terminations, those that a card has.
  void fallen(const YAML::Node& at) {
    const YAML::Node all = env_ ? child(env_->root(), "terminations") : YAML::Node();
    std::string out;
    if (!is_null(all) && all.IsMap() && all.size() <= 200) {
      for (const auto& entry : all) {
        const std::string function = last_name(scalar(child(entry.second, "func")));
        const YAML::Node parameters = child(entry.second, "params");
        if (function == "root_height_below_minimum") {
          if (const auto h = env_->quantity(child(parameters, "minimum_height"),
                                            units::dim::kLength, "height"))
            out += fmt::format("{}height: {} m", out.empty() ? "" : ", ", number_text(*h));
        } else if (function == "bad_orientation") {
          if (const auto a =
                  env_->quantity(child(parameters, "limit_angle"), units::dim::kNone, "angle"))
            out += fmt::format("{}tilt: {} rad", out.empty() ? "" : ", ", number_text(*a));
        }
      }
    }
    if (!out.empty())
      draft_.top.set("fallen", "{" + out + "}");
    else
      ask(draft_, yaml_, at, "fallen", "when the robot counts as fallen is not in the files",
          "--set 'fallen={height: 0.3 m, tilt: 60 deg}', or --set fallen=~ for a tilt of 1 rad");
  }

  YamlText& yaml_;
  YamlText* env_;
  CardDraft& draft_;
  std::vector<std::string> joints_, seen_;
  SourcePosition joints_at_;
  Numbers pose_, kp_, kd_, offset_, stall_, no_load_;
  std::size_t falling_ = 0;  // joints with a DCMotor
  std::string kind_;
  std::size_t commands_ = 0;
  static constexpr int kMostTries = 20000;
  int tries_ = 0;
  bool clip_ = false;
  YAML::Node articulation_;
};

}  // namespace

void read_isaac_descriptors(YamlText& descriptors, YamlText* env, CardDraft& draft) {
  draft.comments.emplace_back("From Isaac Lab's IO descriptors.");
  IsaacReader(descriptors, env, draft).descriptors();
}

void read_unitree_deploy(YamlText& deploy, YamlText* env, CardDraft& draft) {
  draft.comments.emplace_back("From deploy.yaml of unitree_rl_lab.");
  IsaacReader(deploy, env, draft).deploy();
}

}  // namespace cogrsim::policy
