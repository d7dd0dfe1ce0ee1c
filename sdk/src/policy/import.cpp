#include "cogrsim/policy/import.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "cogrsim/core/shown_text.h"
#include "core/index.h"
#include "policy/import_readers.h"

namespace cogrsim {

namespace fs = std::filesystem;
using policy::CardDraft;
using policy::DraftTerm;
using policy::Question;
using policy::YamlText;

namespace policy {

void refuse(CardDraft& draft, const YamlText& yaml, const YAML::Node& at,
            const std::string& message, const std::string& help, const std::string& key) {
  Diagnostic d;
  d.locate(yaml.at(at));
  d.code = "CG1515";
  d.message = message;
  d.help = help;
  add_source_line(d, yaml.text());
  draft.refused.push_back(std::move(d));
  draft.refused_keys.push_back(key);
}

void ask(CardDraft& draft, const YamlText& yaml, const YAML::Node& at, const std::string& key,
         const std::string& reason, const std::string& answer) {
  Diagnostic d;
  d.locate(yaml.at(at));
  add_source_line(d, yaml.text());
  draft.ask(yaml.at(at), d.source_line, key, reason, answer);
}

std::optional<std::vector<double>> plain_numbers(YamlText& yaml, const YAML::Node& node,
                                                 const std::string& what) {
  // A tensor of one environment is a list with one list in it, one of several has alike lists.
  if (!node.IsDefined() || !node.IsSequence() || node.size() == 0 || !node[0].IsSequence())
    return yaml.quantities(node, {units::dim::kNone}, what);
  const auto first = yaml.quantities(node[0], {units::dim::kNone}, what);
  if (!first) return std::nullopt;
  const std::size_t rows = std::min(node.size(), 100000 / (first->size() + 1) + 1);
  for (std::size_t i = 1; i < rows; ++i) {
    const auto row = yaml.quantities(node[i], {units::dim::kNone}, what);
    if (!row) return std::nullopt;
    if (*row == *first) continue;
    yaml.error(node[i], "CG1503", fmt::format("{} differs from environment to environment", what));
    return std::nullopt;
  }
  return first;
}

void put_times(CardDraft& draft, double period, double step) {
  if (period > 0.0) draft.top.set("rate", fmt::format("{:.9g} Hz", 1.0 / period));
  if (step > 0.0) draft.top.set("step", fmt::format("{:.9g} ms", 1000.0 * step));
}

namespace {

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) {
    const std::size_t from = word.find_first_not_of(" \t"), to = word.find_last_not_of(" \t");
    out.push_back(from == std::string::npos ? "" : word.substr(from, to - from + 1));
  }
  return out;
}

}  // namespace

