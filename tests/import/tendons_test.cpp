// Tendons of MJCF, and what acts on them.
#include "cogrsim/dsl/export_model.h"
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

/// A hinge about y, a slide along y and a hinge about y, on bodies side by side.
const char* const kBodies = R"(<worldbody>
    <body name="a"><joint name="one" axis="0 1 0" ref="0.2" springref="0.5"/><geom size="0.1" mass="1"/></body>
    <body name="b" pos="1 0 0"><joint name="two" type="slide" axis="0 1 0"/><geom size="0.1" mass="1"/></body>
    <body name="c" pos="2 0 0"><joint name="three" axis="0 1 0"/><geom size="0.1" mass="1"/></body>
  </worldbody>)";

std::string model(const std::string& rest) {
  return std::string("<mujoco><compiler angle=\"radian\"/>") + kBodies + rest + "</mujoco>";
}

std::string joint_name(const SceneModel& model, int joint) {
  return model.joints[joint].name;
}

}  // namespace

TEST_CASE("an equality of fixed tendons couples their joints", "[mjcf][tendon]") {
  Imported in;
  // 2 q1 + 4 q2 = 0.6 + 0.5 (6 q3 - 8 q2), of coordinates from the reference.
  in.read(model(R"(<tendon>
      <fixed name="s"><joint joint="one" coef="2"/><joint joint="two" coef="4"/></fixed>
      <fixed name="t"><joint joint="three" coef="6"/><joint joint="two" coef="-8"/></fixed></tendon>
    <equality><tendon name="e" tendon1="s" tendon2="t" polycoef="0.6 0.5 0 0 0"/></equality>)"),
          "m.xml");
  REQUIRE(in.model);
  REQUIRE(in.model->couplings.size() == 1);
  const Coupling& c = in.model->couplings[0];
  CHECK(joint_name(*in.model, c.joint) == "robot.one");
  REQUIRE(c.terms.size() == 2);
  CHECK(joint_name(*in.model, c.terms[0].joint) == "robot.two");
  CHECK(c.terms[0].ratio == Approx(-4.0));
  CHECK(joint_name(*in.model, c.terms[1].joint) == "robot.three");
  CHECK(c.terms[1].ratio == Approx(1.5));
  CHECK(c.offset == Approx(0.3));
  CHECK(in.joint("one").position.at(0) == Approx(0.3));
  CHECK(in.reports(kExact, "tendon 'e'"));
}

TEST_CASE("a joint that others follow does not follow them by a tendon", "[mjcf][tendon]") {
  Imported in;
  const auto read = [&](const std::string& more) {
    in.read(
        model(R"(<tendon><fixed name="t"><joint joint="one" coef="1"/><joint joint="two" coef="-2"/>
      </fixed></tendon><equality><joint joint1="two" joint2="one"/>)" +
              more + "</equality>"),
        "m.xml");
  };
  read(R"(<tendon name="e" tendon1="t"/>)");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "tendon 'e'", "each of its joints follows another"));
  read(R"(<tendon name="e" tendon1="nowhere"/>)");
  CHECK(in.reports(kLeftOut, "tendon 'e'", "needs fixed tendons"));
}

TEST_CASE("couplings with several joints come back from MJCF", "[mjcf][tendon]") {
  const dsl::CompileResult scene = dsl::compile_text(R"(
<scene name="differential" version="1">
  <assembly name="bot">
    <body name="base" mass="1 kg" static="true"/>
    <body name="left" xyz="0 1 0"><sphere radius="0.1 m"/></body>
    <body name="right" xyz="0 2 0"><sphere radius="0.1 m"/></body>
    <body name="cage" xyz="0 3 0"><sphere radius="0.1 m"/></body>
    <hinge name="l" parent="base" child="left" axis="0 1 0" position="0.3 rad"/>
    <hinge name="r" parent="base" child="right" axis="0 1 0"/>
    <hinge name="c" parent="base" child="cage" axis="0 1 0"/>
    <couple joint="c" to="l r" ratio="0.5 0.25" offset="0.1 rad"/>
  </assembly>
</scene>)",
                                                     "differential.scene.xml");
  INFO(dsl::to_text(scene.diagnostics));
  REQUIRE(scene.ok());
  dsl::ExportOptions options;
  options.format = dsl::ExportFormat::mjcf;
  const auto out = dsl::export_model(*scene.model, options);
  REQUIRE(out);
  Imported back;
  back.read(out->text, "bot.xml");
  REQUIRE(back.model);
  REQUIRE(back.model->couplings.size() == 1);
  const Coupling& c = back.model->couplings[0];
  CHECK(joint_name(*back.model, c.joint).find("bot_c") != std::string::npos);
  REQUIRE(c.terms.size() == 2);
  CHECK(c.terms[0].ratio == 0.5);
  CHECK(c.terms[1].ratio == 0.25);
  // Its zero is the start, where the coupling holds: two roundings of numbers below 1.
  CHECK(std::abs(c.offset) < 1e-15);
}

