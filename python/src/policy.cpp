// Trained policies: cards and networks, observations and actions of one world or of many at once.
#include "policy.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include "cogrsim/core/random.h"
#include "cogrsim/core/roll_pitch_yaw.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/dsl/policy_robot.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/policy/card.h"
#include "cogrsim/policy/observer.h"
#include "frame.h"
#include "scene.h"

namespace cogrsim::python {

namespace {

using Floats = std::vector<float>;
using Array = py::array_t<double>;

constexpr std::size_t kBase = 12;  // columns of the base in what is measured
constexpr const char* kBaseSignals[kBase] = {"x",  "y",  "z",  "roll", "pitch", "yaw",
                                             "vx", "vy", "vz", "wx",   "wy",    "wz"};

struct PyPolicy {
  std::shared_ptr<const PolicyCard> card;  ///< nullptr: a network alone
  std::shared_ptr<const PolicyNetwork> network;
  PolicyPorts ports;
  std::string path;
  ScenePtr scene;  ///< of the card's robot, once it was asked for

  const NetworkPort& input() const { return network->inputs()[ports.observed]; }
  const NetworkPort& output() const { return network->outputs()[ports.acting]; }
  std::size_t joints() const { return card ? card->joints.size() : output().size; }
};
using PolicyPtr = std::shared_ptr<PyPolicy>;

/// What a policy remembers of each world from one decision to the next.
struct PyPolicyMemory {
  PolicyPtr policy;
  bool one = false;  ///< made for a single world: arrays have no dimension of worlds
  struct World {
    std::vector<Floats> inputs;  ///< of the network; those of the state have what they have next
    std::vector<double> raw, clipped;
    std::uint64_t seed = 0;
    RandomStream random{0, "policy"};
    std::unique_ptr<PolicyObserver> observer;  ///< refers to `random`
  };
  std::vector<std::unique_ptr<World>> worlds;

