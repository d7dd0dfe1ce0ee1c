// Conditions, distances between surfaces, and the other signals that tests are made of.
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"
#include "cogrsim/signals/condition.h"

using namespace cogrsim;

namespace {

constexpr double kPi = 3.14159265358979323846;

Pose at(double x, double y = 0, double z = 0) { return {Vec3(x, y, z), Quat(1, 0, 0, 0)}; }
Pose turned(const Vec3& p, double angle, const Vec3& axis) {
  return {p, Quat(Eigen::AngleAxisd(angle, axis.normalized()))};
}

struct World {
  SceneModelPtr model;
  Frame frame;

  explicit World(ModelBuilder& builder) {
    model = builder.build();
    frame.model = model;
    for (const Body& body : model->bodies) frame.state.poses.push_back(body.X_WB);
    frame.state.twists.resize(model->bodies.size());
    frame.state.joint_positions.resize(model->joint_positions);
  }
  SignalScope scope() const { return {*model, built_in_channels(*model), {}}; }
  double value(const std::string& text) const {
    const auto signal = Signal::parse(scope(), text);
    INFO(text << ": " << (signal ? "" : signal.error().text()));
    REQUIRE(signal);
    return signal->evaluate(frame);
  }
  Truth truth(const std::string& text) const {
    const auto condition = Condition::parse(scope(), text);
    INFO(text << ": " << (condition ? "" : condition.error().text()));
    REQUIRE(condition);
    // The text with full names means the same.
    const auto again = Condition::parse(scope(), condition->text());
    REQUIRE(again);
    CHECK(again->text() == condition->text());
    CHECK(again->evaluate(frame) == condition->evaluate(frame));
    return condition->evaluate(frame);
  }
  std::string refused(const std::string& text) const {
    const auto condition = Condition::parse(scope(), text);
    INFO(text);
    REQUIRE_FALSE(condition);
    return condition.error().text();
  }
};

ModelBuilder two_bodies() {
  ModelBuilder b("conditions");
  b.box("a", Vec3(1, 1, 1), 2.0, turned(Vec3(0, 0, 2), 0.2, Vec3::UnitX()));
  b.sphere("b", 0.5, 1.0, at(3, 0, 2));
  SensorModel mute;
  mute.name = "mute";
  mute.type = "pose";
  mute.body = 0;
  b.model.sensors.push_back(mute);
  return b;
}

}  // namespace

TEST_CASE("conditions compare signals with numbers that have units", "[condition]") {
  auto b = two_bodies();
  World w(b);
  w.frame.time = 2.0;
  const auto yes = [&](const std::string& text) { CHECK(w.truth(text) == Truth::yes); };
  const auto no = [&](const std::string& text) { CHECK(w.truth(text) == Truth::no); };
  yes("time ge 2 s");
  yes("time ge 2000 ms and time le 2");
  no("time gt 2");
  no("time < 2");
  yes("time <= 2");
  yes("time == 2");
  no("time != 2");
  no("time ne 2");
  yes("a.roll lt 12 deg");
  no("a.roll lt 11 deg");
  yes("abs(a.roll - 0.2 rad) lt 0.001 deg");
  yes("a.roll gt 0");  // zero needs no unit
  yes("-3 m le a.x - b.x and a.x - b.x le -3 m + 1 um");
  yes("1 m lt b.x");
  yes("not time lt 2");
  yes("not (time lt 2 or b.x lt 300 cm)");
  no("not not time lt 2");
  yes("time lt 2 or b.x eq 3 and a.x eq 0");
  no("(time lt 2 or b.x eq 3) and a.x eq 1");
  yes("a.x / 1 s lt 1 km/h");
  yes("b.x * b.x eq 9 m^2");
  yes("origin_distance(a, b) eq 3");
  const auto condition = Condition::parse(w.scope(), "a.x lt b.x or time lt 3 s and a.x ge 0");
  REQUIRE(condition);
  REQUIRE(condition->signals().size() == 3);  // each once
  CHECK(condition->signals()[0].text() == "a.x");
  CHECK(condition->signals()[2].text() == "time");
}

