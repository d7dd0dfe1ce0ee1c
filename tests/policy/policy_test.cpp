// The controller in a run: what the network is given and what the motors do, computed here again.
#include <catch2/catch.hpp>

#include <cmath>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/simulation/simulation.h"
#include "cogrsim/simulation/snapshot_file.h"
#include "policy_support.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::Contains;
using Values = std::vector<double>;

namespace {

// The scene of a card that a controller in it names.
std::unique_ptr<Simulation> start(const PolicyFolder& folder, const std::string& card,
                                  const std::string& controller = "<controller plugin=\"policy\">",
                                  const std::string& card_name = "arm.policy.yaml") {
  std::string scene = kRobot;
  scene.insert(scene.find("  </assembly>"), "    <pose name=\"base\" on=\"trunk\"/>\n    " +
                                                controller + "<set card=\"" + card_name +
                                                "\"/></controller>\n");
  folder.write("run.scene.xml", scene);
  folder.write("arm.policy.yaml", card);
  const auto loader = std::make_shared<PluginLoader>();
  dsl::LoaderCatalog catalog(loader);
  dsl::CompileOptions options;
  options.plugins = &catalog;
  const dsl::CompileResult compiled = dsl::compile_file(folder.path("run.scene.xml"), options);
  INFO(dsl::to_text(compiled.diagnostics));
  REQUIRE(compiled.model);
  SimulationOptions settings;
  settings.backend = "cogrsim";
  auto made = Simulation::create(compiled.model, settings, loader);
  if (!made) throw std::runtime_error(dsl::to_text(made.error()));
  return std::move(*made);
}

std::string with(const std::string& from, const std::string& to) {
  std::string card = kCard;
  card.replace(card.find(from), from.size(), to);
  return card;
}

// The network's input of the test's card, from the state before the step.
Values observed(const Frame& frame, const Values& last, double phase) {
  const Pose& base = frame.state.poses[1];  // [0] is the floor
  const Twist& twist = frame.state.twists[1];
  REQUIRE(frame.model->bodies[1].name == "bot.trunk");
  const Vec3 v = 2.0 * (base.q.conjugate() * twist.linear), w = twist.angular;
  const Vec3 down = base.q.conjugate() * Vec3(0, 0, -1);
  const Values& q = frame.state.joint_positions;
  const Values& u = frame.state.joint_velocities;
  const double angle = 2 * 3.141592653589793 * (phase + 0.25);
  return {v.x(),
          v.y(),
          v.z(),
          w.x(),
          w.y(),
          w.z(),
          down.x(),
          down.y(),
          down.z(),
          0.5 * (q[0] - 0.1),
          0.5 * (q[1] + 0.2),
          u[0],
          u[1],
          last[0],
          last[1],
          2 * 0.5,
          0.0,
          0.25 * 0.1,
          std::cos(angle),
          std::sin(angle)};
}

}  // namespace

TEST_CASE("a policy is given what its card says, and drives in every step", "[run]") {
  const PolicyFolder folder;
  const auto simulation = start(folder, kCard);
  const std::vector<float> w = arm_weights();
  Values last(2, 0.0), target(2, 0.0);
  double phase = 0.0;
  for (int step = 0; step < 500; ++step) {
    const FramePtr before = simulation->frame();
    if (step % 5 == 0) {
      const Values in = observed(*before, last, phase);
      for (std::size_t i = 0; i < 2; ++i) {
        double sum = 0.0;
        for (std::size_t k = 0; k < in.size(); ++k)
          sum += static_cast<double>(w[20 * i + k]) * in[k];
        last[i] = sum;
        target[i] = (i == 0 ? 0.1 : -0.2) + 0.5 * sum;
      }
      phase += 0.01 * 1.25;
    }
    REQUIRE(simulation->step() == RunStatus::running);
    const FramePtr after = simulation->frame();
    for (std::size_t i = 0; i < 2; ++i) {
      INFO(step << " " << i);
      const double law = 40 * (target[i] - before->state.joint_positions[i]) -
                         2 * before->state.joint_velocities[i];
      const double torque = std::max(-20.0, std::min(20.0, law));  // of the motor
      // float32 in the network: 20 products of the size 1 err by 1e-6, times scale and kp.
      CHECK(after->state.motor_efforts[i] == Approx(torque).margin(1e-4));
    }
  }
}

TEST_CASE("a policy's torque is what the curves of its motors leave", "[run]") {
  const PolicyFolder folder;
  const auto simulation =
      start(folder, with("kp: 40, kd: 2",
                         "kp: 400, kd: 2, effort-limit: 2 N*m, stall-effort: 3 100 N*m, "
                         "no-load-speed: 2 1000 rad/s"));
  int fast = 0, braking = 0;
  for (int step = 0; step < 500; ++step) {
    const FramePtr before = simulation->frame();
    REQUIRE(simulation->step() == RunStatus::running);
    const double v = before->state.joint_velocities[0];
    const double effort = simulation->frame()->state.motor_efforts[0];
    const double left = std::max(0.0, std::min(2.0, 3.0 * (1.0 - std::abs(v) / 2.0)));
    INFO(step << " " << v << " " << effort);
    CHECK(std::abs(effort) <= 2.0 + 1e-6);
    if (effort * v > 0.0) CHECK(std::abs(effort) <= left + 1e-6);
    // The curve is what limits, and only on the side of the motion.
    fast += effort * v > 0.0 && left < 1.9 && std::abs(effort) > left - 1e-6 ? 1 : 0;
    braking += effort * v < 0.0 && std::abs(effort) > left + 0.05 ? 1 : 0;
  }
  CHECK(fast > 0);
  CHECK(braking > 0);
}