  void reset(std::size_t i) {
    World& w = *worlds[i];
    w.inputs.clear();
    for (const NetworkPort& port : policy->network->inputs())
      w.inputs.emplace_back(port.size, 0.0f);
    w.raw.assign(policy->joints(), 0.0);
    w.clipped = w.raw;
    w.random = RandomStream(w.seed, "policy");
    if (policy->card)
      w.observer = std::make_unique<PolicyObserver>(
          *policy->card, policy->card->period,
          [&random = w.random](double low, double high) { return random.uniform(low, high); });
  }
};
using MemoryPtr = std::shared_ptr<PyPolicyMemory>;

PolicyPtr load(const py::object& path, const std::map<std::string, std::string>& change) {
  auto out = std::make_shared<PyPolicy>();
  out->path = path_of(path);
  std::string network = out->path;
  const bool alone = network.size() > 5 && network.compare(network.size() - 5, 5, ".onnx") == 0;
  if (alone && !change.empty()) throw py::value_error("change: a network has no keys of a card");
  std::vector<Diagnostic> found;
  if (!alone) {
    out->card = read_policy_card(out->path, found, {change.begin(), change.end()});
    if (!out->card) raise("CompileError", found);
    network = out->card->network;
  }
  auto read = [&] {
    const Unlock unlock;
    return PolicyNetwork::read(network);
  }();
  if (!read) raise(read.error());
  out->network = *read;
  if (out->card) {
    found = check_policy_network(*out->card, *out->network);
    if (first_error(found)) raise("CompileError", found);
    out->ports = policy_ports(*out->card, *out->network);
  }
  return out;
}

const PolicyCard& card_of(const PyPolicy& self, const char* what) {
  if (!self.card)
    raise("Error",
          fmt::format("{}: {} is a network alone, and only a card says this", what, self.path));
  return *self.card;
}

ScenePtr robot_scene(PyPolicy& self) {
  const PolicyCard& card = card_of(self, "scene");
  if (self.scene) return self.scene;
  auto out = std::make_shared<Scene>();
  out->loader = std::make_shared<PluginLoader>();
  std::vector<Diagnostic> found;
  dsl::CompileResult compiled = [&] {
    const Unlock unlock;
    dsl::LoaderCatalog catalog(out->loader);
    return dsl::compile_policy_robot(card, catalog, found, out->files);
  }();
  found.insert(found.end(), compiled.diagnostics.begin(), compiled.diagnostics.end());
  if (!compiled.model) raise("CompileError", found);
  out->model = compiled.model;
  out->diagnostics = std::move(found);
  out->path = card.robot;
  self.scene = out;
  return out;
}

ScenePtr scene_for(PyPolicy& self, const py::object& scene) {
  return scene.is_none() ? robot_scene(self) : scene_of(scene);
}

PolicyRobot robot_in(PyPolicy& self, const SceneModel& model) {
  std::vector<Diagnostic> found;
  const PolicyRobot robot = find_policy_robot(card_of(self, "scene"), model, found);
  if (first_error(found)) raise("CompileError", found);
  return robot;
}

std::vector<Diagnostic> compared(PyPolicy& self, const py::object& scene) {
  std::vector<Diagnostic> found;
  if (!self.card) return found;
  const ScenePtr given = scene_for(self, scene);
  if (scene.is_none()) found = given->diagnostics;
  find_policy_robot(*self.card, *given->model, found);
  return found;
}

std::vector<std::string> signals(PyPolicy& self, const py::object& scene) {
  const ScenePtr given = scene_for(self, scene);
  const SceneModel& model = *given->model;
  const PolicyRobot robot = robot_in(self, model);
  std::vector<std::string> names;
  for (const NamedFrame& frame : model.frames) names.push_back(frame.removed ? "" : frame.name);
  std::string base = model.bodies[static_cast<std::size_t>(robot.base)].name;
  std::vector<std::string> bodies;
  for (const Body& body : model.bodies) bodies.push_back(body.removed ? "" : body.name);
  if (find_policy_name(bodies, self.card->base) < 0)
    base = names[static_cast<std::size_t>(find_policy_name(names, self.card->base))];
  std::vector<std::string> out;
  for (const char* signal : kBaseSignals) out.push_back(base + "." + signal);
  for (const char* what : {".position", ".velocity"})
    for (const int joint : robot.joints)
      out.push_back(model.joints[static_cast<std::size_t>(joint)].name + what);
  return out;
}

std::vector<std::string> motors(PyPolicy& self, const py::object& scene) {
  const ScenePtr given = scene_for(self, scene);
  std::vector<std::string> out;
  for (const int motor : robot_in(self, *given->model).motors)
    out.push_back(given->model->motors[static_cast<std::size_t>(motor)].name);
  return out;
}

/// The rows of an array (width,) or (worlds, width) for a memory. Errors: TypeError, ValueError.
Array rows(const py::object& given, const std::string& name, std::size_t width, std::size_t worlds,
           bool one) {
  const auto columns = static_cast<py::ssize_t>(width);
  return one ? numbers(given, name, {columns})
             : numbers(given, name, {static_cast<py::ssize_t>(worlds), columns});
}

template <class T>
py::array_t<T> result(std::size_t worlds, std::size_t width, bool one) {
  return one ? py::array_t<T>(static_cast<py::ssize_t>(width))
             : py::array_t<T>({static_cast<py::ssize_t>(worlds), static_cast<py::ssize_t>(width)});
}

void of_this(const PyPolicy& self, const PyPolicyMemory& memory) {
  if (memory.policy.get() != &self) throw py::value_error("memory: it was made by another policy");
}

MemoryPtr make_memory(const PolicyPtr& self, const std::optional<int>& worlds,
                      const std::vector<std::uint64_t>& seeds) {
  auto out = std::make_shared<PyPolicyMemory>();
  out->policy = self;
  out->one = !worlds;
  const int count = worlds.value_or(1);
  if (count < 1 || count > 100000)
    throw py::value_error("worlds: expected 1 to 100000, given " + std::to_string(count));
  if (!seeds.empty() && seeds.size() != static_cast<std::size_t>(count))
    throw py::value_error(fmt::format("seeds: expected {}, given {}", count, seeds.size()));
  if (!self->card && self->network->inputs().size() > 1)
    raise("Error",
          "the network has several inputs: give its card, which says which output each has next");
  if (self->card) {
    if (self->card->actions.delay > 0.0)
      raise("Error",
            fmt::format("actions.delay is {} s, and targets() gives what a decision asks for at "
                        "once: delay it yourself, and load the policy with "
                        "change={{\"actions.delay\": \"0 s\"}}",
                        self->card->actions.delay));
    for (const PolicyObservation& o : self->card->observations) {
      const double decisions = o.delay / self->card->period;
      if (std::fabs(decisions - std::round(decisions)) > 1e-6)
        raise("Error",
              fmt::format("{}: the delay of {} s is no whole number of decisions, and observe() "
                          "sees the robot once in each",
                          to_string(o.term), o.delay));
    }
  }
  for (int i = 0; i < count; ++i) {
    out->worlds.push_back(std::make_unique<PyPolicyMemory::World>());
    out->worlds.back()->seed =
        seeds.empty() ? static_cast<std::uint64_t>(i) : seeds[std::size_t(i)];
    out->reset(std::size_t(i));
  }
  return out;
}

/// A command for each world: one for all of them, or a row for each.
std::vector<std::vector<double>> commands_of(const PolicyCard& card, const py::object& given,
                                             std::size_t worlds, bool one) {
  std::vector<std::vector<double>> out(worlds, card.command);
  if (given.is_none()) return out;
  const py::array array = py::module_::import("numpy").attr("asarray")(given).cast<py::array>();
  const bool shared = one || array.ndim() == 1;
  const Array values = rows(array, "command", card.command.size(), worlds, shared);
  const double* from = values.data();
  for (std::vector<double>& each : out) {
    each.assign(from, from + card.command.size());
    if (!shared) from += card.command.size();
  }
  return out;
}

py::array_t<float> observe(PyPolicy& self, const py::object& measured, PyPolicyMemory& memory,
                           const py::object& command) {
  const PolicyCard& card = card_of(self, "observe");
  of_this(self, memory);
  const std::size_t joints = self.joints(), count = memory.worlds.size();
  const Array seen = rows(measured, "measured", kBase + 2 * joints, count, memory.one);
  const auto commands = commands_of(card, command, count, memory.one);
  auto out = result<float>(count, self.input().size, memory.one);
  float* to = out.mutable_data();
  const double* from = seen.data();
  for (std::size_t i = 0; i < count; ++i) {
    PolicyMeasured now;
    now.base.p = {from[0], from[1], from[2]};
    now.base.q = from_rpy({from[3], from[4], from[5]});
    now.twist.linear = {from[6], from[7], from[8]};
    now.twist.angular = {from[9], from[10], from[11]};
    now.positions.assign(from + kBase, from + kBase + joints);
    now.velocities.assign(from + kBase + joints, from + kBase + 2 * joints);
    from += kBase + 2 * joints;
    PyPolicyMemory::World& world = *memory.worlds[i];
    world.observer->measure(now);
    const Floats values = world.observer->decide(commands[i], world.raw, world.clipped);
    to = std::copy(values.begin(), values.end(), to);
  }
  return out;
}

/// The network of every row, in contiguous parts on several threads: a row is evaluated by one thread in a
/// fixed order, so the bits depend neither on their number nor on the other rows.
void evaluate(const PyPolicy& self, std::vector<std::vector<Floats>>& inputs,
              std::vector<std::vector<Floats>>& outputs, std::vector<std::string>& problems) {
  const std::size_t count = inputs.size();
  outputs.resize(count);
  problems.resize(count);
  const auto part = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      auto out = self.network->run(inputs[i]);
      if (out)
        outputs[i] = std::move(*out);
      else
        problems[i] = out.error().text();
    }
  };
  const std::size_t threads =
      std::min<std::size_t>({count / 8 + 1, std::max(1u, std::thread::hardware_concurrency()), 64});
  std::vector<std::thread> others;
  for (std::size_t t = 1; t < threads; ++t)
    others.emplace_back(part, count * t / threads, count * (t + 1) / threads);
  part(0, count / threads);
  for (std::thread& each : others) each.join();
}

