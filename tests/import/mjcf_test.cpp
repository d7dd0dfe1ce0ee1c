#include <cmath>

#include "cogrsim/core/constants.h"
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

TEST_CASE("bodies, default classes and geoms of MJCF", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco model="m">
    <compiler angle="degree"/>
    <option timestep="0.002"/>
    <default>
      <geom density="500"/><joint damping="0.5"/>
      <default class="leg"><geom type="capsule" size="0.02"/><joint axis="0 1 0" range="-30 60"/></default>
    </default>
    <worldbody>
      <geom type="plane" size="1 1 1"/>
      <body name="torso" pos="0 0 1">
        <freejoint/>
        <geom type="sphere" size="0.1"/>
        <body name="thigh" pos="0 0.1 0" childclass="leg">
          <joint name="hip" pos="0 0 0.05" armature="0.01"/>
          <geom fromto="0 0 0 0 0 -0.3"/>
          <site name="knee" pos="0 0 -0.3"/>
        </body>
      </body>
    </worldbody>
    <actuator><position name="servo" joint="hip" kp="20" forcerange="-5 5"/></actuator>
    <sensor><jointpos joint="hip"/><gyro site="knee"/></sensor>
  </mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.result.format == "MJCF");
  CHECK(in.model->physics.step == 0.002);
  const double pi = 3.14159265358979323846;
  CHECK(in.body("torso").mass == Approx(500.0 * 4.0 / 3.0 * pi * 1e-3).epsilon(1e-12));
  const double r = 0.02, h = 0.3;
  CHECK(in.body("thigh").mass ==
        Approx(500.0 * (pi * r * r * h + 4.0 / 3.0 * pi * r * r * r)).epsilon(1e-12));
  CHECK((in.body("thigh").com - Vec3(0, 0, -0.15)).norm() < 1e-12);
  const Joint& hip = in.joint("hip");
  CHECK(hip.axes[0].lower == Approx(-pi / 6));
  CHECK(hip.axes[0].upper == Approx(pi / 3));
  CHECK(hip.axes[0].damping == 0.5);
  CHECK((hip.X_CM.p - Vec3(0, 0, 0.05)).norm() < 1e-15);
  CHECK(in.model->motors.size() == 1);
  CHECK(in.reports(kExact, "position 'servo'"));
}

TEST_CASE("two sliders and a hinge are a planar joint", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco><worldbody><body name="torso" pos="0 0 1">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/>
      <joint name="y" type="hinge" axis="0 1 0"/><geom type="sphere" size="0.1"/></body></worldbody></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.model->bodies.size() == 1);
  CHECK(in.joint("x").type == JointType::planar);
}

TEST_CASE("a loop of MJCF is a joint that closes a loop", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco><worldbody>
      <body name="a"><joint name="ja" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0.5 0 0"/>
        <body name="b" pos="0.5 0 0"><joint name="jb" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.5"/></body></body>
      <body name="c" pos="0 0 -0.5"><joint name="jc" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0.5 0 0"/></body>
    </worldbody><equality><connect name="close" body1="b" body2="c" anchor="0 0 -0.5"/></equality></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.joint("close").closes_loop);
  CHECK(in.reports(kApproximate, "connect 'close'", "rigid"));
}

TEST_CASE("a class that is not there is refused with the nearest", "[mjcf]") {
  Imported in;
  in.read(
      "<mujoco><default><default class=\"leg\"/></default>\n<worldbody><body><geom class=\"lge\" "
      "size=\"1\"/></body></worldbody></mujoco>",
      "m.xml");
  CHECK(in.refuses("CG1408", "did you mean 'leg'?", 2));
}

TEST_CASE("a ball joint of MJCF has its passive efforts", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco><worldbody><body name="b"><joint name="s" type="ball" damping="0.1"
      stiffness="2" frictionloss="0.3" armature="0.02"/><geom size="0.1"/></body></worldbody></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  const JointAxis& axis = in.joint("s").axes.at(0);
  CHECK(axis.damping == 0.1);
  CHECK(axis.stiffness == 2.0);
  CHECK(axis.friction == 0.3);
  CHECK(axis.rotor_inertia == 0.02);
}

