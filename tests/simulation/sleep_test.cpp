// The backend cogrsim's option `sleep`: what rests costs nothing, and wakes when it must.
#include <string>

#include "cogrsim/dsl/compiler.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

// Boxes that overhang by 2 cm each.
std::string tower() {
  std::string out;
  for (int i = 0; i < 6; ++i)
    out += "<box name=\"b" + std::to_string(i) + "\" size=\"10 10 10 cm\" mass=\"1 kg\" xyz=\"" +
           std::to_string(0.02 * (i % 3)) + " 0 " + std::to_string(0.05 + 0.1 * i) + "\"/>";
  return out;
}

// Comes down on the tower after 1.6 s.
const char* const kBall =
    "<sphere name=\"ball\" radius=\"5 cm\" mass=\"2 kg\" xyz=\"-4.8 0 0.3\" "
    "linear-velocity=\"3 0 8\"/>";

SceneModelPtr sleeper(const std::string& inside, bool sleep = true, int threads = 1) {
  const auto result = dsl::compile_text(
      "<scene><physics step=\"2 ms\"/><plane name=\"floor\"/>" + inside + "</scene>",
      "sleep.scene.xml");
  INFO(dsl::to_text(result.diagnostics));
  REQUIRE(result.model);
  SceneModel model = *result.model;
  model.physics.engine_options["cogrsim"]["sleep"] = sleep;
  model.physics.engine_options["cogrsim"]["threads"] = std::int64_t{threads};
  return std::make_shared<const SceneModel>(std::move(model));
}

std::unique_ptr<Simulation> run(const SceneModelPtr& model, double until) {
  auto simulation = simulate(model, "cogrsim");
  CHECK(simulation->run_until(until) == RunStatus::completed);
  return simulation;
}

std::size_t index_of(Simulation& s, const std::string& body) {
  const auto& bodies = s.frame()->model->bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i].name == body) return i;
  FAIL("no body " << body);
  return 0;
}

const Pose& pose(Simulation& s, const std::string& body) {
  return s.frame()->state.poses[index_of(s, body)];
}

// To the last bit, which nothing that is computed does.
bool stands_still(Simulation& s, const std::string& body) {
  const Twist& V = s.frame()->state.twists[index_of(s, body)];
  return V.linear.isZero(0.0) && V.angular.isZero(0.0);
}

}  // namespace

TEST_CASE("a tower that overhangs neither trembles nor walks", "[sleep]") {
  auto s = run(sleeper(tower(), false), 2.0);
  const Vec3 start = pose(*s, "b5").p;
  double fastest = 0.0;
  while (s->time() < 6.0) {
    s->step();
    fastest = std::max(fastest, s->frame()->state.twists[index_of(*s, "b5")].linear.norm());
  }
  // Its loads differ by their whole size from one side to the other: points that yielded to them would move at mm/s.
  CHECK(fastest < 1e-3);
  CHECK((pose(*s, "b5").p - start).norm() < 2e-4);
}

TEST_CASE("what rests sleeps, and contact wakes all that it holds", "[sleep]") {
  auto s = run(sleeper(tower() + kBall), 1.4);
  for (int i = 0; i < 6; ++i) CHECK(stands_still(*s, "b" + std::to_string(i)));
  CHECK_FALSE(stands_still(*s, "ball"));
  // What holds it is still reported.
  double load = 0.0;
  for (const Contact& c : s->frame()->contacts)
    if (c.body_a == 0 || c.body_b == 0) load += std::abs(c.force.z());
  CHECK(load == Approx(6 * 9.81).epsilon(1e-3));
  auto awake = run(sleeper(tower() + kBall, false), 1.4);
  CHECK((pose(*s, "b5").p - pose(*awake, "b5").p).norm() < 1e-4);
  bool woke = false;
  while (s->time() < 2.2) {
    s->step();
    woke = woke || (!stands_still(*s, "b0") && !stands_still(*s, "b5"));
  }
  CHECK(woke);
  // The ball hits it as if it had never slept: what differs is what 1e-4 m makes of an impact.
  CHECK(awake->run_until(1.9) == RunStatus::completed);
}

TEST_CASE("sleeping worlds have the same bits on any number of threads", "[sleep]") {
  std::string bodies = kBall;
  for (int i = 0; i < 60; ++i) {
    const int column = i % 10, row = i / 10;
    bodies += "<box name=\"c" + std::to_string(i) + "\" size=\"20 15 10 cm\" mass=\"1 kg\" xyz=\"" +
              std::to_string(0.4 * column) + " " + std::to_string(0.4 * row - 1.0) +
              " 0.2\" rpy=\"" + std::to_string(3 * i) + " 0 0 deg\"/>";
  }
  const auto alone = run(sleeper(bodies), 3.0), many = run(sleeper(bodies, true, 3), 3.0);
  CHECK(state_hash(many->frame()->state) == state_hash(alone->frame()->state));
  int still = 0;
  for (int i = 0; i < 60; ++i) still += stands_still(*alone, "c" + std::to_string(i));
  CHECK(still > 30);
}