TEST_CASE("a signal's text has the brackets it needs, and no others", "[signal]") {
  auto b = two_bodies();
  World w(b);
  w.frame.time = 2.0;
  const auto text_of = [&](const std::string& text) {
    const auto signal = Signal::parse(w.scope(), text);
    INFO(text << ": " << (signal ? "" : signal.error().text()));
    REQUIRE(signal);
    // What is read of the text has the same value and the same text.
    const auto again = Signal::parse(w.scope(), signal->text());
    REQUIRE(again);
    CHECK(again->text() == signal->text());
    CHECK(again->evaluate(w.frame) == signal->evaluate(w.frame));
    return signal->text();
  };
  CHECK(text_of("a.z*b.x/2") == "a.z * b.x / 2");
  CHECK(text_of("a.z*(b.x/2)") == "a.z * (b.x / 2)");
  CHECK(text_of("(a.z + b.x)*2") == "(a.z + b.x) * 2");
  CHECK(text_of("a.z - (b.x - 2 m)") == "a.z - (b.x - 2 m)");
  CHECK(text_of("((a.z) - b.x) - 2 m") == "a.z - b.x - 2 m");
  CHECK(text_of("-(a.z*b.x)") == "-(a.z * b.x)");
  CHECK(text_of("-a.z*-(b.x)") == "-a.z * -b.x");
  // "2 m*s" would be a unit of its own
  CHECK(text_of("(2 m)*(3 s)/time") == "2 m * 3 s / time");
  CHECK(text_of("--(-a.z)") == "---a.z");

  // As deep as may be written is not too deep when it is read again.
  text_of(std::string(49, '-') + "a.z");
  std::string chain = "a.z", right = "b.x";
  for (int i = 0; i < 200; ++i) chain += "/2";
  for (int i = 0; i < 49; ++i) right = "a.z - (2*" + right + ")";
  text_of(chain);
  text_of(right);
  std::string nots, deep = "time lt 1 and a.x lt 1 or b.x lt 1";
  for (int i = 0; i < 200; ++i) nots += "not ";
  for (int i = 0; i < 49; ++i) deep = "a.z lt 1 or not (" + deep + ")";
  CHECK(w.truth(nots + "time lt 3") == Truth::yes);
  w.truth(nots + "(" + nots + "time lt 3)");
  w.truth(deep);
}

TEST_CASE("a condition without a value is unknown and never holds", "[condition]") {
  auto b = two_bodies();
  const World w(b);
  // The sensor has not read yet.
  const std::string unknown = "mute.x lt 1 m";
  for (const std::string& text :
       {unknown, "not " + unknown, unknown + " and time ge 0", unknown + " or time lt 0"})
    CHECK(w.truth(text) == Truth::unknown);
  CHECK(w.truth(unknown + " and time lt 0") == Truth::no);
  CHECK(w.truth(unknown + " or time ge 0") == Truth::yes);
  CHECK_FALSE(Condition().holds(w.frame));
  CHECK(Condition().evaluate(w.frame) == Truth::unknown);
}

TEST_CASE("wrong conditions are refused with a remedy", "[condition]") {
  auto b = two_bodies();
  const World w(b);
  const auto says = [&](const std::string& text, const std::string& part) {
    const std::string message = w.refused(text);
    INFO(text << " -> " << message);
    CHECK(message.find(part) != std::string::npos);
  };
  says("", "the condition is empty");
  says("a.roll lt 10", "write 10 deg or 10 rad");
  says("a.x lt 10 deg", "'a.x' is a length and '10 deg' is an angle");
  says("a.x lt", "something is missing beside 'lt'");
  says("time lt 2 and", "something is missing beside 'and'");
  says("or time lt 2", "something is missing beside 'or'");
  says("not", "something is missing after 'not'");
  says("a.x", "'a.x' is a length, not a condition");
  says("a.x = 2", "write eq or ==");
  says("! a.x lt 2", "write not");
  says("1 lt a.x lt 2", "more than two values");
  says("1 lt 2", "are two numbers");
  says("a.x lt 3 furlong", "there is no unit 'furlong'");
  says("a.x lt 3 metre", "did you mean 3 m?");
  says("a.y lt c.x", "there is nothing named 'c'");
  says("(a.x lt 3", "not closed");
  says("a.x lt 3 robots", "there is no unit");
  says(std::string(60, '(') + "time lt 2" + std::string(60, ')'), "50 are the limit");
  says(std::string(5000, 'x'), "too long");
  says("inside(a, zone)", "there is no region 'zone'");
  says("event(entered)", "did you mean 'enter'?");
  says("open(gate) lt 1", "there is no door 'gate'");
  says("mass(a, b) lt 1 kg", "write mass(a)");
}