TEST_CASE("meshes of MJCF collide as their hulls, also those of the world", "[mjcf]") {
  Imported in;
  in.folder.write("m.obj",
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  in.read(R"(<mujoco><asset><mesh name="m" file="m.obj"/></asset><worldbody>
      <geom type="mesh" mesh="m"/>
      <body name="b" pos="0 0 2"><freejoint/><geom type="mesh" mesh="m"/></body></worldbody></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  REQUIRE(in.model->bodies.size() == 2);
  for (const Body& body : in.model->bodies) CHECK(body.shapes.at(0).type == ShapeType::convex_mesh);
  CHECK_FALSE(in.reports(kApproximate, "collision mesh"));

  in.read(R"(<mujoco><asset><mesh name="m" file="m.obj" scale="1 2 0"/></asset><worldbody>
      <body name="b"><freejoint/><geom type="mesh" mesh="m"/><geom size="0.1"/></body></worldbody></mujoco>)",
          "flat.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "geom", "leaves no volume"));
}

TEST_CASE("a mesh that is inside out has no mass, and is named by its body", "[mjcf]") {
  Imported in;
  in.folder.write("m.obj",
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n");
  in.read(R"(<mujoco><asset><mesh name="m" file="m.obj"/></asset><worldbody>
      <body name="b"><freejoint/><geom type="mesh" mesh="m"/><geom size="0.1"/></body></worldbody></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "mass of geom of type mesh of body 'b'", "the mesh is inside out"));
  CHECK_FALSE(in.reports(kLeftOut, "", "''"));
}

TEST_CASE("an inertia that MJCF gives as zero is taken from the geoms", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco><worldbody><body name="b"><freejoint/>
      <inertial pos="0 0 0.3" mass="6" diaginertia="0 0 0"/>
      <geom type="box" size="0.5 0.5 0.5" euler="0 0 90"/></body></worldbody></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK((in.body("b").inertia - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(in.reports(kApproximate, "inertia of link 'b'", "is zero"));
}

TEST_CASE("a step that no scene has is left out", "[mjcf]") {
  Imported in;
  in.read(
      R"(<mujoco><option timestep="2"/><worldbody><body><geom size="0.1"/></body></worldbody></mujoco>)",
      "m.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "step", "2 s"));
}

TEST_CASE("cameras of MJCF have their picture, and are off until they are asked", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco><compiler angle="radian"/><worldbody>
    <camera name="hall" pos="0 -3 1" xyaxes="1 0 0 0 0 1" fovy="60"/>
    <body name="head"><geom type="sphere" size="0.1" mass="1"/>
      <camera name="eye" pos="0.2 0 0" resolution="640 480" fovy="40"/>
      <camera name="lens" pos="0.3 0 0" resolution="400 200" sensorsize="0.02 0.01" focal="0.01 0.01"/>
      <camera name="chase" pos="-3 0 0" mode="targetbody" target="head"/>
    </body></worldbody></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  REQUIRE(in.model->sensors.size() == 4);
  const auto fov = [&](const char* name) {
    const SensorModel& s = in.named(in.model->sensors, name);
    CHECK_FALSE(s.enabled);
    CHECK(s.rate == 30.0);
    return parameter(s, "fov");
  };
  // tan(h/2) = tan(v/2) columns/rows; a sensor of width w behind a focal length f: tan(h/2) = w/(2f).
  CHECK(fov("hall") == Approx(2.0 * std::atan(std::tan(kPi / 6.0) * 4.0 / 3.0)));
  CHECK(fov("eye") == Approx(2.0 * std::atan(std::tan(kPi / 9.0) * 4.0 / 3.0)));
  CHECK(fov("lens") == Approx(kPi / 2.0));
  CHECK(in.reports(kExact, "camera 'eye'", "once it is enabled"));
  CHECK(in.reports(kApproximate, "camera 'chase'", "fixed to its body"));
}

TEST_CASE("the range of a joint's actuator forces bounds its motors", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco><worldbody><body><joint name="even" actuatorfrcrange="-7 7"/><geom size="0.1"/>
    <body pos="1 0 0"><joint name="odd" actuatorfrcrange="-2 5"/><geom size="0.1"/></body></body></worldbody>
    <actuator><motor joint="even" gear="100"/></actuator></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.named(in.model->joints, "even").axes[0].max_effort == 7.0);
  CHECK(in.named(in.model->joints, "odd").axes[0].max_effort == 5.0);
  CHECK(in.reports(kApproximate, "actuatorfrcrange of joint 'odd'", "both directions"));
}

TEST_CASE("a ball joint keeps its cone, and a drive the damping of its ratio", "[mjcf]") {
  Imported in;
  in.read(
      R"(<mujoco><worldbody><body name="a"><joint name="socket" type="ball" range="0 60"/><geom size="0.1"/></body>
    <body name="b"><joint name="hinge" axis="0 1 0" armature="0.5"/><geom size="0.1" mass="2" pos="0.3 0 0"/>
      <body name="c" pos="0.3 0 0"><joint name="slide" type="slide"/><geom size="0.1" mass="3" pos="0 0 0.4"/></body></body>
    </worldbody><actuator><position joint="hinge" kp="7" gear="2" dampratio="1.5"/></actuator></mujoco>)",
      "m.xml");
  REQUIRE(in.model);
  CHECK(in.joint("socket").axes.at(0).upper == Approx(kPi / 3.0));
  // Two balls of the radius 0.1 m, 0.3 m and 0.5 m away.
  const double inertia = 0.5 + 2.0 * (0.4 * 0.01 + 0.09) + 3.0 * (0.4 * 0.01 + 0.25);
  CHECK(in.model->motors.at(0).kp == 28.0);
  CHECK(in.model->motors.at(0).kd == Approx(2.0 * 1.5 * std::sqrt(28.0 * inertia)));
}

TEST_CASE("controls have the bounds of the source", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco><compiler angle="radian"/><worldbody>
    <body><joint name="j" axis="0 1 0" range="-2 1" ref="0.5"/><geom size="0.1"/></body>
    <body><joint name="k" axis="0 1 0"/><geom size="0.1"/></body>
    <body><joint name="l" axis="0 1 0"/><geom size="0.1"/></body></worldbody>
    <actuator><position joint="j" kp="7" inheritrange="0.5"/><motor joint="k" ctrlrange="0 3" gear="2"/>
    <position joint="l" gear="-2" ctrlrange="1 3" forcerange="-1 4"/></actuator></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  const auto& motors = in.model->motors;
  REQUIRE(motors.size() == 3);
  // Half of -2 to 1 about its middle, less ref.
  CHECK(motors[0].min_target == Approx(-1.25 - 0.5));
  CHECK(motors[0].max_target == Approx(0.25 - 0.5));
  CHECK(motors[0].target.value() == Approx(-0.5));
  CHECK(motors[1].max_effort == 6.0);
  CHECK(motors[1].min_target == 0.0);
  CHECK(motors[2].min_target == -1.5);
  CHECK(motors[2].max_target == -0.5);
  CHECK(motors[2].target.value() == -0.5);
  CHECK(in.reports(kApproximate, "forcerange", "both directions by 4"));
}

TEST_CASE("sensors of frames are poses of sites and bodies", "[mjcf]") {
  Imported in;
  in.read(
      R"(<mujoco><worldbody><body name="b" pos="0 0 1"><freejoint/><geom size="0.1" pos="0.1 0 0"/>
    <site name="tip" pos="0 0.2 0"/></body></worldbody><sensor>
    <framequat name="turn" objtype="site" objname="tip"/><velocimeter name="speed" site="tip"/>
    <framepos name="centre" objtype="body" objname="b"/><framepos name="origin" objtype="xbody" objname="b"/>
    <framequat name="axes" objtype="body" objname="b"/>
    <framepos name="from" objtype="site" objname="tip" reftype="body" refname="b"/></sensor></mujoco>)",
      "m.xml");
  REQUIRE(in.model);
  REQUIRE(in.model->sensors.size() == 3);
  const auto at = [&](const char* name) { return in.named(in.model->sensors, name).X_BS.p; };
  CHECK((at("turn") - Vec3(0, 0.2, 0)).norm() < 1e-12);
  CHECK((at("centre") - Vec3(0.1, 0, 0)).norm() < 1e-12);
  CHECK(at("origin").norm() < 1e-12);
  CHECK(in.reports(kApproximate, "velocimeter 'speed'", "the pose at its place reads both"));
  CHECK(in.reports(kLeftOut, "framequat 'axes'", "principal axes"));
  CHECK(in.reports(kLeftOut, "framepos 'from'", "relative to another frame"));
}

TEST_CASE("what is said of MuJoCo's contacts and solver is said to that engine", "[mjcf]") {
  Imported in;
  // Compiled by programs, which know the engine.
  in.result = dsl::import_model(
      in.folder.write("m.xml", R"(<mujoco><option cone="elliptic" impratio="10" timestep="0.001"/>
    <default><geom solref="0.01 1" margin="0.002"/></default><worldbody><geom type="plane" size="1 1 1" margin="0"/>
    <body><freejoint/><geom size="0.1"/></body>
    <body pos="1 0 0"><freejoint/><geom size="0.1" priority="1" solimp="0.5 1 0.01"/></body>
    <body pos="2 0 0"><joint name="j" range="-1 1" solreflimit="0.03 1" frictionloss="1"/><geom size="0.1"/></body>
    <body pos="3 0 0"><joint name="k" range="-1 1" solreflimit="0.03 1"/><geom size="0.1"/></body>
    <body pos="4 0 0"><joint name="l" range="-1 1" solimplimit="0 0.9 0.001"/><geom size="0.1"/></body>
    </worldbody><equality><joint joint1="j" joint2="k" solref="0.005 1"/>
    <joint joint1="k" joint2="l"/></equality></mujoco>)"),
      in.options);
  const auto has = [&](const std::string& text) {
    return in.result.scene.find(text) != std::string::npos;
  };
  // The world has what most limits have, or the first of as many.
  CHECK(
      has("<physics step=\"0.001 s\">\n    <mujoco cone=\"elliptic\" impratio=\"10\" "
          "solrefequality=\"0.005 1\" solreflimit=\"0.03 1\"/>"));
  CHECK(has("<mujoco solref=\"0.01 1\"/></material>"));  // of the plane
  CHECK(has("<mujoco solref=\"0.01 1\" margin=\"0.002\"/></material>"));
  CHECK(
      has("<mujoco solref=\"0.01 1\" solimp=\"0.5 1 0.01 0.5 2\" margin=\"0.002\" "
          "priority=\"1\"/></material>"));
  CHECK(has("<mujoco solreflimit=\"0.02 1\" solimplimit=\"0 0.9 0.001 0.5 2\"/></hinge>"));
  CHECK(has("<mujoco solrefequality=\"0.02 1\"/></couple>"));
  CHECK(in.reports(kExact, "softness of contacts", "by materials"));
  CHECK(in.reports(kExact, "solreflimit", "1 of 3 have their own"));
  CHECK(in.reports(kExact, "option cone", "elliptic"));

  // One softness of all contacts is the world's.
  in.result = dsl::import_model(
      in.folder.write("n.xml", R"(<mujoco><default><geom solref="0.01 1"/></default><worldbody>
    <geom type="plane" size="1 1 1"/><body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>)"),
      in.options);
  CHECK(has("<physics step=\"0.002 s\">\n    <mujoco solref=\"0.01 1\"/>"));
  CHECK(in.reports(kExact, "solref of contacts", "0.01 1 on the engine MuJoCo"));
}

TEST_CASE("what stands around a robot is no part of it", "[mjcf][sdf]") {
  Imported in;
  in.read(R"(<mujoco model="bot"><worldbody><geom name="floor" type="plane" size="1 1 1"/>
    <site name="hook" pos="0 0 3"/><body name="table" pos="2 0 0"><geom type="box" size="1 1 1"/></body>
    <body name="base" pos="0 0 1"><geom size="0.1"/><body name="arm"><joint name="j"/><geom size="0.1" pos="1 0 0"/>
    <site name="eye"/></body></body></worldbody>
    <tendon><spatial stiffness="5"><site site="hook"/><site site="eye"/></spatial></tendon>
    <contact><exclude body1="arm" body2="table"/></contact></mujoco>)",
          "bot.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kExact, "what stands around the robot"));
  const auto has = [&](const std::string& name) { return find_body(*in.model, name) >= 0; };
  CHECK(has("bot_scenery.world_link"));
  CHECK(has("bot_scenery.table"));
  CHECK(has("bot.base"));
  CHECK(has("bot.arm"));
  CHECK(in.model->no_collide.size() == 1);
  CHECK(in.model->forces.size() == 1);
}
