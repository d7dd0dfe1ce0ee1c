// Cards from what other tools write: files in their formats, of a robot of our own.
#include "cogrsim/policy/import.h"

#include <catch2/catch.hpp>

#include <fstream>
#include <sstream>

#include "cogrsim/dsl/compiler.h"
#include "policy_support.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::Contains;

namespace {

constexpr const char* kGym = R"(# ours
policy_path: "{LEGGED_GYM_ROOT_DIR}/net17.onnx"
xml_path: "{LEGGED_GYM_ROOT_DIR}/arm.scene.xml"
simulation_duration: 60.0
simulation_dt: 0.002
control_decimation: 10
kps: [40, 30]
kds: [2, 2]
default_angles: [0.1, -0.2]
ang_vel_scale: 0.25
dof_pos_scale: 1.0
dof_vel_scale: 0.05
action_scale: 0.25
cmd_scale: [2.0, 2.0, 0.25]
num_actions: 2
num_obs: 17
cmd_init: [0.5, 0, 0]
)";

constexpr const char* kGymCard =
    R"(# From arm.yaml of unitree_rl_gym; order and phase are those of deploy_mujoco.py.
policy: 1
robot: arm.scene.xml
base: trunk
network: net17.onnx
rate: 50 Hz
step: 2 ms
joints: [elbow, wrist]
default-pose: 0.1 -0.2 rad
observations:
  - base-angular-velocity: {frame: base, scale: 0.25}
  - projected-gravity
  - command: {scale: [2, 2, 0.25]}
  - joint-positions
  - joint-velocities: {scale: 0.05}
  - last-action
  - phase: {frequency: 1.25 Hz}
actions:
  kind: position
  scale: 0.25
  offset: default
  kp: [40, 30]
  kd: 2
command: 0.5 0 0
)";

constexpr const char* kIsaac = R"(actions:
- action_type: JointAction
  clip:
  - [-1.0, 1.5]
  - [-1.3, 1.2]
  dtype: torch.float32
  full_path: isaaclab.envs.mdp.actions.joint_actions.JointPositionAction
  joint_names: [wrist, elbow]
  mdp_type: Action
  name: joint_position_action
  offset: [-0.20000000298023224, 0.10000000149011612]
  scale: [[0.5, 0.5], [0.5, 0.5]]
  shape: [2]
articulations:
  robot:
    default_joint_damping: [0.0, 0.0]
    default_joint_pos: [0.10000000149011612, -0.20000000298023224]
    default_joint_stiffness: [0.0, 0.0]
    default_joint_vel: [0.0, 0.0]
    joint_names: [elbow, wrist]
observations:
  policy:
  - extras: {modifiers: null, units: m/s}
    full_path: isaaclab.envs.mdp.observations.base_lin_vel
    overloads: {clip: null, flatten_history_dim: true, history_length: 0, scale: 2.0}
    shape: [3]
  - extras: {units: m/s^2}
    full_path: isaaclab.envs.mdp.observations.projected_gravity
    overloads: {clip: [-1.0, 1.0], history_length: 3, scale: null}
    shape: [3]
  - full_path: isaaclab.envs.mdp.observations.joint_pos_rel
    joint_names: [wrist, elbow]
    overloads: {scale: [1.0, 1.0]}
    shape: [2]
  - full_path: isaaclab.envs.mdp.observations.last_action
    overloads: {}
    shape: [2]
scene:
  decimation: 4
  dt: 0.02
  physics_dt: 0.005
)";

// As Python's YAML writes the configuration of a training: tags, anchors, actuators by patterns.
constexpr const char* kEnvironment = R"(sim:
  dt: 0.005
  gravity: !!python/tuple [0.0, 0.0, -9.81]
decimation: 4
scene:
  num_envs: 4096
  robot:
    prim_path: &path /World/envs/env_.*/Robot
    spawn:
      usd_path: http://example/arm.usd
    joint_sdk_names: [wrist, unused, elbow]
    actuators:
      upper:
        class_type: isaaclab.actuators.actuator_pd:DCMotor
        joint_names_expr: [elb.*]
        effort_limit: 20.0
        saturation_effort: 25.0
        velocity_limit: {.*: 8.0}
        stiffness: {.*bow: 40.0}
        damping: 2.0
      lower:
        class_type: isaaclab.actuators.actuator_pd:ImplicitActuator
        joint_names_expr: [".*st"]
        effort_limit: null
        effort_limit_sim: 15.0
        stiffness: 30.0
        damping: 1.0
  other: *path