TEST_CASE("the distance between surfaces follows closed forms", "[distance]") {
  ModelBuilder b("distances");
  b.box("cube", Vec3(2, 2, 2), 1.0, at(0));
  b.box("beside", Vec3(2, 2, 2), 1.0, at(3.5, 1, 0));
  // Stands on an edge: half a diagonal reaches towards the cube.
  b.box("edge", Vec3(2, 2, 2), 1.0, turned(Vec3(0, 5, 0), kPi / 4, Vec3::UnitX()));
  // Two edges crosswise: one along x at z = 1, this one along y.
  b.box("roof", Vec3(2, 2, 2), 1.0, turned(Vec3(0, 0, 6), kPi / 4, Vec3::UnitY()));
  b.sphere("ball", 0.5, 1.0, at(-4, 0, 0));
  b.sphere("corner", 0.5, 1.0, at(-4, -4, -4));
  b.sphere("touching", 0.5, 1.0, at(0, 0, -1.5));
  b.sphere("within", 0.5, 1.0, at(0.2, 0.3, 0.1));
  b.plane("floor", {Vec3(0, 0, -10), Quat(1, 0, 0, 0)});
  const World w(b);
  // A box's faces, edges and corners; errors are those of rounding and of gjk.h, below 1e-9.
  const double tolerance = 1e-9;
  const auto is = [&](const std::string& text, double value) {
    INFO(text);
    CHECK(w.value(text) == Approx(value).margin(tolerance).epsilon(0));
  };
  is("distance(cube, beside)", 1.5);
  is("distance(beside, cube)", 1.5);
  is("distance(cube, edge)", 5 - 1 - std::sqrt(2.0));
  is("distance(cube, roof)", 6 - 1 - std::sqrt(2.0));
  is("distance(cube, ball)", 2.5);
  is("distance(cube, corner)", 3 * std::sqrt(3.0) - 0.5);
  is("distance(cube, touching)", 0.0);
  is("distance(cube, within)", 0.0);
  is("distance(floor, cube)", 9.0);
  is("distance(roof, floor)", 16 - std::sqrt(2.0));
  is("distance(ball, floor)", 9.5);
}

namespace {

// Nearest points by projecting to and fro, which converges for convex sets (Cheney and Goldstein
// 1959): slow, but it shares nothing with the algorithm under test.
Vec3 into_cylinder(const Pose& X, double radius, double half, const Vec3& p) {
  Vec3 local = X.inverse() * p;
  const double r = std::hypot(local.x(), local.y());
  if (r > radius) local.head<2>() *= radius / r;
  local.z() = std::clamp(local.z(), -half, half);
  return X * local;
}
Vec3 into_box(const Pose& X, const Vec3& half, const Vec3& p) {
  return X * Vec3((X.inverse() * p).cwiseMax(-half).cwiseMin(half));
}

}  // namespace

