// The YAML files of unitree_rl_gym: deploy_mujoco/configs and deploy_real/configs. Order, phase and drive
// law are those of the scripts that read them, deploy_mujoco.py and deploy_real.py.
#include <filesystem>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "cogrsim/core/shown_text.h"
#include "policy/import_readers.h"

namespace cogrsim::policy {

namespace fs = std::filesystem;

namespace {

using Numbers = std::vector<double>;

class GymReader {
 public:
  GymReader(YamlText& yaml, const std::string& path, CardDraft& draft)
      : yaml_(yaml), path_(path), draft_(draft) {}

  void read() {
    const YAML::Node root = yaml_.root();
    const bool real = root["control_dt"].IsDefined();
    draft_.comments.push_back(
        fmt::format("From {} of unitree_rl_gym; order and phase are those of {}.",
                    one_line(fs::path(path_).filename().string()),
                    real ? "deploy_real.py" : "deploy_mujoco.py"));
    const auto count =
        yaml_.quantity(yaml_.required(root, "num_actions", "how many joints there are"),
                       units::dim::kNone, "num_actions");
    if (!count) return;
    if (!(*count >= 1.0 && *count <= 1000.0) || *count != static_cast<int>(*count)) {
      yaml_.error(root["num_actions"], "CG1503", "num_actions is a whole number from 1 to 1000");
      return;
    }
    count_ = static_cast<std::size_t>(*count);
    draft_.joint_count = count_;
    draft_.counted = yaml_.at(root["num_actions"]);
    times(root, real);
    const auto pose = per_joint("default_angles", "default-pose");
    if (pose) draft_.top.set("default-pose", numbers_text(*pose, true) + " rad");
    observations();
    draft_.actions.set("kind", "position");
    if (const auto scale = numbers("action_scale", "actions.scale"))
      draft_.actions.set("scale", value_text(*scale));
    draft_.actions.set("offset", "default");
    for (const auto& [key, name] : {std::pair{"kps", "kp"}, {"kds", "kd"}})
      if (const auto gains = per_joint(key, std::string("actions.") + name))
        draft_.actions.set(name, value_text(*gains));
    if (const YAML::Node command = root["cmd_init"]; command.IsDefined())
      if (const auto values = plain_numbers(yaml_, command, "cmd_init"))
        draft_.top.set("command", numbers_text(*values, false));
    files(root);
    for (const char* key : {"arm_waist_joints2motor_idx", "arm_waist_target"})
      if (const YAML::Node held = root[key]; held.IsDefined() && held.size() > 0) {
        draft_.comments.push_back(
            "deploy_real.py holds arms and waist at arm_waist_target: a card drives its joints alone.");
        ask(draft_, yaml_, held, "robot",
            "arms and waist are held at targets of their own, which a card does not do",
            "--robot FILE: a robot whose file holds these joints, such as g1_12dof, without them");
        break;
      }
    if (real) {
      ask(draft_, yaml_,
          root["leg_joint2motor_idx"].IsDefined() ? root["leg_joint2motor_idx"] : root, "joints",
          "the file has the numbers of motors, not the names of their joints",
          "--set 'joints=[NAME, …]' in the order of the output");
      const YAML::Node imu = root["imu_type"];
      ask(draft_, yaml_, imu.IsDefined() ? imu : root, "base",
          "the policy observes the pelvis, also where the robot measures at its torso",
          "--base NAME");
    } else {
      draft_.joints_of_robot = true;
      draft_.base_of_robot = true;
    }
    ask(draft_, yaml_, root, "fallen", "when the robot counts as fallen is not in the file",
        "--set 'fallen={height: 0.4 m, tilt: 60 deg}', or --set fallen=~ for a tilt of 1 rad");
  }

 private:
  // Asked for where the file does not have it, with the nearest of its keys.
  std::optional<Numbers> numbers(const std::string& key, const std::string& card_key) {
    const YAML::Node node = yaml_.root()[key];
    if (node.IsDefined()) return plain_numbers(yaml_, node, key);
    std::vector<std::string> keys;
    for (const auto& entry : yaml_.root())
      if (entry.first.IsScalar() && keys.size() < 1000) keys.push_back(entry.first.Scalar());
    const std::string near = nearest_name(key, keys);
    ask(draft_, yaml_, near.empty() ? yaml_.root() : key_node(near), card_key,
        near.empty()
            ? fmt::format("the file has no '{}'", key)
            : fmt::format("the file has no '{}'; did you mean it with '{}'?", key, one_line(near)),
        fmt::format("--set '{}=…', or correct the file", card_key));
    return std::nullopt;
  }

  YAML::Node key_node(const std::string& key) {
    for (const auto& entry : yaml_.root())
      if (entry.first.IsScalar() && entry.first.Scalar() == key) return entry.first;
    return yaml_.root();
  }

  std::optional<Numbers> per_joint(const std::string& key, const std::string& card_key) {
    auto values = numbers(key, card_key);
    if (!values || values->size() == count_) return values;
    yaml_.error(yaml_.root()[key], "CG1506",
                fmt::format("{} has {} entries for {} joints", key, values->size(), count_),
                "num_actions is the number of joints");
    return std::nullopt;
  }