terminations:
  time_out:
    func: isaaclab.envs.mdp.terminations:time_out
  tilted:
    func: isaaclab.envs.mdp.terminations:bad_orientation
    params: {limit_angle: 0.8}
)";

constexpr const char* kIsaacCard = R"(# From Isaac Lab's IO descriptors.
# base-linear-velocity: Isaac Lab's is that of the base's centre of mass, the card's that of its origin.
# effort-limit: 1 of 2 joints have a DCMotor, whose limit falls with its speed, and 1 say how far; in a card all do, or none.
policy: 1
robot: arm.scene.xml
base: trunk
network: net16.onnx
rate: 50 Hz
step: 5 ms
joints: [wrist, elbow]
default-pose: -0.2 0.1 rad
observations:
  - base-linear-velocity: {frame: base, scale: 2}
  - projected-gravity: {clip: [-1, 1], history: 3}
  - joint-positions
  - last-action: {clipped: false}
actions:
  kind: position
  scale: 0.5
  offset: default
  clip: -1.6 2.8
  kp: [30, 40]
  kd: [1, 2]
  effort-limit: [15, 20]
fallen: {tilt: 0.8 rad}
)";

constexpr const char* kDeploy = R"(joint_ids_map: [2, 0]
step_dt: 0.02
stiffness: [30.0, 0.0, 40.0]
damping: [1.0, 0.0, 2.0]
default_joint_pos: [0.1, -0.2]
commands: {}
actions:
  JointPositionAction:
    clip: null
    joint_names: [.*]
    scale: [0.25, 0.25]
    offset: [0.1, -0.2]
    joint_ids: !!python/object/apply:builtins.slice [null, null, null]
observations:
  base_ang_vel: {params: {}, clip: null, scale: [0.2, 0.2, 0.2], history_length: 2}
  velocity_commands: {params: {command_name: base_velocity}, clip: null, scale: [1.0, 1.0, 1.0], history_length: 1}
  gait_phase: {params: {period: 0.8}, clip: null, scale: [1.0, 1.0], history_length: 1}
  joint_vel_rel: {params: {}, clip: [-100.0, 100.0], scale: [0.05, 0.05], history_length: 1}
)";

constexpr const char* kDeployCard = R"(# From deploy.yaml of unitree_rl_lab.
# effort-limit: 1 of 2 joints have a DCMotor, whose limit falls with its speed, and 1 say how far; in a card all do, or none.
policy: 1
robot: arm.scene.xml
base: trunk
network: net13.onnx
rate: 50 Hz
step: 5 ms
joints: [elbow, wrist]
default-pose: 0.1 -0.2 rad
observations:
  - base-angular-velocity: {frame: base, scale: 0.2, history: 2}
  - command
  - phase: {frequency: 1.25 Hz}
  - joint-velocities: {clip: [-100, 100], scale: 0.05}
actions:
  kind: position
  scale: 0.25
  offset: default
  kp: [40, 30]
  kd: [2, 1]
  effort-limit: [20, 15]
fallen: {tilt: 0.8 rad}
)";

constexpr const char* kScript = R"py('''A policy of ours.'''
import numpy as np

class OnnxController:
  def __init__(self, policy_path, default_angles, n_substeps, action_scale=0.5):
    self._phase = np.array([0.0, np.pi])
    self._phase_dt = 2 * np.pi * ctrl_dt

  def get_obs(self, model, data) -> np.ndarray:
    linvel = data.sensor("local_linvel").data
    imu_xmat = data.site_xmat[model.site("trunk").id].reshape(3, 3)
    gravity = imu_xmat.T @ np.array([0, 0, -1])  # downwards
    joint_angles = data.qpos[7:] - self._default_angles
    command = self._joystick.get_command()
    ph = self._phase if np.linalg.norm(command) >= 0.01 else np.ones(2) * np.pi
    phase = np.concatenate([np.cos(ph), np.sin(ph)])
    joint_angles[:1] *= 0.0
    obs = np.hstack([
        linvel,
        gravity,
        command,
        joint_angles,
        data.qvel[6:],
        self._last_action,
        phase,
    ])
    return obs.astype(np.float32)

  def get_control(self, model, data):
      obs = self.get_obs(model, data)
      self._last_action = onnx_pred.copy()
      data.ctrl[:] = onnx_pred * self._action_scale + self._default_angles
      command = self._joystick.get_command()
      if cmd_magnitude < 0.01:
        gait_freq = 1.25
      else:
        gait_freq = 1.25 + 0.5 * min(cmd_magnitude, 1.5) / 1.5

