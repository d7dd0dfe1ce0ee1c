#include "cogrsim/signals/signal.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"
#include "support.h"

using namespace cogrsim;

namespace {

Pose at(double x, double y = 0, double z = 0) { return {Vec3(x, y, z), Quat(1, 0, 0, 0)}; }

/// A robot of two bodies with a hinge, a ball joint on the world, a motor and two sensors.
struct Scene {
  SceneModelPtr model;
  Frame frame;
  std::vector<Channel> channels = {{"distance", "m", true}, {"range[0]", "m", true}};

  Scene() {
    ModelBuilder b("signals");
    const int floor = b.plane("floor");
    const int chassis = b.box("robot.chassis", Vec3::Ones(), 2.0, at(1, 2, 3));
    const int wheel = b.sphere("robot.wheel", 0.1, 1.0, at(1, 3, 3));
    const int bob = b.sphere("bob", 0.1, 1.0, at(0, 0, 9));
    const int axle = b.joint("robot.axle", JointType::hinge, chassis, wheel, at(1, 3, 3));
    const int swing = b.joint("swing", JointType::ball, kWorld, bob, at(0, 0, 10));
    b.joint("weld", JointType::fixed, kWorld, floor, at(0));
    b.motor("robot.drive", axle, MotorMode::velocity);
    b.assembly("robot", {chassis, wheel}, {axle});
    b.assembly("empty");
    NamedFrame mast;
    mast.name = "robot.mast";
    mast.body = chassis;
    mast.X_BF = at(0, 0, 0.5);
    b.model.frames.push_back(mast);
    for (const char* name : {"robot.eye", "robot.gps"}) {
      SensorModel sensor;
      sensor.name = name;
      sensor.type = name == std::string("robot.gps") ? "pose" : "sonar";
      sensor.body = chassis;
      b.model.sensors.push_back(sensor);
    }
    model = b.build();

    frame.model = model;
    frame.step = 7;
    frame.time = 0.25;
    frame.state.poses = {at(0), at(1, 2, 3), at(1, 3, 3), at(0, 0, 9)};
    frame.state.twists.resize(4);
    frame.state.twists[1] = {Vec3(3, 4, 0), Vec3(0, 2, 0)};
    frame.state.joint_positions = {0.5, 1, 0, 0, 0};
    frame.state.joint_velocities = {-1.5, 10, 20, 30};
    frame.state.joint_efforts = {0.125, 1, 2, 3};
    frame.state.motor_efforts = {0.75};
    frame.readings.resize(2);
    frame.readings[0].sequence = 3;
    frame.readings[0].valid = true;
    frame.readings[0].values = {0.4, 0.6};
    Contact touch;
    touch.body_a = floor;
    touch.body_b = wheel;
    touch.force = Vec3(0, 0, 5);
    frame.contacts = {touch, touch};
    touch.body_a = chassis;
    touch.body_b = bob;
    touch.force = Vec3(3, 0, 0);
    frame.contacts.push_back(touch);
    (void)swing;
  }

  Result<Signal> parse(const std::string& text) const {
    SignalScope scope{*model, {}, {}};
    scope.channels = [this](int sensor) { return sensor == 0 ? &channels : nullptr; };
    return Signal::parse(scope, text);
  }
  Signal good(const std::string& text) const {
    const auto signal = parse(text);
    INFO(text << ": " << (signal ? "" : signal.error().text()));
    REQUIRE(signal);
    return *signal;
  }
  double value(const std::string& text) const { return good(text).evaluate(frame); }
  std::string unit(const std::string& text) const { return good(text).unit(); }
  std::string refused(const std::string& text) const {
    const auto signal = parse(text);
    INFO(text);
    REQUIRE_FALSE(signal);
    return signal.error().text();
  }
};

}  // namespace