void read_metadata(const std::string& path, const PolicyNetwork& network, CardDraft& draft,
                   std::vector<Diagnostic>& found) {
  const auto& data = network.metadata();
  draft.comments.push_back(fmt::format("From the metadata of {}, as mjlab writes them.",
                                       one_line(fs::path(path).filename().string())));
  Diagnostic d;
  d.file = path;
  const auto words = [&](const char* key) {
    const auto at = data.find(key);
    return at == data.end() ? std::vector<std::string>() : words_of(at->second);
  };
  const std::vector<std::string> joints = words("joint_names");
  draft.top.set("joints", names_text(joints));
  const auto numbers = [&](const char* key) {
    std::vector<double> out;
    for (const std::string& word : words(key)) {
      const auto number = units::parse_number(word);
      if (!number) {
        d.code = "CG1503";
        d.message = fmt::format("the metadata '{}' has '{}', which is no number", key,
                                one_line(word.substr(0, 60)));
        found.push_back(d);
        return std::vector<double>();
      }
      out.push_back(*number);
    }
    if (out.size() != joints.size() && out.size() > 1) {
      d.code = "CG1506";
      d.message = fmt::format("the metadata '{}' has {} entries for {} joints", key, out.size(),
                              joints.size());
      found.push_back(d);
    }
    return out;
  };
  SourcePosition at;
  at.file = path;
  const auto put = [&](DraftMap& map, const char* key, const std::string& name,
                       const char* data_key, const char* unit) {
    const std::vector<double> values = numbers(data_key);
    if (values.empty())
      draft.ask(at, "", name, fmt::format("the metadata have no '{}'", data_key),
                fmt::format("--set '{}=…'", name));
    else
      map.set(key, *unit ? numbers_text(values, true) + unit : value_text(values));
  };
  put(draft.top, "default-pose", "default-pose", "default_joint_pos", " rad");
  put(draft.actions, "scale", "actions.scale", "action_scale", "");
  put(draft.actions, "kp", "actions.kp", "joint_stiffness", "");
  put(draft.actions, "kd", "actions.kd", "joint_damping", "");
  std::string names;
  for (const std::string& name : words("observation_names"))
    if (names.size() < 500) names += (names.empty() ? "" : ", ") + one_line(name.substr(0, 60));
  draft.ask(at, "", "observations",
            names.empty()
                ? "the metadata do not name them"
                : fmt::format(
                      "the metadata have the names {}, not what they are: frames, scales, history",
                      names),
            "--set 'observations=[{base-angular-velocity: {frame: base}}, projected-gravity, …]'");
  draft.ask(at, "", "actions.kind", "the metadata do not say what the output is",
            "--set actions.kind=position");
  draft.ask(at, "", "actions.offset", "the metadata do not say what is added to the output",
            "--set actions.offset=default, or none");
  draft.ask(at, "", "rate", "the metadata do not say how often the policy decides",
            "--set 'rate=50 Hz'");
  draft.ask(at, "", "step", "the metadata do not have the step of the physics",
            "--set 'step=5 ms', or --set step=~");
  draft.ask(at, "", "robot", "no file of the robot is named",
            "--robot FILE: its URDF, MJCF or scene");
  draft.ask(at, "", "base", "the body whose motion is observed is not named", "--base NAME");
  draft.ask(at, "", "fallen", "when the robot counts as fallen is not said",
            "--set 'fallen={height: 0.3 m, tilt: 60 deg}', or --set fallen=~ for a tilt of 1 rad");
  draft.top.set("network", name_text(path));
}

}  // namespace policy

struct PolicySources::Impl {
  CardDraft draft;
  std::string folder_of_source;
};

PolicySources::PolicySources() : impl_(std::make_unique<Impl>()) {}
PolicySources::~PolicySources() = default;

namespace {

// Of a robot, in the order of its file.
struct Outline {
  std::vector<std::string> joints, roots, bodies;
  std::vector<double> pose;
  std::vector<bool> slides;
};

// The shortest name by which a card may call an element.
std::string short_name(const std::vector<std::string>& all, const std::string& name) {
  const std::string end = name.substr(name.rfind('.') + 1);
  return find_policy_name(all, end) >= 0 ? end : name;
}

Outline outline_of(const SceneModel& model) {
  Outline out;
  std::vector<std::string> bodies, joints;
  for (const Body& body : model.bodies) bodies.push_back(body.removed ? "" : body.name);
  for (const Joint& joint : model.joints) joints.push_back(joint.removed ? "" : joint.name);
  std::vector<bool> held(bodies.size(), false), holds(bodies.size(), false);
  for (const Joint& joint : model.joints) {
    if (joint.removed) continue;
    if (joint.child >= 0) held[at(joint.child)] = joint.type != JointType::free;
    if (joint.parent >= 0) holds[at(joint.parent)] = true;
    if (joint.axes.size() != 1 || joint.position.size() != 1) continue;
    out.joints.push_back(short_name(joints, joint.name));
    out.pose.push_back(joint.position.front());
    out.slides.push_back(joint.type == JointType::slider);
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].empty() || model.bodies[i].kind != BodyKind::dynamic) continue;
    out.bodies.push_back(short_name(bodies, bodies[i]));
    if (!held[i] && holds[i]) out.roots.push_back(out.bodies.back());
  }
  return out;
}