def load_callback(model=None, data=None):
  model = mujoco.MjModel.from_xml_path(
      arm_constants.FLAT_XML.as_posix(),
      assets=get_assets(),
  )
  ctrl_dt = 0.02
  sim_dt = 0.004
  policy = OnnxController(
      policy_path=(_ONNX_DIR / "net19.onnx").as_posix(),
      default_angles=np.array(model.keyframe("home").qpos[7:]),
      n_substeps=n_substeps,
      action_scale=0.5,
      vel_scale_x=1.5,
      vel_scale_y=0.8,
      vel_scale_rot=2 * np.pi,
  )
)py";

constexpr const char* kScriptCard = R"(# From play_arm.py of MuJoCo Playground.
policy: 1
robot: servo.scene.xml
base: trunk
network: onnx/net19.onnx
rate: 50 Hz
step: 4 ms
joints: [elbow, wrist]
default-pose: 0.3 0 rad
observations:
  - base-linear-velocity: {frame: base}
  - projected-gravity
  - command
  - joint-positions: {scale: [0, 1]}
  - joint-velocities
  - last-action
  - phase: {frequency: [1.25 Hz, 1.75 Hz], fastest-at: 1.5, still-below: 0.01, offsets: [0, 0.5],
      order: cos sin}
actions:
  kind: position
  scale: 0.5
  offset: default
command-limits: [1.5, 0.8, 6.283185307179586]
command-names: {forward: m/s, left: m/s, turn: rad/s}
)";

// A network of so many inputs and two outputs.
std::string network_of(int inputs) {
  OnnxWriter writer;
  writer.input("obs", {1, inputs})
      .output("actions", {1, 2})
      .constant("w", {2, inputs}, std::vector<float>(static_cast<std::size_t>(2 * inputs), 0.01f));
  return writer.node("Gemm", {"obs", "w"}, {"actions"}, {{"transB", 1}}).bytes();
}

struct Imported {
  std::string card;
  std::vector<Diagnostic> found;
};

Imported import_of(const PolicyFolder& folder, const std::vector<std::string>& files,
                   const CardChanges& answers) {
  Imported out;
  std::vector<std::string> paths;
  for (const std::string& file : files) paths.push_back(folder.path(file));
  const auto sources = PolicySources::read(paths, out.found);
  if (!sources) return out;
  CardChanges all = answers;
  for (auto& [key, value] : all)
    if (key == "robot" || key == "network") value = '"' + folder.path(value) + '"';
  sources->answer(all, out.found);
  if (first_error(out.found)) return out;
  SceneModelPtr model;
  if (!sources->robot().empty()) model = dsl::compile_file(sources->robot()).model;
  std::shared_ptr<const PolicyNetwork> network;
  if (!sources->network().empty())
    if (auto read = PolicyNetwork::read(sources->network())) network = *read;
  out.card = sources->card(folder.path(""), model.get(), network.get(), out.found);
  return out;
}

// What `cogrsim policy check` finds.
std::vector<Diagnostic> checked(const PolicyFolder& folder, const std::string& card) {
  std::vector<Diagnostic> found;
  folder.write("new.policy.yaml", card);
  const auto read = read_policy_card(folder.path("new.policy.yaml"), found);
  if (!read) return found;
  const auto network = PolicyNetwork::read(read->network);
  REQUIRE(network);
  const auto sizes = check_policy_network(*read, **network);
  found.insert(found.end(), sizes.begin(), sizes.end());
  find_policy_robot(*read, *dsl::compile_file(read->robot).model, found);
  return found;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

// The finding about a key of the card, or with a code.
const Diagnostic& about(const std::vector<Diagnostic>& found, const std::string& what) {
  for (const Diagnostic& d : found)
    if (d.message.find("'" + what + "'") == 0 || d.code == what) return d;
  FAIL(what << " is not among\n" << dsl::to_text(found));
  return found.front();
}

}  // namespace