TEST_CASE("signals read what the frame holds", "[signal]") {
  const Scene s;
  CHECK(s.value("time") == 0.25);
  CHECK(s.value("robot.chassis.x") == 1);
  CHECK(s.value("robot.chassis.z") == 3);
  CHECK(s.value("robot.y") == 2);  // the first body
  CHECK(s.value("robot.chassis.vx") == 3);
  CHECK(s.value("robot.chassis.speed") == Approx(5));
  CHECK(s.value("robot.chassis.wy") == 2);
  CHECK(s.value("robot.chassis.spin") == Approx(2));
  CHECK(s.value("robot.mast.z") == Approx(3.5));
  CHECK(s.value("robot.mast.vx") == Approx(4));  // 3 + wy * 0.5
  CHECK(s.value("robot.axle.position") == 0.5);
  CHECK(s.value("robot.axle.position[0]") == 0.5);
  CHECK(s.value("robot.axle.velocity") == -1.5);
  CHECK(s.value("robot.axle.effort") == 0.125);
  CHECK(s.value("swing.position[0]") == 1);
  CHECK(s.value("swing.velocity[2]") == 30);
  CHECK(s.value("robot.drive.effort") == 0.75);
  CHECK(s.value("robot.eye.distance") == 0.4);
  CHECK(s.value("robot.eye.range[0]") == 0.6);
  CHECK(s.value("robot.eye[1]") == 0.6);
  CHECK(s.value("origin_distance(robot, bob)") == Approx(std::sqrt(1.0 + 4.0 + 36.0)));
  CHECK(s.value(" origin_distance( robot.mast ,robot.chassis ) ") == Approx(0.5));
  // From the bob's centre to the chassis' upper edge, less the bob's radius; the mast is on its lid.
  CHECK(s.value("distance(robot, bob)") == Approx(std::sqrt(0.25 + 2.25 + 30.25) - 0.1));
  CHECK(s.value(" distance( robot.mast ,robot.chassis ) ") == Approx(0.0).margin(1e-12));
  // Of the three contact points two are the wheel's on the floor, one the chassis' with the bob.
  CHECK(s.value("contacts(robot)") == 3);
  CHECK(s.value("contacts(robot, floor)") == 2);
  CHECK(s.value("contacts(floor, bob)") == 0);
  CHECK(s.value("force(floor, robot)") == Approx(10));
  CHECK(s.value("force(robot)") == Approx(std::hypot(10.0, 3.0)));
  const Energy energy = energy_of(*s.model, s.frame.state);
  CHECK(s.value("energy.kinetic") == energy.kinetic);
  CHECK(s.value("energy.potential") == energy.potential);
  CHECK(s.value("energy.total") == energy.kinetic + energy.potential);
}

TEST_CASE("signals are reckoned with", "[signal]") {
  const Scene s;
  CHECK(s.value("bob.z - robot.chassis.z") == 6);
  CHECK(s.value("bob.z - robot.chassis.z - robot.y") == 4);  // from the left
  CHECK(s.value("bob.z - (robot.chassis.z - robot.y)") == 8);
  CHECK(s.value("robot.y + robot.chassis.z * 2") == 8);
  CHECK(s.value("(robot.y + robot.chassis.z) * 2") == 10);
  CHECK(s.value("-robot.y*3/2") == -3);
  CHECK(s.value("abs(robot.axle.velocity) - 0.5") == 1);
  CHECK(s.value("distance(robot, bob) / distance( bob, robot )") == 1);
  CHECK(s.value("robot.eye.range[0] - robot.eye[0]") == Approx(0.2));
  CHECK(s.unit("bob.z - robot.y") == "m");
  CHECK(s.unit("2 * bob.z") == "m");
  CHECK(s.unit("bob.z / robot.y") == "1");
  CHECK(s.unit("bob.z * robot.y") == "m^2");
  CHECK(s.unit("bob.z / time") == "m/s");
  CHECK(s.good("force(bob) - 1").needs().contacts);
  CHECK(std::isnan(s.value("bob.z - robot.gps.x")));  // no reading yet
  // New when either is: two sensors that were read at different times are distinguished.
  Frame later = s.frame;
  const Signal both = s.good("robot.eye.distance - robot.eye.distance");
  later.readings[0].sequence = 4;
  CHECK(both.revision(later) != both.revision(s.frame));
  later.readings[0].sequence = 3;
  later.step = 8;
  CHECK(both.revision(later) == both.revision(s.frame));
}

TEST_CASE("roll pitch and yaw are those that made the pose", "[signal]") {
  Scene s;
  const double roll = 0.3, pitch = -0.7, yaw = 2.5;
  s.frame.state.poses[1].q =
      Quat(Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(pitch, Vec3::UnitY()) *
           Eigen::AngleAxisd(roll, Vec3::UnitX()));
  CHECK(s.value("robot.chassis.roll") == Approx(roll));
  CHECK(s.value("robot.chassis.pitch") == Approx(pitch));
  CHECK(s.value("robot.chassis.yaw") == Approx(yaw));
}

TEST_CASE("units follow the dimension", "[signal]") {
  const Scene s;
  CHECK(s.unit("time") == "s");
  CHECK(s.unit("bob.x") == "m");
  CHECK(s.unit("bob.yaw") == "rad");
  CHECK(s.unit("bob.speed") == "m/s");
  CHECK(s.unit("bob.spin") == "rad/s");
  CHECK(s.unit("robot.axle.position") == "rad");
  CHECK(s.unit("robot.axle.effort") == "N*m");
  CHECK(s.unit("swing.position[1]") == "1");
  CHECK(s.unit("robot.drive.effort") == "N*m");
  CHECK(s.unit("robot.eye.distance") == "m");
  CHECK(s.unit("energy.total") == "J");
  CHECK(s.unit("contacts(bob)") == "1");
  CHECK(s.unit("force(bob)") == "N");
}

TEST_CASE("only contact signals need contacts", "[signal]") {
  const Scene s;
  CHECK(s.good("force(bob)").needs().contacts);
  CHECK(s.good("contacts(bob, floor)").needs().contacts);
  CHECK_FALSE(s.good("bob.x").needs().contacts);
  CHECK((s.good("bob.x").needs() | s.good("force(bob)").needs()).contacts);
}

