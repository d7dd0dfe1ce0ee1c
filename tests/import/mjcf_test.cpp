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