TEST_CASE("the configuration of a script of unitree_rl_gym becomes a card", "[import]") {
  const PolicyFolder folder;
  // As in a checkout: what the variable names is a folder above.
  std::filesystem::create_directories(folder.path("deploy/configs"));
  folder.write("deploy/configs/arm.yaml", kGym);
  folder.write("net17.onnx", network_of(17));
  const Imported out = import_of(folder, {"deploy/configs/arm.yaml"}, {{"fallen", "~"}});
  INFO(dsl::to_text(out.found));
  CHECK(out.card == kGymCard);
  const auto found = checked(folder, out.card);
  INFO(dsl::to_text(found));
  CHECK(found.empty());
}

TEST_CASE("the curves of Isaac Lab's DC motors become those of the card", "[import]") {
  const PolicyFolder folder;
  folder.write("io.yaml", kIsaac);
  folder.write(
      "env.yaml",
      replaced(
          kEnvironment, "actuator_pd:ImplicitActuator",
          "actuator_pd:DCMotor\n        saturation_effort: 18.0\n        velocity_limit: 9.0"));
  folder.write("net16.onnx", network_of(16));
  const Imported out = import_of(folder, {"io.yaml", "env.yaml"},
                                 {{"robot", "arm.scene.xml"},
                                  {"network", "net16.onnx"},
                                  {"base", "trunk"},
                                  {"actions.clip", "-1.6 2.8"}});
  INFO(dsl::to_text(out.found));
  CHECK_THAT(out.card, Contains("  stall-effort: [18, 25]\n  no-load-speed: [9, 8]\n"));
  CHECK_THAT(out.card, !Contains("DCMotor"));
  CHECK(checked(folder, out.card).empty());
}

TEST_CASE("Isaac Lab's descriptors become a card", "[import]") {
  const PolicyFolder folder;
  folder.write("io.yaml", kIsaac);
  folder.write("env.yaml", kEnvironment);
  folder.write("net16.onnx", network_of(16));
  const CardChanges answers = {
      {"robot", "arm.scene.xml"}, {"network", "net16.onnx"}, {"base", "trunk"}};
  const Imported out = import_of(folder, {"io.yaml", "env.yaml"},
                                 {{"robot", "arm.scene.xml"},
                                  {"network", "net16.onnx"},
                                  {"base", "trunk"},
                                  {"actions.clip", "-1.6 2.8"}});
  INFO(dsl::to_text(out.found));
  CHECK(out.card == kIsaacCard);
  // Alike limits of the output are those of the targets less the offset, by the scale: no question.
  folder.write("io.yaml", replaced(kIsaac, "[-1.3, 1.2]", "[-0.7, 1.5]"));
  const Imported same = import_of(folder, {"io.yaml", "env.yaml"}, answers);
  INFO(dsl::to_text(same.found));
  CHECK_THAT(about(same.found, "CG1515").help, Contains("actions.clip"));
  folder.write("io.yaml", replaced(replaced(kIsaac, "[-1.0, 1.5]", "[-1.2, 0.8]"), "[-1.3, 1.2]",
                                   "[-0.9, 1.1]"));
  const Imported good = import_of(folder, {"io.yaml", "env.yaml"}, answers);
  INFO(dsl::to_text(good.found));
  CHECK_THAT(good.card, Contains("last-action: {clipped: false}"));
  CHECK(checked(folder, good.card).empty());
}

TEST_CASE("deploy.yaml of unitree_rl_lab becomes a card, with names of env.yaml", "[import]") {
  const PolicyFolder folder;
  folder.write("deploy.yaml", kDeploy);
  folder.write("env.yaml", replaced(kEnvironment, "[wrist, unused, elbow]", "[wrist, '', elbow]"));
  folder.write("net13.onnx", network_of(13));
  const CardChanges answers = {
      {"robot", "arm.scene.xml"}, {"network", "net13.onnx"}, {"base", "trunk"}};
  folder.write("env.yaml", kEnvironment);
  const Imported out = import_of(folder, {"deploy.yaml", "env.yaml"}, answers);
  INFO(dsl::to_text(out.found));
  CHECK(out.card == kDeployCard);
  const auto found = checked(folder, out.card);
  INFO(dsl::to_text(found));
  CHECK(found.empty());
  // Without names the numbers are not taken for an order: asked for, with what the robot has.
  const Imported open = import_of(folder, {"deploy.yaml"}, answers);
  CHECK(open.card.empty());
  const Diagnostic& joints = about(open.found, "joints");
  CHECK(joints.code == "CG1514");
  CHECK(joints.line == 1);
  CHECK_THAT(joints.help, Contains("elbow, wrist"));
  CHECK(about(open.found, "step").code == "CG1514");
}