TEST_CASE("distances of turned boxes and cylinders agree with projections to and fro",
          "[distance]") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1), size(0.2, 1.5);
  const auto pose = [&](double far) {
    const Vec3 p(far + unit(random), unit(random), unit(random));
    return turned(p, 3 * unit(random), Vec3(unit(random), unit(random), 1.5 + unit(random)));
  };
  int different = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Pose A = pose(0), B = pose(2.5);
    const double ra = size(random), rb = size(random), la = size(random), lb = size(random);
    const bool boxes = trial % 3 == 0, mixed = trial % 3 == 1;
    ModelBuilder b("pair");
    const Vec3 box_a(ra, la, 0.7), box_b(rb, 0.5, lb);
    if (boxes)
      b.box("a", box_a, 1.0, A);
    else
      b.cylinder("a", ra, la, 1.0, A);
    if (boxes || mixed)
      b.box("b", box_b, 1.0, B);
    else
      b.cylinder("b", rb, lb, 1.0, B);
    const World w(b);
    Vec3 p = A.p, q = B.p;
    for (int i = 0; i < 40000; ++i) {
      p = boxes ? into_box(A, 0.5 * box_a, q) : into_cylinder(A, ra, 0.5 * la, q);
      q = boxes || mixed ? into_box(B, 0.5 * box_b, p) : into_cylinder(B, rb, 0.5 * lb, p);
    }
    const double expected = (p - q).norm(), found = w.value("distance(a, b)");
    INFO("trial " << trial << " expected " << expected << " found " << found);
    if (expected < 1e-3) {
      CHECK(found < 2e-3);  // to and fro is slow where they meet
      continue;
    }
    ++different;
    // Projections come from above and have stopped within some 1e-7 where faces are askew.
    CHECK(found <= expected + 1e-9);
    CHECK(found >= expected - 1e-6);
  }
  CHECK(different > 30);
}

TEST_CASE("capsules and hulls and meshes and heightmaps have distances too", "[distance]") {
  ModelBuilder b("shapes");
  b.capsule("a", 0.2, 2.0, 1.0, at(0, 0, 0));
  b.capsule("b", 0.3, 2.0, 1.0, turned(Vec3(2, 0, 0), kPi / 2, Vec3::UnitX()));
  TriangleMesh tetrahedron;
  tetrahedron.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tetrahedron.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const int mesh = static_cast<int>(b.model.meshes.size());
  b.model.meshes.push_back(std::make_shared<const TriangleMesh>(tetrahedron));
  HeightGrid grid;
  grid.columns = grid.rows = 3;
  grid.size_x = grid.size_y = 4;
  grid.heights = {0, 0, 0, 0, 1, 0, 0, 0, 0};
  b.model.heightmaps.push_back(std::make_shared<const HeightGrid>(grid));
  const auto shaped = [&](const char* name, ShapeType type, const Pose& X) {
    const int index = b.box(name, Vec3::Ones(), 1.0, X);
    Shape& shape = b.model.bodies[index].shapes[0];
    shape.type = type;
    shape.mesh = mesh;
    shape.heightmap = 0;
  };
  shaped("hull", ShapeType::convex_mesh, at(10, 0, 0));
  shaped("skin", ShapeType::mesh, at(10, 5, 0));
  shaped("skin2", ShapeType::mesh, at(10, 8, 0));
  shaped("hill", ShapeType::heightmap, at(0, 20, 0));
  b.sphere("ball", 0.5, 1.0, at(11, 1, 1));
  b.sphere("ball2", 0.5, 1.0, at(11, 6, 1));
  b.sphere("speck", 0.01, 1.0, at(10.1, 5.1, 0.1));
  b.sphere("above", 0.5, 1.0, at(0, 20, 3));
  b.box("plank", Vec3(10, 0.5, 0.2), 1.0, at(0, 20, 2));
  b.plane("floor", {Vec3(0, 0, -3), Quat(1, 0, 0, 0)});
  const World w(b);
  const auto is = [&](const std::string& text, double value) {
    INFO(text);
    CHECK(w.value(text) == Approx(value).margin(1e-9).epsilon(0));
  };
  is("distance(a, b)", 2 - 0.5);
  const double from_face = 2 / std::sqrt(3.0) - 0.5;  // (1, 1, 1) to x + y + z = 1
  is("distance(hull, ball)", from_face);
  is("distance(skin, ball2)", from_face);
  is("distance(skin, speck)", 0.1 - 0.01);  // a mesh has no inside
  is("distance(skin, skin2)", 2.0);
  is("distance(hull, skin)", 4.0);
  is("distance(hill, above)", 1.5);
  is("distance(hill, plank)", 0.9);
  is("distance(hill, floor)", 3.0);
  is("distance(floor, skin)", 3.0);
  is("distance(a, floor)", 3 - 1.2);
}