TEST_CASE("a delay of the actions holds targets back by that time", "[run]") {
  const PolicyFolder folder;
  // 3 steps of the physics; the network is constant.
  OnnxWriter writer;
  writer.input("obs", {1, 20})
      .output("actions", {1, 2})
      .constant("w", {2, 20}, std::vector<float>(40, 0.0f));
  folder.write("net.onnx", writer.constant("b", {2}, {0.4f, 0.0f})
                               .node("Gemm", {"obs", "w", "b"}, {"actions"}, {{"transB", 1}})
                               .bytes());
  const auto simulation = start(folder, with("kp: 40, kd: 2", "kp: 40, kd: 0, delay: 6 ms"));
  for (int step = 0; step < 5; ++step) {
    const double q = simulation->frame()->state.joint_positions[0];
    REQUIRE(simulation->step() == RunStatus::running);
    const double target = step < 3 ? 0.1 : 0.1 + 0.5 * 0.4;
    CHECK(simulation->frame()->state.motor_efforts[0] == Approx(40 * (target - q)).margin(1e-5));
  }
}

TEST_CASE("terms are clipped, delayed and stacked, the oldest first", "[run]") {
  const PolicyFolder folder;
  // The torque is the first value of a stack of three decisions, 2 steps late.
  OnnxWriter writer;
  writer.input("obs", {1, 6}).output("actions", {1, 2});
  std::vector<float> weights(12, 0.0f);
  weights[0] = 1.0f;      // the oldest of the first joint
  weights[6 + 5] = 1.0f;  // the newest of the second
  folder.write("net.onnx", writer.constant("w", {2, 6}, weights)
                               .node("Gemm", {"obs", "w"}, {"actions"}, {{"transB", 1}})
                               .bytes());
  std::string card = kCard;
  card.erase(card.find("  - base-linear"), card.find("actions:") - card.find("  - base-linear"));
  card.replace(
      card.find("actions:"), std::string::npos,
      "  - joint-positions: {relative: false, history: 3, delay: 4 ms, clip: 0.2, scale: 10}\n"
      "actions: {kind: torque, scale: 1}\n");
  const auto simulation = start(folder, card);
  std::vector<Values> seen;
  for (int step = 0; step < 60; ++step) {
    seen.push_back(simulation->frame()->state.joint_positions);
    REQUIRE(simulation->step() == RunStatus::running);
    if (step % 5 != 0) continue;
    const auto value = [&](int at, std::size_t joint) {
      const double q = seen[static_cast<std::size_t>(std::max(0, at))][joint];
      return 10 * std::max(-0.2, std::min(0.2, q));
    };
    const FramePtr after = simulation->frame();
    CHECK(after->state.motor_efforts[0] == Approx(value(step - 2 - 10, 0)).margin(1e-5));
    CHECK(after->state.motor_efforts[1] == Approx(value(step - 2, 1)).margin(1e-5));
  }
}

TEST_CASE("a run continues from a snapshot with the policy's memory", "[run]") {
  const PolicyFolder folder;
  OnnxWriter writer;
  std::vector<float> w(4 * 4 * 20), r(4 * 4 * 4), b(2 * 16);
  std::mt19937 source(5);
  std::uniform_real_distribution<float> range(-0.5f, 0.5f);
  for (auto* list : {&w, &r, &b})
    for (float& v : *list) v = range(source);
  writer.input("obs", {1, 1, 20}).input("h", {1, 1, 4}).input("c", {1, 1, 4});
  writer.constant("W", {1, 16, 20}, w)
      .constant("R", {1, 16, 4}, r)
      .constant("B", {1, 32}, b)
      .integers("n", {2});
  writer.integers("shape", {1, 4});
  writer.node("LSTM", {"obs", "W", "R", "B", "", "h", "c"}, {"", "h2", "c2"}, {{"hidden_size", 4}});
  writer.node("Reshape", {"h2", "shape"}, {"row"})
      .node("Split", {"row"}, {"actions", "rest"}, {{"axis", 1}});
  writer.output("actions", {1, 2}).output("h2", {1, 1, 4}).output("c2", {1, 1, 4});
  folder.write("net.onnx", writer.bytes());
  std::string card =
      with("- joint-velocities", "- joint-velocities: {noise: {uniform: 0.1}, delay: 6 ms}");
  card += "state: {h: h2, c: c2}\n";
  const auto first = start(folder, card);
  // Between two decisions, and with old values under way.
  REQUIRE(first->run_until(0.173) == RunStatus::completed);
  REQUIRE(write_snapshot(*first, folder.path("a.snap")));
  REQUIRE(first->run_until(0.6) == RunStatus::completed);
  const auto snapshot = SnapshotFile::read(folder.path("a.snap"));
  REQUIRE(snapshot);
  SimulationOptions settings;
  settings.backend = "cogrsim";
  std::vector<FramePtr> ends;
  for (int i = 0; i < 2; ++i) {
    const auto resumed =
        resume(*snapshot, first->model(), settings, std::make_shared<PluginLoader>());
    REQUIRE(resumed);
    CHECK(resumed->notes.empty());
    REQUIRE(resumed->simulation->run_until(0.6) == RunStatus::completed);
    ends.push_back(resumed->simulation->frame());
  }
  CHECK(ends[0]->state.joint_positions == ends[1]->state.joint_positions);
  CHECK(ends[0]->state.motor_efforts == ends[1]->state.motor_efforts);
  // The engine starts its solver afresh, which leaves 1e-6 rad after 0.4 s; a policy without its
  // states, noise or delayed values would be some 0.01 rad away.
  for (std::size_t i = 0; i < 2; ++i)
    CHECK(ends[0]->state.joint_positions[i] ==
          Approx(first->frame()->state.joint_positions[i]).margin(1e-5));
}