  void times(const YAML::Node& root, bool real) {
    double step = 0.0, period = 0.0;
    const auto positive = [&](const char* key) {
      const auto value = yaml_.quantity(root[key], units::dim::kNone, key);
      if (value && !(*value > 0.0))
        yaml_.error(root[key], "CG1503", fmt::format("{} is above 0", key));
      return value.value_or(0.0);
    };
    if (real) {
      period = positive("control_dt");
    } else {
      step = positive("simulation_dt");
      period = step * positive("control_decimation");
    }
    put_times(draft_, period, step);
    if (period <= 0.0)
      ask(draft_, yaml_, root, "rate",
          "how often the policy decides is control_decimation times simulation_dt, and one is "
          "missing",
          "--set 'rate=50 Hz'");
    if (step <= 0.0)
      ask(draft_, yaml_, root, "step", "the step of the physics is not in the file",
          "--set 'step=2 ms', or --set step=~ for that of the scene");
  }

  void term(const std::string& name, std::size_t width, const std::string& scale_key,
            const DraftMap& settings = {}) {
    DraftTerm out{name, settings, width};
    if (!scale_key.empty()) {
      if (const auto scale = numbers(scale_key, "observations." + name + ".scale")) {
        if (scale->size() != 1 && scale->size() != width)
          yaml_.error(
              yaml_.root()[scale_key], "CG1506",
              fmt::format("{} has {} numbers for {} values", scale_key, scale->size(), width));
        if (const std::string text = value_text(*scale); text != "1")
          out.settings.set("scale", text);
      }
    }
    draft_.observations.push_back(std::move(out));
  }

  void observations() {
    DraftMap base, phase;
    base.set("frame", "base");
    phase.set("frequency", "1.25 Hz");  // the scripts have its period, 0.8 s
    term("base-angular-velocity", 3, "ang_vel_scale", base);
    term("projected-gravity", 3, "");
    term("command", 3, "cmd_scale");
    term("joint-positions", count_, "dof_pos_scale");
    term("joint-velocities", count_, "dof_vel_scale");
    term("last-action", count_, "");
    term("phase", 2, "", phase);
    const YAML::Node node = yaml_.root()["num_obs"];
    const auto given = yaml_.quantity(node, units::dim::kNone, "num_obs");
    std::size_t sum = 0;
    for (const DraftTerm& each : draft_.observations) sum += each.width;
    if (given && *given != static_cast<double>(sum))
      yaml_.error(
          node, "CG1506",
          fmt::format("num_obs is {}, and the terms of the script have {}", number_text(*given),
                      sum),
          fmt::format(
              "base-angular-velocity 3 + projected-gravity 3 + command 3 + joint-positions {0} "
              "+ joint-velocities {0} + last-action {0} + phase 2",
              count_));
  }

  // "{LEGGED_GYM_ROOT_DIR}/resources/…" is below one of the folders above this file.
  std::string found(const YAML::Node& node) {
    static constexpr const char* kRoot = "{LEGGED_GYM_ROOT_DIR}/";
    if (!node.IsDefined() || !node.IsScalar()) return {};
    std::string name = node.Scalar();
    std::error_code error;
    if (name.compare(0, std::string(kRoot).size(), kRoot) != 0)
      return fs::is_regular_file(name, error) ? name : std::string();
    name = name.substr(std::string(kRoot).size());
    if (name.find("..") != std::string::npos) return {};
    fs::path folder = fs::absolute(path_, error).parent_path();
    for (int i = 0; i < 8; ++i, folder = folder.parent_path())
      if (fs::is_regular_file(folder / name, error))
        return (folder / name).lexically_normal().string();
    return {};
  }

  void files(const YAML::Node& root) {
    const YAML::Node robot = root["xml_path"], network = root["policy_path"];
    if (const std::string file = found(robot); !file.empty())
      draft_.top.set("robot", name_text(file));
    else
      ask(draft_, yaml_, robot.IsDefined() ? robot : root, "robot",
          robot.IsDefined() ? "that file is not there" : "no file of the robot is named",
          "--robot FILE: its MJCF, or the scene that was imported from it");
    const YAML::Node at = network.IsDefined() ? network : root;
    const std::string name = network.IsDefined() && network.IsScalar() ? network.Scalar() : "",
                      file = found(network);
    if (fs::path(name).extension() == ".onnx" && !file.empty()) {
      draft_.top.set("network", name_text(file));
      return;
    }
    std::string beside;
    std::error_code error;
    if (!file.empty())
      if (const fs::path onnx = fs::path(file).replace_extension(".onnx");
          fs::is_regular_file(onnx, error))
        beside = fmt::format("; there is '{}'", one_line(onnx.string()));
    const bool torch = fs::path(name).extension() == ".pt" || fs::path(name).extension() == ".pth";
    ask(draft_, yaml_, at, "network",
        torch ? "that network is TorchScript, and cards have ONNX: export it once, with its state "
                "as inputs "
                "and outputs if it has an LSTM (docs/guide/policies.md, Networks)" +
                    beside
              : "no ONNX file is named" + beside,
        "--network FILE");
  }

  YamlText& yaml_;
  std::string path_;
  CardDraft& draft_;
  std::size_t count_ = 0;
};

}  // namespace

void read_unitree_gym(YamlText& config, const std::string& path, CardDraft& draft) {
  GymReader(config, path, draft).read();
}

}  // namespace cogrsim::policy