TEST_CASE("assemblies count with all their bodies and frames as points", "[distance]") {
  ModelBuilder b("assemblies");
  const int trunk = b.box("robot.trunk", Vec3(1, 1, 1), 1.5, at(0));
  const int arm = b.sphere("robot.arm", 0.25, 0.5, at(1, 0, 0));
  b.assembly("robot", {trunk, arm});
  b.box("wall", Vec3(0.2, 4, 4), 1.0, at(2, 0, 0));
  NamedFrame tip;
  tip.name = "tip";
  tip.body = trunk;
  tip.X_BF = at(0.5, 0, 1);
  b.model.frames.push_back(tip);
  World w(b);
  CHECK(w.value("distance(robot, wall)") == Approx(2 - 0.1 - 1.25));
  CHECK(w.value("distance(robot.trunk, wall)") == Approx(2 - 0.1 - 0.5));
  CHECK(w.value("distance(tip, wall)") == Approx(1.4));
  CHECK(w.value("distance(tip, robot.trunk)") == Approx(0.5));
  CHECK(w.value("mass(robot)") == Approx(2.0));
  CHECK(w.truth("mass(robot) eq 2 kg") == Truth::yes);
  const auto common = Signal::parse(w.scope(), "distance(robot, robot.arm)");
  REQUIRE_FALSE(common);
  CHECK(common.error().message == "'robot' and 'robot.arm' have body 'robot.arm' in common");
  // Removed bodies are left out; without any there is no distance.
  auto changed = std::make_shared<SceneModel>(*w.model);
  changed->bodies[1].removed = true;
  const auto distance = Signal::parse(w.scope(), "distance(robot, wall)");
  w.frame.model = changed;
  CHECK(distance->evaluate(w.frame) == Approx(1.4));
  changed->bodies[0].removed = true;
  CHECK(std::isnan(distance->evaluate(w.frame)));
}

TEST_CASE("regions and events and doors and controllers have signals", "[signal]") {
  ModelBuilder b("events");
  b.box("bot", Vec3(1, 1, 1), 1.0, at(0, 0, 0));
  const int leaf = b.box("leaf", Vec3(1, 1, 1), 1.0, at(5, 0, 0));
  const int slide = b.joint("slide", JointType::slider, kWorld, leaf, at(5, 0, 0));
  const int motor = b.motor("opener", slide, MotorMode::position);
  RegionModel box, ball;
  box.name = "goal";
  box.X_BR = turned(Vec3(1, 0, 0), kPi / 4, Vec3::UnitZ());
  box.size = Vec3(2, 2, 2);
  ball.name = "halo";
  ball.type = RegionModel::Type::sphere;
  ball.body = 0;
  ball.radius = 2;
  b.model.regions = {box, ball};
  DoorModel door;
  door.name = "gate";
  door.motor = motor;
  door.closed = 0.1;
  door.open = -0.9;
  b.model.doors = {door};
  ControllerModel controller;
  controller.name = "bot.driver";
  controller.outputs = {{"cost", "m"}, {"state", "1"}};
  b.model.controllers = {controller};
  controller.name = "referee";
  controller.outputs.clear();  // its plugin is not known here
  b.model.supervisors = {controller};
  World w(b);
  // The turned box reaches sqrt 2 along x from its middle: to 1 - 1.414 = -0.414.
  CHECK(w.truth("inside(bot, goal)") == Truth::yes);
  w.frame.state.poses[0].p.x() = -0.41;
  CHECK(w.truth("inside(bot, goal)") == Truth::yes);
  w.frame.state.poses[0].p.x() = -0.42;
  CHECK(w.truth("inside(bot, goal)") == Truth::no);
  CHECK(w.truth("inside(leaf, halo)") == Truth::no);
  w.frame.state.poses[0].p.x() = 3.1;  // the halo comes along
  CHECK(w.truth("inside(leaf, halo)") == Truth::yes);

  w.frame.state.joint_positions[0] = 0.1;
  CHECK(w.value("open(gate)") == 0.0);
  w.frame.state.joint_positions[0] = -0.4;
  CHECK(w.value("open(gate)") == Approx(0.5));
  w.frame.state.joint_positions[0] = -1.0;
  CHECK(w.value("open(gate)") == 1.0);

  CHECK(w.truth("event(enter)") == Truth::no);
  w.frame.events = {{0.0, "enter", "goal", "", "bot"}, {0.0, "raised", "alarm", "", ""}};
  CHECK(w.truth("event(enter)") == Truth::yes);
  CHECK(w.truth("event(enter, goal, bot)") == Truth::yes);
  CHECK(w.truth("event(enter, halo)") == Truth::no);
  CHECK(w.truth("event(enter, goal, leaf)") == Truth::no);
  CHECK(w.truth("event(raised, alarm)") == Truth::yes);

  CHECK(w.truth("bot.driver.cost lt 3 m") == Truth::unknown);
  w.frame.controller_outputs = {{2.5, 7}};
  CHECK(w.truth("bot.driver.cost lt 3 m") == Truth::yes);
  CHECK(w.value("bot.driver.state") == 7);
  CHECK(w.refused("bot.driver.cots lt 3 m").find("did you mean 'cost'?") != std::string::npos);
  CHECK(w.refused("bot.driver.cost lt 3 s").find("is a length and") != std::string::npos);
  // Taken on trust, and found once a run knows it.
  CHECK(w.truth("referee.score gt 3") == Truth::unknown);
  auto known = std::make_shared<SceneModel>(*w.model);
  known->supervisors[0].outputs = {{"score", "1"}};
  const auto score = Condition::parse(w.scope(), "referee.score gt 3");
  w.frame.model = known;
  w.frame.supervisor_outputs = {{4}};
  CHECK(score->holds(w.frame));
}