std::string some(const std::vector<std::string>& names) {
  std::string out;
  for (std::size_t i = 0; i < names.size() && i < 40; ++i)
    out += (out.empty() ? "" : ", ") + one_line(names[i]);
  return names.size() > 40 ? out + ", …" : out;
}

// Files are read with a bound, one byte more than is allowed shows that there are more.
std::optional<std::string> text_of(const std::string& path, std::size_t most,
                                   std::vector<Diagnostic>& found) {
  Diagnostic d;
  d.file = path;
  d.code = "CG1501";
  std::error_code error;
  std::ifstream file;
  if (fs::is_regular_file(path, error)) file.open(path, std::ios::binary);
  if (!file.is_open()) {
    d.message = "there is no such file";
    found.push_back(d);
    return std::nullopt;
  }
  std::string text(most + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() <= most) return text;
  d.message = "it has more than 1 MB";
  found.push_back(d);
  return std::nullopt;
}

}  // namespace

std::unique_ptr<PolicySources> PolicySources::read(const std::vector<std::string>& paths,
                                                   std::vector<Diagnostic>& found) {
  std::unique_ptr<PolicySources> out(new PolicySources);
  CardDraft& draft = out->impl_->draft;
  std::vector<std::unique_ptr<YamlText>> texts;
  std::vector<std::string> main, network;  // "isaac", …
  YamlText *env = nullptr, *described = nullptr;
  std::string described_path;
  const std::size_t before = found.size();
  const auto refuse = [&](const std::string& path, const char* code, const std::string& message,
                          const std::string& help) {
    Diagnostic d;
    d.file = path;
    d.code = code;
    d.message = message;
    d.help = help;
    found.push_back(std::move(d));
  };
  std::shared_ptr<const PolicyNetwork> onnx;
  std::string script, kind;
  const auto only = [&](const std::string& path, const char* what) {
    if (!kind.empty())
      refuse(path, "CG1502",
             fmt::format("'{}' and '{}' both describe a policy", one_line(described_path),
                         one_line(path)),
             "import one of them; env.yaml and the ONNX file may stand beside it");
    kind = what;
    described_path = path;
  };
  for (const std::string& path : paths) {
    const std::string ending = fs::path(path).extension().string();
    if (ending == ".onnx") {
      auto read = PolicyNetwork::read(path);
      if (!read) {
        found.push_back(to_diagnostic(read.error()));
        continue;
      }
      if (!network.empty()) refuse(path, "CG1502", "a second network", "import one");
      network.push_back(path);
      onnx = *read;
      continue;
    }
    if (ending == ".pt" || ending == ".pth" || ending == ".jit") {
      refuse(
          path, "CG1510", "that is a network of PyTorch, and cards have ONNX",
          "export it once: docs/guide/policies.md, Networks, has how, with the state of an LSTM");
      continue;
    }
    const auto text = text_of(path, 1u << 20, found);
    if (!text) continue;
    if (ending == ".py") {
      only(path, "playground");
      script = *text;
      continue;
    }
    auto yaml = std::make_unique<YamlText>(path, *text);
    yaml->allow_aliases();
    bool good = false;
    try {
      good = yaml->parse();
    } catch (const YAML::Exception& e) {
      yaml->error(yaml->root(), "CG1501", "the file cannot be read: " + one_line(e.msg));
    }
    if (!good) {
      found.insert(found.end(), yaml->found.begin(), yaml->found.end());
      continue;
    }
    const YAML::Node root = yaml->root();
    const auto has = [&](const char* key) { return root[key].IsDefined(); };
    if (has("articulations") && has("actions") && has("observations")) {
      only(path, "isaac");
      described = yaml.get();
    } else if (has("joint_ids_map") && has("stiffness")) {
      only(path, "deploy");
      described = yaml.get();
    } else if (has("kps") && (has("num_actions") || has("num_obs"))) {
      only(path, "gym");
      described = yaml.get();
    } else if (has("sim") && has("scene") && has("decimation")) {
      if (env) refuse(path, "CG1502", "a second env.yaml", "import one");
      env = yaml.get();
    } else {
      yaml->error(
          root, "CG1502", "this is no file of a policy that is known",
          "there are Isaac Lab's IO_descriptors.yaml and env.yaml, the configs of unitree_rl_gym, "
          "deploy.yaml of unitree_rl_lab, play_*.py of mujoco_playground, and ONNX with metadata");
      found.insert(found.end(), yaml->found.begin(), yaml->found.end());
      yaml->found.clear();
    }
    texts.push_back(std::move(yaml));
  }
  if (found.size() > before) return nullptr;
  try {
    if (kind == "isaac")
      policy::read_isaac_descriptors(*described, env, draft);
    else if (kind == "deploy")
      policy::read_unitree_deploy(*described, env, draft);
    else if (kind == "gym")
      policy::read_unitree_gym(*described, described_path, draft);
    else if (kind == "playground")
      policy::read_playground(described_path, script, draft, found);
    else if (onnx && onnx->metadata().count("joint_names") > 0)
      policy::read_metadata(network.front(), *onnx, draft, found);
    else
      refuse(paths.empty() ? "" : paths.front(), "CG1502",
             onnx ? "the network has no metadata of its joints, so more is needed than the network"
                  : "this describes no policy alone",
             "name what describes it, too: IO_descriptors.yaml, a config of unitree_rl_gym, "
             "deploy.yaml, or "
             "play_*.py");
    if (kind == "gym" && env)
      refuse(env->root().IsDefined() ? paths.back() : "", "CG1502",
             "env.yaml does not belong to that file", "it is of Isaac Lab");
  } catch (const YAML::Exception& e) {
    refuse(described_path, "CG1503",
           "a value is not of the kind that its key has: " + one_line(e.msg), "");
  }
  if (!network.empty()) {
    draft.top.set("network", policy::name_text(network.front()));
    draft.answered.push_back("network");
  }
  for (const auto& yaml : texts) found.insert(found.end(), yaml->found.begin(), yaml->found.end());
  if (found.size() > before) return nullptr;
  return out;
}