py::array_t<float> act(PyPolicy& self, const py::object& observations, const py::object& given) {
  const std::size_t width = self.input().size, actions = self.output().size;
  PyPolicyMemory* memory = nullptr;
  if (!given.is_none()) {
    memory = given.cast<PyPolicyMemory*>();
    of_this(self, *memory);
  } else if (self.network->inputs().size() > 1) {
    if (!self.card)
      raise("Error",
            "the network has several inputs: give its card, which says which output each has next");
    throw py::value_error("memory: the network has a state; give the memory of start()");
  }
  const py::array array =
      py::module_::import("numpy").attr("asarray")(observations).cast<py::array>();
  const bool one = memory ? memory->one : array.ndim() == 1;
  const std::size_t count = memory                     ? memory->worlds.size()
                            : one || array.ndim() == 0 ? 1
                                                       : static_cast<std::size_t>(array.shape(0));
  const Array seen = rows(array, "observations", width, count, one);
  std::vector<std::vector<Floats>> inputs(count), outputs;
  std::vector<std::string> problems;
  const double* from = seen.data();
  for (std::size_t i = 0; i < count; ++i) {
    inputs[i] = memory ? memory->worlds[i]->inputs : std::vector<Floats>(1);
    inputs[i][self.ports.observed].assign(from, from + width);
    from += width;
  }
  {
    const Unlock unlock;
    evaluate(self, inputs, outputs, problems);
  }
  auto out = result<float>(count, actions, one);
  float* to = out.mutable_data();
  for (std::size_t i = 0; i < count; ++i) {
    if (!problems[i].empty()) raise("Error", problems[i]);
    const Floats& action = outputs[i][self.ports.acting];
    to = std::copy(action.begin(), action.end(), to);
    if (!memory) continue;
    PyPolicyMemory::World& world = *memory->worlds[i];
    for (const auto& [in, by] : self.ports.feedback) world.inputs[in] = outputs[i][by];
    const auto* clip = self.card && self.card->actions.clip ? &*self.card->actions.clip : nullptr;
    for (std::size_t k = 0; k < actions; ++k) {
      world.raw[k] = static_cast<double>(action[k]);
      world.clipped[k] = clip ? std::clamp(world.raw[k], clip->first, clip->second) : world.raw[k];
    }
  }
  return out;
}

