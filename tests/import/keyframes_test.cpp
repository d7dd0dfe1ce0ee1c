// The start of a robot from a keyframe of MJCF.
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

/// A floating body with a hinge, a ball and a slide, and a planar body.
const char* const kModel = R"(<mujoco model="m"><worldbody>
    <body name="root" pos="0 0 1"><freejoint/><geom size="0.1" mass="1"/>
      <body name="arm" pos="0.3 0 0"><joint name="hinge" axis="0 1 0" ref="90" range="-10 200"/>
        <geom size="0.1" mass="1"/>
        <body name="hand" pos="0.3 0 0"><joint name="ball" type="ball"/><geom size="0.1" mass="1"/></body></body></body>
    <body name="cart" pos="0 2 0"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
      <joint type="hinge" axis="0 0 1"/><geom size="0.1" mass="1"/></body>
    <body name="lift" pos="0 4 0"><joint name="slide" type="slide"/><geom size="0.1" mass="1"/></body>
  </worldbody>
  <actuator><position name="hold" joint="hinge" kp="4"/><motor name="push" joint="slide" gear="2"/></actuator>
  <keyframe>
    <key name="home" qpos="1 2 3 0 0 0 2  2  0 1 0 0  0.5 -0.25 1.5  0.75" ctrl="2.5 3"/>
    <key qpos="0 0 1 1 0 0 0  0  1 0 0 0  0 0 0  0" qvel="0 0 0 0 0 0 0 0 0 0 0 0 0 1"/>
    <key name="far" qpos="0 0 1 1 0 0 0  9  1 0 0 0  0 0 0  0"/>
    <key name="short" qpos="1 2"/>
  </keyframe></mujoco>)";

}  // namespace

TEST_CASE("a robot starts in the keyframe that was named", "[mjcf][keyframe]") {
  Imported in;
  in.options.keyframe = "home";
  in.read(kModel, "m.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kExact, "key 'home'", "is the start"));
  CHECK(in.reports(kLeftOut, "key 'far'", "--keyframe far"));
  const double half_pi = std::acos(0.0);
  const Pose& root = in.body("root").X_WB;
  CHECK((root.p - Vec3(1, 2, 3)).norm() < 1e-12);
  CHECK(root.q.angularDistance(Quat(0, 0, 0, 1)) < 1e-12);
  CHECK(in.joint("hinge").position.at(0) == Approx(2.0 - half_pi));
  const std::vector<double>& ball = in.joint("ball").position;
  REQUIRE(ball.size() == 4);
  CHECK(std::abs(ball[1]) == Approx(1.0));
  const Pose& cart = in.body("cart").X_WB;
  CHECK((cart.p - Vec3(0.5, 1.75, 0)).norm() < 1e-12);
  CHECK(cart.q.angularDistance(Quat(Eigen::AngleAxisd(1.5, Vec3::UnitZ()))) < 1e-12);
  CHECK(in.joint("slide").position.at(0) == 0.75);
  CHECK(in.model->motors.at(0).target.value() == Approx(2.5 - half_pi));
  CHECK(in.model->motors.at(1).target.value() == Approx(6.0));
}

TEST_CASE("without a name the robot starts at its zero, and the report names the option",
          "[mjcf][keyframe]") {
  Imported in;
  in.read(kModel, "m.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "key 'home'", "--keyframe home"));
  CHECK(in.reports(kLeftOut, "key '2'", "--keyframe 2"));
  CHECK((in.body("root").X_WB.p - Vec3(0, 0, 1)).norm() < 1e-12);
}

TEST_CASE("a keyframe's speeds and starts beyond limits are reported", "[mjcf][keyframe]") {
  Imported in;
  in.options.keyframe = "2";
  in.read(kModel, "m.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kApproximate, "<key>", "without qvel"));
  in.options.keyframe = "far";
  in.read(kModel, "m.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kApproximate, "joint 'hinge'", "beyond its limits"));
}

TEST_CASE("a keyframe that is not there or does not fit is an error", "[mjcf][keyframe]") {
  Imported in;
  in.options.keyframe = "hone";
  in.read(kModel, "m.xml");
  CHECK(in.refuses("CG1408", "did you mean 'home'? Its keyframes are 'home', '2', 'far'"));
  in.options.keyframe = "short";
  in.read(kModel, "m.xml");
  CHECK(in.refuses("CG1403", "has 2 numbers, 16 are expected"));
  in.options.keyframe = "home";
  in.read("<mujoco><worldbody><body><geom size=\"0.1\"/></body></worldbody></mujoco>", "m.xml");
  CHECK(in.refuses("CG1408", "the model has none"));
  in.read("<robot name=\"r\"><link name=\"a\"/></robot>");
  CHECK(in.refuses("CG1408", "URDF has no keyframes"));
}