TEST_CASE("a run resumes from what slept", "[sleep]") {
  auto s = run(sleeper(tower() + kBall), 1.2);
  const auto saved = s->save();
  REQUIRE(saved);
  CHECK(s->run_until(3.0) == RunStatus::completed);
  const auto end = state_hash(s->frame()->state);
  REQUIRE(s->restore(saved));
  CHECK(stands_still(*s, "b3"));
  CHECK(s->run_until(3.0) == RunStatus::completed);
  CHECK(state_hash(s->frame()->state) == end);
}

TEST_CASE("forces, changes and motion of what holds them wake bodies", "[sleep]") {
  const std::string lift =
      "<box name=\"lift\" kinematic=\"true\" size=\"1 1 0.1\" xyz=\"3 0 0.05\"/>"
      "<box name=\"load\" size=\"10 10 10 cm\" mass=\"1 kg\" xyz=\"3 0 0.15\"/>";
  auto s = run(sleeper(tower() + lift), 1.5);
  REQUIRE(stands_still(*s, "b0"));
  REQUIRE(stands_still(*s, "load"));
  SECTION("a force") {
    ApplyForce push;
    push.body = "b5";
    push.force = Vec3(0, 30, 0);
    push.duration = 0.1;
    s->send(push);
    s->run_until(s->time() + 0.1);
    CHECK(pose(*s, "b5").p.y() > 0.01);
    CHECK(stands_still(*s, "load"));
  }
  SECTION("a body removed below") {
    s->send(Remove{"b0"});
    s->run_until(s->time() + 0.1);
    // g t^2 / 2 = 49 mm.
    CHECK(pose(*s, "b5").p.z() == Approx(0.55 - 0.049).margin(2e-3));
  }
  SECTION("a support that starts to move") {
    SetKinematicTwist up;
    up.body = "lift";
    up.twist.linear = Vec3(0, 0, 0.1);
    s->send(up);
    s->run_until(s->time() + 1.0);
    CHECK(pose(*s, "load").p.z() == Approx(0.25).margin(1e-3));
    CHECK(stands_still(*s, "b0"));
    up.twist.linear.setZero();
    s->send(up);
    s->run_until(s->time() + 1.0);
    CHECK(stands_still(*s, "load"));
  }
  SECTION("a state that is set") {
    SetState set{s->frame()->state};
    set.state.poses[index_of(*s, "b5")].p.x() += 1.0;
    s->send(set);
    s->run_until(s->time() + 0.2);
    CHECK(pose(*s, "b5").p.z() < 0.5);
  }
}

TEST_CASE("a motor that holds sleeps with what it holds, and a command wakes it", "[sleep]") {
  const std::string arm = R"(
    <box name="arm" size="40 4 4 cm" mass="1 kg" xyz="0.2 0 1"/>
    <hinge name="shoulder" child="arm" xyz="-0.2 0 1" axis="0 1 0"/>
    <servo name="drive" joint="shoulder" kp="2000 N*m/rad" kd="200 N*m*s/rad" max-torque="50 N*m"/>)";
  auto s = run(sleeper(arm), 3.0);
  REQUIRE(stands_still(*s, "arm"));
  const double held = s->frame()->state.motor_efforts.at(0);
  CHECK(std::abs(held) == Approx(0.4 * 9.81).epsilon(1e-3));
  s->send(SetMotor{"drive", 0.5});
  s->run_until(s->time() + 1.0);
  CHECK(s->frame()->state.joint_positions.at(0) == Approx(0.5).margin(0.01));
}

TEST_CASE("what is meant to move slowly is not put to sleep", "[sleep]") {
  const std::string hand = R"(
    <box name="hand" size="40 4 4 cm" mass="1 kg" xyz="0 0 1"/>
    <hinge name="axle" child="hand" axis="0 0 1"/>
    <motor name="clock" joint="axle" mode="velocity" target="5e-5 rad/s" max-torque="50 N*m"/>
    <box name="belt" static="true" size="2 1 0.1" xyz="0 3 0.05" surface-velocity="5e-5 0 0"/>
    <box name="parcel" size="10 10 10 cm" mass="1 kg" xyz="0 3 0.15"/>)";
  auto s = run(sleeper(hand), 4.0);
  CHECK(s->frame()->state.joint_positions.at(0) == Approx(4.0 * 5e-5).epsilon(1e-3));
  CHECK(pose(*s, "parcel").p.x() == Approx(4.0 * 5e-5).epsilon(0.05));
}