void PolicySources::answer(const CardChanges& changes, std::vector<Diagnostic>& found) {
  for (const auto& [key, value] : changes) {
    Diagnostic d;
    d.file = "--set " + one_line(key.substr(0, 100));
    d.code = "CG1502";
    const bool plain =
        std::none_of(value.begin(), value.end(), [](unsigned char c) { return c < 0x20; });
    YamlText given(d.file, "value: " + value);
    if (!plain || !given.parse() || given.root().size() != 1) {
      d.code = "CG1503";
      d.message = fmt::format("'{}' is no value in YAML", one_line(value.substr(0, 60)));
      found.push_back(d);
    } else if (!impl_->draft.answer(key, value)) {
      d.message = fmt::format("a card has no '{}' that could be set", one_line(key.substr(0, 60)));
      d.help = "name a key, such as base, actions.delay or observations.command.scale";
      found.push_back(d);
    }
  }
}

namespace {

std::string unquoted(const std::string* text) {
  if (!text) return {};
  try {
    const YAML::Node node = YAML::Load(*text);
    return node.IsScalar() ? node.Scalar() : std::string();
  } catch (const YAML::Exception&) {
    return {};
  }
}

}  // namespace

std::string PolicySources::robot() const { return unquoted(impl_->draft.top.find("robot")); }
std::string PolicySources::keyframe() const { return unquoted(impl_->draft.top.find("keyframe")); }
std::string PolicySources::network() const { return unquoted(impl_->draft.top.find("network")); }

PolicyActions PolicySources::drives() const {
  PolicyActions out;
  const std::string kind = unquoted(impl_->draft.actions.find("kind"));
  out.kind = kind == "torque"     ? PolicyActionKind::torque
             : kind == "velocity" ? PolicyActionKind::velocity
                                  : PolicyActionKind::position;
  for (const auto& [key, to] : {std::pair{"kp", &out.kp}, {"kd", &out.kd}})
    if (impl_->draft.actions.find(key)) to->push_back(1.0);
  return out;
}