TEST_CASE("a script of MuJoCo Playground becomes a card", "[import]") {
  const PolicyFolder folder;
  std::filesystem::create_directory(folder.path("onnx"));
  folder.write("play_arm.py", kScript);
  folder.write("onnx/net19.onnx", network_of(19));
  std::string scene = kRobot;
  for (int i = 0; i < 2; ++i) {
    scene = replaced(scene, "<motor", "<servo");
    scene = replaced(scene, "mode=\"torque\"", "kp=\"40 N*m/rad\" kd=\"1 N*m*s/rad\"");
  }
  scene = replaced(scene, "axis=\"0 1 0\"", "axis=\"0 1 0\" position=\"0.3 rad\"");
  folder.write("servo.scene.xml", scene);
  const Imported out =
      import_of(folder, {"play_arm.py"}, {{"robot", "servo.scene.xml"}, {"fallen", "~"}});
  INFO(dsl::to_text(out.found));
  CHECK(out.card == kScriptCard);
}

TEST_CASE("what a script does otherwise is refused at its line", "[import][bad]") {
  const PolicyFolder folder;
  const struct {
    const char *from, *to;
    int line;
  } cases[] = {
      {"linvel = data.sensor(\"local_linvel\").data",
       "linvel = data.sensor(\"accelerometer\").data", 10},
      {"np.array([0, 0, -1])", "np.array([0, 0, 1])", 12},
      {"joint_angles[:1] *= 0.0", "joint_angles[:1] *= 0.5", 17},
      {"joint_angles[:1] *= 0.0", "joint_angles += 1", 17},
      {"        data.qvel[6:],", "        data.qvel[7:],", 23},
      {"data.ctrl[:] = onnx_pred", "data.ctrl[:] += onnx_pred", 32},
  };
  for (const auto& c : cases) {
    folder.write("play_arm.py", replaced(kScript, c.from, c.to));
    const Imported out =
        import_of(folder, {"play_arm.py"},
                  {{"robot", "arm.scene.xml"}, {"network", "net.onnx"}, {"fallen", "~"}});
    INFO(c.to << "\n" << dsl::to_text(out.found));
    CHECK(out.card.empty());
    const Diagnostic& d = about(out.found, "CG1515");
    CHECK(d.line == c.line);
    CHECK(d.column > 0);
  }
}

TEST_CASE("what a source leaves open is asked for, all at once", "[import][bad]") {
  const PolicyFolder folder;
  folder.write("io.yaml", kIsaac);
  const Imported out = import_of(folder, {"io.yaml"}, {});
  CHECK(out.card.empty());
  for (const char* key : {"robot", "network", "base", "fallen", "actions.kp", "actions.kd"}) {
    const Diagnostic& d = about(out.found, key);
    CHECK(d.code == "CG1514");
    CHECK(d.line > 0);
    CHECK_FALSE(d.source_line.empty());
    CHECK_FALSE(d.help.empty());
  }
  const Imported with = import_of(folder, {"io.yaml"}, {{"robot", "arm.scene.xml"}});
  CHECK_THAT(about(with.found, "base").help, Contains("root is 'trunk'"));
  // TorchScript is not a network that is there.
  folder.write("arm.yaml", replaced(kGym, "net17.onnx", "motion.pt"));
  folder.write("motion.pt", "PK");
  const Imported torch = import_of(folder, {"arm.yaml"}, {{"fallen", "~"}});
  CHECK_THAT(about(torch.found, "network").message, Contains("TorchScript"));
  CHECK(about(torch.found, "network").line == 2);
  // A misspelt key is not 1, but open, with the key that was meant.
  folder.write("arm.yaml", replaced(kGym, "dof_vel_scale", "dof_vell_scale"));
  folder.write("net17.onnx", network_of(17));
  const Imported typo = import_of(folder, {"arm.yaml"}, {{"fallen", "~"}});
  const Diagnostic& scale = about(typo.found, "observations.joint-velocities.scale");
  CHECK_THAT(scale.message, Contains("dof_vell_scale"));
  CHECK(scale.line == 12);
  const Imported answered = import_of(
      folder, {"arm.yaml"}, {{"fallen", "~"}, {"observations.joint-velocities.scale", "0.05"}});
  CHECK(answered.card == kGymCard);
}