TEST_CASE("what is asked of a policy can be changed within its card's limits", "[run]") {
  const PolicyFolder folder;
  const std::string limits =
      "command-limits: [[-1, 0.6], 0.5, 1]\n"
      "command-names: {forward: m/s, left: m/s, turn: ~}\n";
  const auto steered = start(folder, kCard + limits);
  const auto inputs = steered->controller_inputs();
  REQUIRE(inputs.size() == 1);
  REQUIRE(inputs[0].inputs.size() == 3);
  CHECK((inputs[0].inputs[0].name == "forward" && inputs[0].inputs[0].unit == "m/s"));
  CHECK((inputs[0].inputs[2].name == "turn" && inputs[0].inputs[2].unit.empty()));
  CHECK(inputs[0].inputs[1].lower == -0.5);
  CHECK(inputs[0].inputs[2].value == 0.1);
  const auto ask = [&](const char* input, double value) {
    steered->send(SetInput{inputs[0].controller, input, value});
  };
  ask("forward", -0.75);
  ask("turn", 1.0);
  ask("left", 0.7);  // refused
  const auto other = start(folder, with("command: 0.5 0 0.1", "command: -0.75 0 1"));
  const auto same = [&] {
    return steered->frame()->state.joint_positions == other->frame()->state.joint_positions;
  };
  REQUIRE(steered->run_until(0.15) == RunStatus::completed);
  REQUIRE(other->run_until(0.15) == RunStatus::completed);
  CHECK(same());
  CHECK_THAT(steered->messages().back().message, Contains("0.7 is not from -0.5 to 0.5"));
  ask("forward", 0.6);
  REQUIRE(steered->run_until(0.3) == RunStatus::completed);
  REQUIRE(other->run_until(0.3) == RunStatus::completed);
  CHECK(!same());
  // Numbers of which the card does not say what they are have no names.
  const auto unnamed = start(folder, kCard + std::string("command-limits: [1, 1, 1]\n"));
  CHECK(unnamed->controller_inputs()[0].inputs[1].name == "command 2");
  CHECK(unnamed->controller_inputs()[0].inputs[1].unit.empty());
  // Without limits there is nothing to set.
  CHECK(other->controller_inputs().empty());
}

TEST_CASE("a policy that does not fit its scene does not start", "[run]") {
  const PolicyFolder folder;
  CHECK_THROWS_WITH(start(folder, with("[elbow, wrist]", "[elbow, wirst]")),
                    Contains("wirst") && Contains("bot.wrist"));
  CHECK_THROWS_WITH(start(folder, with("  - joint-velocities\n", "")),
                    Contains("18") && Contains("20"));
  CHECK_THROWS_WITH(start(folder, with("kp: 40, kd: 2", "")), Contains("torque"));
  CHECK_THROWS_WITH(start(folder, with("rate: 100 Hz", "")), Contains("'rate' is missing"));
  for (const char* elsewhere : {"/etc/passwd", "../arm.policy.yaml"})
    CHECK_THROWS_WITH(start(folder, kCard, "<controller plugin=\"policy\">", elsewhere),
                      Contains("outside the scene's folder"));
}

TEST_CASE("a drive law that would run once per decision is refused", "[run]") {
  const PolicyFolder folder;
  const auto simulation =
      start(folder, kCard, "<controller plugin=\"policy\" rate=\"100 Hz\" on-fault=\"end-run\">");
  CHECK(simulation->run_until(0.1) == RunStatus::fault);
  REQUIRE_FALSE(simulation->messages().empty());
  CHECK_THAT(simulation->messages().front().message, Contains("once per decision"));
}