namespace {

class Completion {
 public:
  Completion(CardDraft draft, std::string folder, std::vector<Diagnostic>& found)
      : draft_(std::move(draft)), folder_(std::move(folder)), found_(found) {}

  std::string run(const SceneModel* robot, const PolicyNetwork* network) {
    const std::size_t before = found_.size();
    Outline outline;
    if (robot) outline = outline_of(*robot);
    if (robot && draft_.joints_of_robot) joints(outline);
    if (robot && draft_.pose_of_robot) pose(outline);
    if (robot && draft_.base_of_robot) base(outline);
    hidden(outline);
    state(network);
    for (std::size_t i = 0; i < draft_.refused.size(); ++i)
      if (draft_.refused_keys[i].empty() || !draft_.knows(draft_.refused_keys[i]))
        found_.push_back(draft_.refused[i]);
    for (const Question& q : draft_.questions) {
      if (draft_.knows(q.key) || (q.key == "robot" && draft_.top.find("robot")) ||
          (q.key == "network" && draft_.top.find("network")) ||
          (q.key == "base" && draft_.top.find("base")))
        continue;
      found_.push_back(open(q, outline));
    }
    for (const char* key : {"robot", "network"}) path(key);
    // A scene that was imported starts in it.
    const std::string file = unquoted(draft_.top.find("robot")), ending = ".scene.xml";
    if (file.size() > ending.size() &&
        file.compare(file.size() - ending.size(), ending.size(), ending) == 0)
      draft_.top.remove("keyframe");
    // Without the robot, what went wrong with it was told before.
    if (found_.size() > before || (!robot && draft_.joints_of_robot)) return {};
    const std::string text = draft_.text();
    YamlText whole("the card", text);
    if (!whole.parse()) {
      found_.insert(found_.end(), whole.found.begin(), whole.found.end());
      return {};
    }
    return text;
  }

 private:
  Diagnostic open(const Question& q, const Outline& outline) const {
    Diagnostic d;
    d.locate(q);
    d.code = "CG1514";
    d.source_line = q.source_line;
    d.message = fmt::format("'{}' is open: {}", q.key, q.reason);
    d.help = q.answer;
    if (q.key == "base" && !outline.bodies.empty())
      d.help += outline.roots.size() == 1
                    ? fmt::format("; the robot's root is '{}'", one_line(outline.roots.front()))
                    : fmt::format("; the robot has {}", some(outline.bodies));
    if (q.key == "joints" && !outline.joints.empty()) {
      d.help += fmt::format("; the robot has {}", some(outline.joints));
      if (draft_.sdk_order.size() == outline.joints.size() && outline.joints.size() <= 100) {
        std::string order;
        for (const int i : draft_.sdk_order)
          order +=
              (order.empty() ? "" : ", ") +
              (at(i) < outline.joints.size() ? one_line(outline.joints[at(i)]) : std::string("?"));
        d.help +=
            fmt::format("; if its file has them in the order of the SDK, that is [{}]", order);
      }
    }
    return d;
  }

  void error(const SourcePosition& place, const char* code, const std::string& message,
             const std::string& help) {
    Diagnostic d;
    d.locate(place);
    d.code = code;
    d.message = message;
    d.help = help;
    found_.push_back(std::move(d));
  }

  void joints(const Outline& robot) {
    if (draft_.knows("joints")) return;
    if (draft_.joint_count > 0 && draft_.joint_count != robot.joints.size()) {
      error(
          draft_.counted, "CG1506",
          fmt::format("the policy has {} joints, and the robot {}", draft_.joint_count,
                      robot.joints.size()),
          fmt::format("name them in the order of the output: --set 'joints=[…]'; the robot has {}",
                      some(robot.joints)));
      return;
    }
    draft_.top.set("joints", policy::names_text(robot.joints));
  }