TEST_CASE("wrong values of sources are reported at line and column", "[import][bad]") {
  const PolicyFolder folder;
  folder.write("env.yaml", kEnvironment);
  const struct {
    const char *source, *from, *to, *code;
    int line, column;
  } cases[] = {
      {kGym, "kps: [40, 30]", "kps: [40, 30, 20]", "CG1506", 7, 6},
      {kGym, "kps: [40, 30]", "kps: [40, much]", "CG1503", 7, 11},
      {kGym, "num_actions: 2", "num_actions: -2", "CG1503", 15, 14},
      {kGym, "num_obs: 17", "num_obs: 18", "CG1506", 16, 10},
      {kGym, "simulation_dt: 0.002", "simulation_dt: 0", "CG1503", 5, 16},
      {kGym, "kds: [2, 2]", "kds: {a: 2}", "CG1503", 8, 6},
      {kGym, "kps: [40, 30]", "kps: [40", "CG1501", 0, 0},
      {kIsaac, "joint_names: [wrist, elbow]\n  mdp", "joint_names: [wrist, elbo]\n  mdp", "CG1506",
       15, 3},
      {kIsaac, "offset: [-0.20000000298023224, 0.10000000149011612]", "offset: [1, 2, 3]", "CG1506",
       11, 11},
      {kIsaac, "[0.5, 0.5], [0.5, 0.5]", "[0.5, 0.5], [0.5, 0.6]", "CG1503", 12, 23},
      {kIsaac, "  policy:\n", "  polisy:\n", "CG1504", 22, 3},
      {kIsaac, "observations.base_lin_vel", "observations.base_lin_vell", "CG1515", 24, 16},
      {kIsaac, "units: m/s}", "units: km/h}", "CG1515", 23, 38},
      {kIsaac, "JointPositionAction", "RelativeJointPositionAction", "CG1515", 7, 14},
      {kIsaac, "joint_names: [wrist, elbow]\n    over", "joint_names: [elbow, wrist]\n    over",
       "CG1515", 32, 18},
      {kDeploy, "joint_ids_map: [2, 0]", "joint_ids_map: [2, 7]", "CG1506", 1, 16},
      {kDeploy, "scale: [0.25, 0.25]", "scale: [0.25, 0.25, 0.25]", "CG1506", 11, 12},
      {kDeploy, "  gait_phase:", "  height_scan:", "CG1515", 17, 3},
  };
  for (const auto& c : cases) {
    folder.write("source.yaml", replaced(c.source, c.from, c.to));
    std::vector<std::string> files = {"source.yaml"};
    if (c.source != kGym) files.emplace_back("env.yaml");
    const Imported out = import_of(folder, files, {{"fallen", "~"}, {"actions.clip", "~"}});
    INFO(c.to << "\n" << dsl::to_text(out.found));
    CHECK(out.card.empty());
    const Diagnostic& d = about(out.found, c.code);
    if (c.line == 0) continue;
    CHECK(d.line == c.line);
    CHECK(d.column == c.column);
  }
}

TEST_CASE("metadata of a network answer a part", "[import]") {
  const PolicyFolder folder;
  std::string bytes = network_of(16);
  for (const auto& [key, value] : {std::pair{"joint_names", "elbow,wrist"},
                                   {"default_joint_pos", "0.1,-0.2"},
                                   {"joint_stiffness", "40,30"},
                                   {"joint_damping", "2,1"},
                                   {"action_scale", "0.25"},
                                   {"observation_names", "base_ang_vel,joint_pos"}}) {
    std::string entry;
    protozero::pbf_writer writer(entry);
    writer.add_string(1, key);
    writer.add_string(2, value);
    protozero::pbf_writer(bytes).add_message(14, entry);
  }
  folder.write("tracked.onnx", bytes);
  const Imported out = import_of(folder, {"tracked.onnx"}, {});
  CHECK_THAT(about(out.found, "observations").message, Contains("base_ang_vel, joint_pos"));
  const Imported whole =
      import_of(folder, {"tracked.onnx"},
                {{"robot", "arm.scene.xml"},
                 {"base", "trunk"},
                 {"rate", "50 Hz"},
                 {"step", "~"},
                 {"fallen", "~"},
                 {"actions.kind", "position"},
                 {"actions.offset", "default"},
                 {"observations",
                  "[{base-angular-velocity: {frame: base}}, joint-positions, joint-velocities, "
                  "projected-gravity, last-action, command, base-height]"}});
  INFO(dsl::to_text(whole.found));
  CHECK_THAT(whole.card, Contains("kp: [40, 30]") && Contains("joints: [elbow, wrist]"));
  CHECK(checked(folder, whole.card).empty());
}