TEST_CASE("there is no value where there is none", "[signal]") {
  Scene s;
  CHECK(std::isnan(Signal().evaluate(s.frame)));
  CHECK(std::isnan(s.value("robot.gps.x")));  // a sensor of unknown channels, taken on trust
  const Signal distance = s.good("robot.eye.distance");
  s.frame.readings[0].valid = false;
  CHECK(std::isnan(distance.evaluate(s.frame)));
  s.frame.readings.clear();
  CHECK(std::isnan(distance.evaluate(s.frame)));

  const Signal x = s.good("bob.x"), swing = s.good("swing.velocity[0]"),
               force = s.good("force(bob)");
  auto changed = std::make_shared<SceneModel>(*s.model);
  changed->bodies[3].removed = true;
  changed->joints[1].removed = true;
  s.frame.model = changed;
  CHECK(std::isnan(x.evaluate(s.frame)));
  CHECK(std::isnan(swing.evaluate(s.frame)));
  CHECK(std::isnan(force.evaluate(s.frame)));
  // An older frame, from before the body was added.
  changed->bodies.resize(2);
  s.frame.state.poses.resize(2);
  CHECK(std::isnan(x.evaluate(s.frame)));
}

TEST_CASE("a sensor's signal is new with each reading and others with each step", "[signal]") {
  const Scene s;
  CHECK(s.good("robot.eye.distance").revision(s.frame) == 3);
  CHECK(s.good("bob.x").revision(s.frame) == 7);
}

TEST_CASE("mistakes are answered with the nearest that there is", "[signal]") {
  const Scene s;
  const auto says = [&](const std::string& text, const std::string& expected) {
    const std::string answer = s.refused(text);
    CAPTURE(text, answer);
    CHECK(answer.find(expected) != std::string::npos);
  };
  says("", "empty");
  says("tim", "did you mean 'time'");
  says("robto.x", "did you mean 'robot'");
  says("robot.chasis.x", "did you mean 'robot.chassis'");
  says("nothing.like.it", "there are robot");
  says("bob.sped", "did you mean 'speed'");
  says("bob", "bob.speed");
  says("robot.axle", "robot.axle.position");
  says("robot.axle.angle", "it has position, velocity, effort");
  says("robot.axle.position[1]", "no position[1]");
  says("swing.position", "swing.position[0] to swing.position[3]");
  says("swing.position[4]", "from 0 to 3");
  says("swing.position[-1]", "counts from 0");
  says("swing.position[1", "counts from 0");
  says("weld.position", "cannot move");
  says("robot.drive.speed", "it has effort");
  says("robot.eye.distanse", "did you mean 'distance'");
  says("robot.eye[2]", "it has 2");
  says("energy.totl", "did you mean 'total'");
  says("empty.x", "has no body");
  says("distance(bob)", "write distance(a, b)");
  says("distance(bob, robot, floor)", "two things");
  says("distance(bob, )", "two things");
  says("distance(bob, robt)", "did you mean 'robot'");
  says("distance(bob, swing)", "'swing' is no body");
  says("distance(bob, robot", "brackets");
  says("distance(bob, (robot))", "brackets");
  says("distnce(bob, robot)", "did you mean 'distance'");
  says("contacts(robot, robot.wheel)", "in common");
  says("force(robot.mast)", "is no body or assembly");
  says("bob.x + bob.vx", "'bob.x' is in m and 'bob.vx' in m/s");
  says("bob.x +", "is not a signal");
  says("bob.x * ", "missing at the end");
  says("(bob.x", "not closed");
  says("bob.x)", "does not belong");
  says("* bob.x", "does not belong");
  says("bob.x - robto.x", "did you mean 'robot'");
  says("1e999", "does not belong");
  says(std::string(60, '(') + "bob.x" + std::string(60, ')'), "50 are the limit");
  says(std::string(4000, '-') + "bob.x", "50 are the limit");
  says("bob.x robot.x", "one signal");
  says(std::string(5000, 'a'), "too long");
}

TEST_CASE("names may be relative to their scope", "[signal]") {
  const Scene s;
  SignalScope scope{*s.model, {}, {}};
  scope.resolve = [&](const std::string& name) -> std::string {
    return find_body(*s.model, "robot." + name) >= 0 ? "robot." + name : std::string();
  };
  const auto signal = Signal::parse(scope, "wheel.y");
  REQUIRE(signal);
  CHECK(signal->text() == "robot.wheel.y");
  const auto wrong = Signal::parse(scope, "whel.y");
  REQUIRE_FALSE(wrong);
  CHECK(wrong.error().hint.find("'wheel'") != std::string::npos);
}

TEST_CASE("channels of the own sensors are known without a run", "[signal]") {
  const Scene s;
  const ChannelLookup channels = built_in_channels(*s.model);
  CHECK(channels(0) == nullptr);  // a plugin's
  REQUIRE(channels(1) != nullptr);
  CHECK(channels(1)->front().name == "x");
  CHECK(channels(1)->front().unit == "m");
}