/// An array of one row or of many.
struct Rows {
  Array values;
  std::size_t count;
  bool one;
};
Rows any_rows(const py::object& given, const std::string& name, std::size_t width) {
  const py::array array = py::module_::import("numpy").attr("asarray")(given).cast<py::array>();
  const bool one = array.ndim() == 1;
  const std::size_t count = one || array.ndim() == 0 ? 1 : static_cast<std::size_t>(array.shape(0));
  return {rows(array, name, width, count, one), count, one};
}

Array targets(PyPolicy& self, const py::object& actions) {
  const PolicyActions& a = card_of(self, "targets").actions;
  const std::size_t joints = self.joints();
  const Rows given = any_rows(actions, "actions", joints);
  auto out = result<double>(given.count, joints, given.one);
  double* to = out.mutable_data();
  for (std::size_t i = 0; i < given.count * joints; ++i) {
    double value = given.values.data()[i];
    if (a.clip) value = std::clamp(value, a.clip->first, a.clip->second);
    to[i] = a.offset[i % joints] + a.scale[i % joints] * value;
  }
  return out;
}

Array efforts(PyPolicy& self, const py::object& targets, const py::object& measured) {
  const PolicyActions& a = card_of(self, "efforts").actions;
  const std::size_t joints = self.joints();
  if (a.kd.empty())
    raise("Error", "efforts: the card has no gains; the robot's own motors are given the targets");
  const Rows wanted = any_rows(targets, "targets", joints);
  const Array seen = rows(measured, "measured", kBase + 2 * joints, wanted.count, wanted.one);
  auto out = result<double>(wanted.count, joints, wanted.one);
  double* to = out.mutable_data();
  for (std::size_t i = 0; i < wanted.count; ++i) {
    const double* q = seen.data() + i * (kBase + 2 * joints) + kBase;
    const double* speed = q + joints;
    for (std::size_t k = 0; k < joints; ++k) {
      const double target = wanted.values.data()[i * joints + k];
      double value = a.kind == PolicyActionKind::velocity
                         ? a.kd[k] * (target - speed[k])
                         : a.kp[k] * (target - q[k]) - a.kd[k] * speed[k];
      *to++ = a.limited(k, value, speed[k]);
    }
  }
  return out;
}