TEST_CASE("hostile sources end in bounded time", "[import][hostile]") {
  const PolicyFolder folder;
  const auto ends = [&](const std::string& text, const std::string& other = kEnvironment) {
    folder.write("source.yaml", text);
    folder.write("env.yaml", other);
    const Imported out = import_of(folder, {"source.yaml", "env.yaml"}, {});
    CHECK(out.card.empty());
    CHECK_FALSE(out.found.empty());
    for (const Diagnostic& d : out.found) CHECK_FALSE(d.code.empty());
  };
  // Aliases are allowed in what programs write: 9^10 values that are never looked at, or once.
  std::string bomb = "a: &a [x, x, x, x, x, x, x, x, x]\n";
  for (char c = 'b'; c < 'k'; ++c) {
    const std::string before = "*" + std::string(1, static_cast<char>(c - 1));
    bomb += std::string(1, c) + ": &" + c + " [" + before;
    for (int i = 0; i < 8; ++i) bomb += ", " + before;
    bomb += "]\n";
  }
  ends(bomb + kGym);
  ends(bomb + replaced(kGym, "kps: [40, 30]", "kps: *j"));
  ends(bomb + replaced(kIsaac, "joint_names: [wrist, elbow]\n  mdp", "joint_names: *j\n  mdp"));
  ends(bomb + replaced(kIsaac, "scale: [[0.5, 0.5], [0.5, 0.5]]", "scale: *j"));
  ends("kps: &k [*k]\n" + std::string(kGym).substr(0, 5) + "num_actions: 1\n");
  ends(std::string(2u << 20, 'a'));
  ends("num_actions: " + std::string(100000, '['));
  ends("");
  ends(replaced(kGym, "num_actions: 2", "num_actions: 1e300"));
  ends(replaced(kGym, "simulation_dt: 0.002", "simulation_dt: 1e-320"));
  // Patterns that a backtracking matcher would need 2^60 steps for, and very many of them.
  ends(kIsaac, replaced(kEnvironment, "elb.*", "(a*)*(a|aa)*b{1,9}(e|el|elb|elbo)*w*$x"));
  ends(kIsaac, replaced(kEnvironment, "elb.*", "a{1000}{1000}{1000}"));
  std::string many;
  for (int i = 0; i < 60000; ++i) many += (i ? ", x" : "x") + std::to_string(i) + ".*";
  ends(kIsaac, replaced(kEnvironment, "elb.*", many));
  std::string wide;
  for (int i = 0; i < 200000; ++i) wide += (i ? ",1" : "1");
  ends(replaced(kIsaac, "offset: [-0.20000000298023224, 0.10000000149011612]",
                "offset: [" + wide + "]"));
  folder.write("play.py", "obs = np.hstack([" + std::string(900000, '('));
  CHECK(import_of(folder, {"play.py"}, {}).card.empty());
  std::string items = "obs = np.hstack([";
  for (int i = 0; i < 150; ++i) items += "a" + std::to_string(i) + ", ";
  items += "])\n";
  for (int i = 0; i < 19000; ++i) items += "a" + std::to_string(i % 150) + " = b\n";
  folder.write("play.py", items);
  CHECK(import_of(folder, {"play.py"}, {}).card.empty());
}

TEST_CASE("answers that no card has are refused", "[import][bad]") {
  const PolicyFolder folder;
  folder.write("arm.yaml", kGym);
  folder.write("net17.onnx", network_of(17));
  for (const auto& [key, value, code] : {std::tuple{"ratte", "50 Hz", "CG1502"},
                                         {"observations.imu.scale", "2", "CG1502"},
                                         {"observations.command", "2", "CG1502"},
                                         {"policy", "2", "CG1502"},
                                         {"rate", "[50", "CG1503"},
                                         {"rate", "50 Hz\nbase: x", "CG1503"},
                                         {"rate", "*a", "CG1501"}}) {
    const Imported out = import_of(folder, {"arm.yaml"}, {{key, value}});
    INFO(key << "=" << value << "\n" << dsl::to_text(out.found));
    CHECK(out.card.empty());
    REQUIRE_FALSE(out.found.empty());
    CHECK((out.found.front().code == code || out.found.front().code == "CG1503"));
  }
}