  void pose(const Outline& robot) {
    if (draft_.knows("default-pose")) return;
    if (std::none_of(robot.slides.begin(), robot.slides.end(), [](bool s) { return s; })) {
      draft_.top.set("default-pose", policy::numbers_text(robot.pose, true) + " rad");
      return;
    }
    std::string list = "[";
    for (std::size_t i = 0; i < robot.pose.size(); ++i)
      list += fmt::format("{}{} {}", i ? ", " : "", policy::number_text(robot.pose[i]),
                          robot.slides[i] ? "m" : "rad");
    draft_.top.set("default-pose", list + "]");
  }

  // The body with the free joint of the file.
  void base(const Outline& robot) {
    if (draft_.knows("base")) return;
    if (robot.roots.size() == 1)
      draft_.top.set("base", policy::name_text(robot.roots.front()));
    else
      draft_.ask(
          draft_.counted, "", "base",
          fmt::format("the robot has {} bodies that are not held by a joint", robot.roots.size()),
          "--base NAME");
  }

  // Terms whose first values are made 0.
  void hidden(const Outline& robot) {
    for (DraftTerm& term : draft_.observations) {
      const std::string* scale = term.settings.find("scale");
      if (!scale || scale->compare(0, 7, "hidden ") != 0) continue;
      std::vector<double> values(robot.joints.size(), 1.0);
      const std::size_t first = std::stoul(scale->substr(7));
      std::fill_n(values.begin(), std::min(first, values.size()), 0.0);
      term.settings.set("scale", policy::list_text(values));
    }
  }

  // Inputs beside the observations are state, and only the person knows which output each has next; alike
  // sizes are proposed.
  void state(const PolicyNetwork* network) {
    if (!network || network->inputs().size() < 2 || draft_.knows("state") ||
        draft_.top.find("state"))
      return;
    std::string proposed;
    for (std::size_t i = 1; i < network->inputs().size() && i < 20; ++i) {
      const NetworkPort& in = network->inputs()[i];
      std::string to = "OUTPUT";
      const std::string stem = in.name.substr(0, in.name.rfind("_in"));
      for (const NetworkPort& out : network->outputs())
        if (out.size == in.size && out.name == stem + "_out") to = out.name;
      proposed +=
          fmt::format("{}{}: {}", proposed.empty() ? "" : ", ", one_line(in.name), one_line(to));
    }
    SourcePosition place;
    place.file = unquoted(draft_.top.find("network"));
    draft_.ask(
        place, "", "state",
        fmt::format(
            "the network has {} inputs, and the file does not say what fills those beside '{}'",
            network->inputs().size(), one_line(network->inputs().front().name)),
        fmt::format("--set 'state={{{}}}'", proposed));
  }

  // As seen from the card's folder, below which it must lie.
  void path(const char* key) {
    const std::string name = unquoted(draft_.top.find(key));
    if (name.empty()) return;
    std::error_code problem;
    const fs::path folder = fs::weakly_canonical(
                       folder_.empty() ? fs::path(".") : fs::path(folder_), problem),
                   full = fs::weakly_canonical(name, problem),
                   inside = full.lexically_relative(folder);
    if (!fs::is_regular_file(full, problem)) {
      SourcePosition at;
      at.file = name;
      error(at, "CG1503", "there is no such file", fmt::format("--{} FILE", key));
    } else if (inside.empty() || *inside.begin() == "..") {
      fs::path common;
      auto a = folder.begin();
      for (auto b = full.begin(); a != folder.end() && b != full.end() && *a == *b; ++a, ++b)
        common /= *a;
      SourcePosition at;
      at.file = name;
      error(at, "CG1503",
            fmt::format("it lies outside of the card's folder '{}'", one_line(folder.string())),
            fmt::format("put the card into a folder above it, such as '{}', with -o",
                        one_line(common.string())));
    } else {
      draft_.top.set(key, policy::name_text(inside.generic_string()));
    }
  }

  CardDraft draft_;
  std::string folder_;
  std::vector<Diagnostic>& found_;
};

}  // namespace

std::string PolicySources::card(const std::string& folder, const SceneModel* robot,
                                const PolicyNetwork* network, std::vector<Diagnostic>& found) {
  return Completion(impl_->draft, folder, found).run(robot, network);
}

}  // namespace cogrsim