TEST_CASE("elements added during the run are looked up by name if the scope allows it",
          "[signal]") {
  auto b = two_bodies();
  World w(b);
  SignalScope scope = w.scope();
  scope.may_come = [](const std::string& name) { return name.substr(0, 4) == "late"; };
  const auto parse = [&](const std::string& text) {
    const auto condition = Condition::parse(scope, text);
    INFO((condition ? "" : condition.error().text()));
    REQUIRE(condition);
    return *condition;
  };
  const Condition near = parse("distance(a, late_ball) lt 2 m"), low = parse("late_ball.z lt 1 m"),
                  touches = parse("contacts(late_ball, a) gt 0");
  CHECK(touches.needs().contacts);
  CHECK(near.text() == "distance(a, late_ball) lt 2 m");
  CHECK(near.evaluate(w.frame) == Truth::unknown);
  CHECK(low.evaluate(w.frame) == Truth::unknown);
  for (const char* wrong : {"early_ball.z lt 1 m", "distance(early, late_ball) lt 1 m",
                            "late_ball.z lt 1 s", "distance(late_ball) lt 1 m"}) {
    INFO(wrong);
    CHECK_FALSE(Condition::parse(scope, wrong));
  }

  auto grown = std::make_shared<SceneModel>(*w.model);
  Body ball = grown->bodies[1];
  ball.name = "late_ball";
  grown->bodies.push_back(ball);
  w.frame.model = grown;
  w.frame.state.poses.push_back(at(1.5, 0, 0.5));
  w.frame.state.twists.emplace_back();
  CHECK(near.holds(w.frame));
  CHECK(low.holds(w.frame));
  CHECK(touches.evaluate(w.frame) == Truth::no);
  // It is removed, and another of the same name is added.
  auto gone = std::make_shared<SceneModel>(*grown);
  gone->bodies[2].removed = true;
  w.frame.model = gone;
  CHECK(low.evaluate(w.frame) == Truth::unknown);
  auto again = std::make_shared<SceneModel>(*gone);
  again->bodies.push_back(ball);
  w.frame.model = again;
  w.frame.state.poses.push_back(at(1.5, 0, 5));
  CHECK(low.evaluate(w.frame) == Truth::no);
}