Array measure(PyPolicy& self, const PyFrame& frame) {
  const SceneModel& model = *frame.frame->model;
  const PolicyRobot robot = robot_in(self, model);
  const std::size_t joints = self.joints();
  const WorldState& state = frame.frame->state;
  const auto base = static_cast<std::size_t>(robot.base);
  const Pose& X_WB = state.poses[base];
  const Vec3 arm = X_WB.q * robot.X_BF.p, p = X_WB.p + arm;
  const Vec3 rpy = roll_pitch_yaw(X_WB.q * robot.X_BF.q);
  const Vec3 w = state.twists[base].angular, v = state.twists[base].linear + w.cross(arm);
  Array out(static_cast<py::ssize_t>(kBase + 2 * joints));
  double* to = out.mutable_data();
  for (const Vec3* part : {&p, &rpy, &v, &w}) to = std::copy_n(part->data(), 3, to);
  for (std::size_t i = 0; i < joints; ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(robot.joints[i])];
    to[i] = state.joint_positions[static_cast<std::size_t>(joint.position_offset)];
    to[joints + i] = state.joint_velocities[static_cast<std::size_t>(joint.speed_offset)];
  }
  return out;
}

py::dict state_of(const PyPolicyMemory& self) {
  py::dict out;
  for (const auto& [in, by] : self.policy->ports.feedback) {
    const NetworkPort& port = self.policy->network->inputs()[in];
    auto values = result<float>(self.worlds.size(), port.size, self.one);
    float* to = values.mutable_data();
    for (const auto& world : self.worlds)
      to = std::copy(world->inputs[in].begin(), world->inputs[in].end(), to);
    out[py::str(port.name)] = values;
  }
  return out;
}

void set_state(PyPolicyMemory& self, const py::dict& given) {
  const auto& inputs = self.policy->network->inputs();
  for (const auto& [key, value] : given) {
    const std::string name = text_of(key, "state");
    std::vector<std::string> names;
    const std::pair<std::size_t, std::size_t>* found = nullptr;
    for (const auto& each : self.policy->ports.feedback) {
      names.push_back(inputs[each.first].name);
      if (names.back() == name) found = &each;
    }
    if (!found) raise_unknown("state", name, names);
    const std::size_t size = inputs[found->first].size;
    const Array values = rows(py::reinterpret_borrow<py::object>(value), "state", size,
                              self.worlds.size(), self.one);
    for (std::size_t i = 0; i < self.worlds.size(); ++i)
      self.worlds[i]->inputs[found->first].assign(values.data() + i * size,
                                                  values.data() + (i + 1) * size);
  }
}

py::array_t<float> last_action(const PyPolicyMemory& self) {
  const std::size_t width = self.policy->output().size;
  auto out = result<float>(self.worlds.size(), width, self.one);
  float* to = out.mutable_data();
  for (const auto& world : self.worlds)
    for (const double v : world->raw) *to++ = static_cast<float>(v);
  return out;
}

std::vector<int> whole_numbers(const py::object& given) {
  try {
    return given.cast<std::vector<int>>();
  } catch (const py::cast_error&) {
    throw py::type_error("worlds: expected numbers of worlds, or an array of bool, given " +
                         type_name(given));
  }
}

void reset_memory(PyPolicyMemory& self, const py::object& worlds) {
  if (worlds.is_none()) {
    for (std::size_t i = 0; i < self.worlds.size(); ++i) self.reset(i);
    return;
  }
  // Numbers of worlds, or a truth for each, as VectorEnv gives for ended episodes.
  const py::array array = py::module_::import("numpy").attr("asarray")(worlds).cast<py::array>();
  if (array.dtype().kind() == 'b') {
    if (array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != self.worlds.size())
      throw py::value_error(fmt::format("worlds: expected {} truths", self.worlds.size()));
    const py::array_t<bool> flags(array);
    for (std::size_t i = 0; i < self.worlds.size(); ++i)
      if (flags.at(static_cast<py::ssize_t>(i))) self.reset(i);
    return;
  }
  std::vector<std::size_t> chosen;
  for (const int i : whole_numbers(worlds)) {
    if (i < 0 || static_cast<std::size_t>(i) >= self.worlds.size())
      throw py::index_error("there is no world " + std::to_string(i) + "; there are " +
                            std::to_string(self.worlds.size()));
    chosen.push_back(static_cast<std::size_t>(i));
  }
  for (const std::size_t i : chosen) self.reset(i);
}