TEST_CASE("an actuator of a tendon whose joints are coupled drives the joint that leads",
          "[mjcf][tendon]") {
  Imported in;
  // q3 = 0.1 - 2 q1, so L = 0.5 (q1 + 0.2) + 0.75 q3 = 0.175 - q1.
  in.read(model(R"(<tendon>
      <fixed name="t"><joint joint="one" coef="0.5"/><joint joint="three" coef="0.75"/></fixed></tendon>
    <equality><joint joint1="three" joint2="one" polycoef="0.1 -2"/></equality>
    <actuator><general name="grip" tendon="t" gear="2" gainprm="0.4" biastype="affine"
      biasprm="0.8 -100 -10" forcerange="-5 5"/></actuator>)"),
          "m.xml");
  REQUIRE(in.model);
  REQUIRE(in.model->motors.size() == 1);
  const Motor& m = in.model->motors[0];
  CHECK(joint_name(*in.model, m.joint) == "robot.one");
  CHECK(m.kp == Approx(400.0));  // (2 C)² 100
  CHECK(m.kd == Approx(40.0));
  CHECK(m.max_effort == Approx(10.0));
  // u = 0 holds 100 * 2 L = 0.8, so q1 = 0.175 - 0.004.
  CHECK(in.reports(kExact, "general 'grip'", "-0.002 u + 0.171 at joint 'one'"));
  CHECK(in.reports(kExact, "general 'grip'", "which the others follow"));
}

TEST_CASE("a motor of a tendon of free joints is one motor for each", "[mjcf][tendon]") {
  Imported in;
  in.read(model(R"(<tendon>
      <fixed name="t"><joint joint="one" coef="0.5"/><joint joint="two" coef="-2"/></fixed>
      <fixed name="single"><joint joint="three" coef="0.5"/><joint joint="two" coef="0"/></fixed></tendon>
    <actuator><motor name="pull" tendon="t" gear="3" ctrlrange="-2 2"/>
      <position name="hold" tendon="t" kp="5"/>
      <position name="alone" tendon="single" kp="8" kv="4"/></actuator>)"),
          "m.xml");
  REQUIRE(in.model);
  REQUIRE(in.model->motors.size() == 3);
  const auto& motors = in.model->motors;
  CHECK(motors[0].name == "robot.pull_one");
  CHECK(motors[0].mode == MotorMode::torque);
  CHECK(motors[0].max_effort == Approx(3.0));  // 0.5 * 3 * 2 N m
  CHECK(joint_name(*in.model, motors[1].joint) == "robot.two");
  CHECK(motors[1].max_effort == Approx(12.0));
  CHECK(in.reports(kApproximate, "motor 'pull'", "-6 u at joint 'two'"));
  CHECK(in.reports(kLeftOut, "position 'hold'", "sum of 2 joints"));
  CHECK(motors[2].kp == Approx(2.0));
  CHECK(motors[2].kd == Approx(1.0));
  CHECK(in.reports(kExact, "position 'alone'", "2 u at joint 'three'"));
}

TEST_CASE("passive forces of a tendon of one joint are the joint's", "[mjcf][tendon]") {
  Imported in;
  in.read(model(R"(<tendon>
      <fixed name="t" stiffness="8" damping="4" frictionloss="3" limited="true" range="-1 0.5">
        <joint joint="one" coef="0.5"/></fixed>
      <fixed name="sum" stiffness="1"><joint joint="two" coef="1"/><joint joint="three" coef="1"/></fixed>
      <fixed name="band" stiffness="1" springlength="0 1"><joint joint="two" coef="1"/></fixed></tendon>)"),
          "m.xml");
  REQUIRE(in.model);
  const JointAxis& axis = in.joint("one").axes.at(0);
  CHECK(axis.stiffness == Approx(2.0));
  CHECK(axis.rest == Approx(0.3));  // springref - ref
  CHECK(axis.damping == Approx(1.0));
  CHECK(axis.friction == Approx(1.5));
  CHECK(axis.lower == Approx(-2.2));  // -1 / 0.5 - ref
  CHECK(axis.upper == Approx(0.8));
  CHECK(in.reports(kExact, "fixed 't'", "those of joint 'one'"));
  CHECK(in.reports(kLeftOut, "fixed 'sum'", "a sum of joints"));
  CHECK(in.reports(kApproximate, "fixed 'band'", "dead band"));
}

namespace {

/// Two boxes with a site each, and one in the world.
std::string two_sites(const std::string& tendon) {
  return R"(<mujoco><compiler angle="radian"/><worldbody><site name="hook" pos="0 0 3"/>
    <body name="a" pos="0 0 1"><joint name="j" type="slide" springref="0.5"/>
      <geom size="0.1" mass="1"/><site name="end" pos="0 0 0.25"/>
      <body name="part"><geom size="0.05" mass="1"/><site name="deep" pos="0 0 0.5"/></body></body>
    <body name="b" pos="2 0 0"><freejoint/><geom size="0.1" mass="1"/><site name="free"/></body>
    </worldbody><tendon>)" +
         tendon + "</tendon></mujoco>";
}

}  // namespace

TEST_CASE("a tendon between two sites is a spring", "[mjcf][tendon]") {
  Imported in;
  in.read(
      two_sites(
          R"(<spatial name="up" stiffness="100" damping="3"><site site="end"/><site site="hook"/></spatial>
    <spatial name="set" stiffness="50" springlength="0.4"><site site="deep"/><site site="free"/></spatial>
    <spatial name="rope" stiffness="70" springlength="0 0.8"><site site="free"/><site site="hook"/></spatial>)"),
      "m.xml");
  REQUIRE(in.model);
  REQUIRE(in.model->forces.size() == 3);
  const auto& forces = in.model->forces;
  CHECK(forces[0].stiffness == 100.0);
  CHECK(forces[0].damping == 3.0);
  CHECK(forces[0].length == Approx(1.25));  // 3 - 1 - 0.25, with the slide at its springref
  CHECK((forces[0].X_BE.p - Vec3(0, 0, 0.25)).norm() < 1e-15);
  CHECK(forces[1].length == 0.4);
  // The end is on a body that was welded to another.
  CHECK((forces[1].X_BE.p - Vec3(0, 0, 0.5)).norm() < 1e-15);
  CHECK(!forces[1].cable);
  CHECK(forces[2].cable);
  CHECK(forces[2].length == 0.8);
  for (const char* name : {"up", "set", "rope"}) {
    INFO(name);
    CHECK(in.reports(kExact, std::string("spatial '") + name + "'"));
  }
}

TEST_CASE("tendons in space that are no springs are left out with the reason", "[mjcf][tendon]") {
  Imported in;
  in.read(
      two_sites(
          R"(<spatial name="limit" limited="true" range="0 1"><site site="end"/><site site="hook"/></spatial>
    <spatial name="three" stiffness="1"><site site="end"/><site site="hook"/><site site="free"/></spatial>
    <spatial name="around" stiffness="1"><site site="end"/><geom geom="g"/><site site="free"/></spatial>
    <spatial name="same" stiffness="1"><site site="end"/><site site="deep"/></spatial>
    <spatial name="band" stiffness="1" springlength="0.2 0.8"><site site="end"/><site site="free"/></spatial>)"),
      "m.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "spatial 'limit'", "limits the length"));
  CHECK(in.reports(kLeftOut, "spatial 'three'", "two ends"));
  CHECK(in.reports(kLeftOut, "spatial 'around'", "straight"));
  CHECK(in.reports(kLeftOut, "spring 'same'", "does not move"));
  CHECK(in.reports(kApproximate, "spatial 'band'", "only pulls"));
  CHECK(in.model->forces.size() == 1);
}

TEST_CASE("springs and cables come back from MJCF", "[mjcf][tendon]") {
  const dsl::CompileResult scene = dsl::compile_text(R"(
<scene name="springs" version="1">
  <sphere name="left" radius="0.1 m" xyz="0 0 1"/>
  <sphere name="right" radius="0.1 m" xyz="0 2 1"/>
  <spring between="left right" stiffness="40 N/m" damping="2 N*s/m" length="1.5 m"/>
  <spring between="left world" stiffness="60 N/m" length="0.7 m" cable="true"/>
</scene>)",
                                                     "springs.scene.xml");
  INFO(dsl::to_text(scene.diagnostics));
  REQUIRE(scene.ok());
  dsl::ExportOptions options;
  options.format = dsl::ExportFormat::mjcf;
  const auto out = dsl::export_model(*scene.model, options);
  REQUIRE(out);
  Imported back;
  back.read(out->text, "springs.xml");
  REQUIRE(back.model);
  REQUIRE(back.model->forces.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const ForceModel &before = scene.model->forces[i], &after = back.model->forces[i];
    CHECK(after.stiffness == before.stiffness);
    CHECK(after.damping == before.damping);
    CHECK(after.length == before.length);
    CHECK(after.cable == before.cable);
  }
}