std::vector<py::tuple> terms(const PyPolicy& self) {
  std::vector<py::tuple> out;
  std::size_t from = 0;
  if (!self.card) return out;
  for (const PolicyObservation& o : self.card->observations) {
    const std::size_t size = o.width(self.joints()) * static_cast<std::size_t>(o.history);
    out.push_back(py::make_tuple(to_string(o.term), from, from + size));
    from += size;
  }
  return out;
}

std::map<std::string, std::vector<std::int64_t>> shapes_of(const std::vector<NetworkPort>& ports) {
  std::map<std::string, std::vector<std::int64_t>> out;
  for (const NetworkPort& port : ports) out[port.name] = port.shape;
  return out;
}

}  // namespace

void bind_policy(py::module_& m) {
  py::class_<PyPolicyMemory, MemoryPtr>(m, "PolicyMemory",
                                        "What a policy remembers from one decision to the next: "
                                        "recurrent state, last action, histories, phase "
                                        "and the\nrandom numbers of its noise. Made by "
                                        "Policy.start(). Not for several threads at once.")
      .def("reset", &reset_memory, py::arg("worlds") = py::none(),
           "Forget, as at the start: all worlds, those of these numbers, or those where an array "
           "(worlds,) of "
           "bool is\ntrue, such as terminated | truncated of a VectorEnv. Raises IndexError, "
           "ValueError.")
      .def_property_readonly(
          "worlds",
          [](const PyPolicyMemory& s) -> py::object {
            if (s.one) return py::none();
            return py::int_(s.worlds.size());
          },
          "Number of worlds; None: made for a single one, whose arrays have no dimension of worlds")
      .def_property_readonly(
          "last_action", &last_action,
          "The network's last output: (actions,) or (worlds, actions) float32, a copy")
      .def_property(
          "state", &state_of, &set_state,
          "dict from the network's inputs to their recurrent state, (size,) or (worlds, size) "
          "float32, copies;\n{} of a network without one. Assigning sets the entries that are "
          "given.")
      .def("__repr__", [](const PyPolicyMemory& s) {
        return fmt::format("<PolicyMemory of {} worlds>", s.worlds.size());
      });
  py::class_<PyPolicy, PolicyPtr>(
      m, "Policy", R"(A trained policy: a card (*.policy.yaml), or a network alone (*.onnx).

    policy = cg.Policy("go1.policy.yaml")
    memory = policy.start()
    obs = policy.observe(policy.measure(sim.frame), memory, command=[0.5, 0, 0])
    targets = policy.targets(policy.act(obs, memory))

change: values in place of the card's, by key, in YAML: {"actions.scale": "0.4"}. A card with actions.delay has no
memory: delays of commands are those of a run.
One thread evaluates a row of observations, in a fixed order, in float32: the same row gives the same bits, alone or
among others. Several threads may call act() of one policy at once, with memories of their own.
Raises CompileError (.diagnostics): the card or its sizes are wrong; Error: the network cannot be read.)")
      .def(py::init(&load), py::arg("path"), py::kw_only(),
           py::arg("change") = std::map<std::string, std::string>())
      .def("check", held(&compared), py::arg("scene") = py::none(),
           "Compare the card with its robot, or with a Scene or scene file; list of Diagnostic, "
           "empty: it fits.")
      .def_property_readonly(
          "scene", held(&robot_scene),
          "The card's robot as a Scene; a URDF or MJCF is imported. Raises CompileError")
      .def_property_readonly(
          "path", [](const PolicyPtr& s) { return s->path; }, "Of the file")
      .def_property_readonly(
          "joints", [](const PolicyPtr& s) { return card_of(*s, "joints").joints; },
          "Names in the order of the actions")
      .def_property_readonly(
          "terms", held(&terms),
          "list of (name, first, behind): the observations' terms and their columns; [] of a "
          "network alone")
      .def_property_readonly(
          "observation_size", [](const PolicyPtr& s) { return s->input().size; },
          "Numbers that the network reads")
      .def_property_readonly(
          "action_size", [](const PolicyPtr& s) { return s->output().size; },
          "Numbers that it writes")
      .def_property_readonly(
          "measured_size",
          [](const PolicyPtr& s) { return kBase + 2 * card_of(*s, "measured_size").joints.size(); },
          "Numbers of a row of measure() and signals()")
      .def_property_readonly(
          "period", [](const PolicyPtr& s) { return card_of(*s, "period").period; },
          "Time between decisions [s]")
      .def_property_readonly(
          "command", [](const PolicyPtr& s) { return card_of(*s, "command").command; },
          "Of the card")
      .def_property_readonly(
          "inputs", [](const PolicyPtr& s) { return shapes_of(s->network->inputs()); },
          "Shapes of the network's inputs by name, for one world")
      .def_property_readonly(
          "outputs", [](const PolicyPtr& s) { return shapes_of(s->network->outputs()); },
          "Shapes of its outputs by name")
      .def_property_readonly(
          "metadata",
          [](const PolicyPtr& s) {
            py::dict out;
            for (const auto& [key, value] : s->network->metadata()) out[shown(key)] = shown(value);
            return out;
          },
          "Texts that the exporter wrote into the network, by key")
      .def("signals", held(&signals), py::arg("scene") = py::none(),
           "Signals that observe() needs, for the observations of a VectorEnv: position [m], roll, "
           "pitch, yaw "
           "[rad],\nvelocity [m/s] and angular velocity [rad/s] of the base in world axes, then "
           "positions and "
           "velocities of the joints.\nscene: a Scene or scene file with the robot; None: that of "
           "the card.")
      .def(
          "motors", held(&motors), py::arg("scene") = py::none(),
          "Dotted names of the motors in the order of the actions, for the actions of a VectorEnv.")
      .def("measure", held(&measure), py::arg("frame"),
           "The values of signals() in a frame: (12 + 2 joints,) float64. Raises CompileError: the "
           "scene lacks "
           "the robot.")
      .def("start", &make_memory, py::arg("worlds") = py::none(), py::kw_only(),
           py::arg("seeds") = std::vector<std::uint64_t>(),
           "A PolicyMemory for so many worlds; None: for one, whose arrays have no dimension of "
           "worlds.\n\n"
           "seeds: one per world, of the card's noise; by default 0, 1, 2, … Raises Error: a delay "
           "of the card is no\n"
           "whole number of decisions.")
      .def("observe", held(&observe), py::arg("measured"), py::arg("memory"),
           py::arg("command") = py::none(),
           "The network's input: (observation_size,) or (worlds, observation_size) float32. Once "
           "per decision.\n\n"
           "measured: (12 + 2 joints,) or (worlds, 12 + 2 joints), as signals() has them. command: "
           "(n,), or (worlds, "
           "n);\nNone: the card's. Raises ValueError: shapes; Error: a network alone.")
      .def("act", held(&act), py::arg("observations"), py::arg("memory") = py::none(),
           "Evaluate the network: (action_size,) or (worlds, action_size) float32.\n\n"
           "observations: (observation_size,) or (worlds, observation_size). memory: gets the "
           "recurrent state and "
           "the last\naction; needed where the network has a state. Raises ValueError: shapes; "
           "Error: the network "
           "fails.")
      .def("targets", held(&targets), py::arg("actions"),
           "offset + scale * action within its clip, for the motors: float64 of the same shape "
           "[rad, rad/s, N m "
           "or\nof sliders m, m/s, N].")
      .def("efforts", held(&efforts), py::arg("targets"), py::arg("measured"),
           "The drive law of a card with gains, kp (target - q) - kd q' within its effort limit [N "
           "m or N], for "
           "motors in\nmode torque; to be called in every step. Shapes as targets. Raises Error: "
           "the card has no "
           "gains.")
      .def("__repr__", [](const PolicyPtr& s) {
        return fmt::format("<Policy {}: {} observations, {} actions>", s->path, s->input().size,
                           s->output().size);
      });
}

}  // namespace cogrsim::python
