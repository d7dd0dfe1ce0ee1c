// Joints, starts, loops and motors.
#include <cmath>

#include "build_support.h"
#include "cogrsim/model/joint_kinematics.h"
#include "fake_catalog.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

// Two arms of 1 m, along x at q = 0, hinged at the world's origin.
std::string arms(const std::string& first, const std::string& second,
                 const std::string& more = "") {
  return R"(<box name="a" size="1 0.1 0.1" xyz="0.5 0 0"/>
            <box name="b" size="1 0.1 0.1" xyz="1.5 0 0"/>
            <hinge name="j1" child="a" xyz="0 0 0" axis="0 0 1" )" +
         first + R"(/>
            <hinge name="j2" parent="a" child="b" xyz="1 0 0" axis="0 0 1" )" +
         second + "/>" + more;
}

}  // namespace

TEST_CASE("a joint has the frame of its child unless set otherwise", "[dsl][joints]") {
  const auto model = compile_scene(R"(
    <box name="base" size="1 1 1"/>
    <cylinder name="wheel" radius="0.3" length="0.1" xyz="0 1 0" rpy="90 0 0 deg"/>
    <hinge name="axle" parent="base" child="wheel" axis="0 0 -1"/>)");
  const Joint& axle = joint(*model, "axle");
  CHECK(near(axle.X_PF.p, {0, 1, 0}));
  // the cylinder's own -z, seen from the world, is +y
  CHECK(near(axle.X_PF.q * Vec3::UnitZ(), {0, 1, 0}));
  CHECK(near(axle.X_CM.q * Vec3::UnitZ(), {0, 0, -1}));
  CHECK_FALSE(axle.closes_loop);
}

TEST_CASE("joint positions move the bodies beyond them", "[dsl][joints]") {
  const auto model = compile_scene(arms("position=\"90 deg\"", "position=\"-90 deg\""));
  CHECK(near(body(*model, "a").X_WB.p, {0, 0.5, 0}));
  CHECK(near(body(*model, "b").X_WB.p, {0.5, 1, 0}));
  CHECK(joint(*model, "j1").position.at(0) == Approx(M_PI / 2));
}

TEST_CASE("joint velocities run through the tree", "[dsl][joints]") {
  const auto model = compile_scene(arms("velocity=\"2 rad/s\"", "velocity=\"-1 rad/s\""));
  const Body& b = body(*model, "b");
  CHECK(near(b.V_WB.angular, {0, 0, 1}));
  // the elbow moves at 2 m/s, the arm's middle is half a metre further and turns at 1 rad/s
  CHECK(near(b.V_WB.linear, {0, 2.5, 0}));
}

TEST_CASE("a body's own velocity becomes its joint's", "[dsl][joints]") {
  const auto model = compile_scene(R"(
    <box name="a" size="1 0.1 0.1" xyz="0.5 0 0" linear-velocity="0 1 0" angular-velocity="0 0 2 rad/s"/>
    <hinge name="j" child="a" xyz="0 0 0" axis="0 0 1"/>)");
  CHECK(joint(*model, "j").velocity.at(0) == Approx(2.0));
  CHECK(codes_of(R"(
    <box name="a" size="1 0.1 0.1" xyz="0.5 0 0" linear-velocity="1 0 0"/>
    <hinge name="j" child="a" xyz="0 0 0" axis="0 0 1"/>)") == "CG0610");
}

TEST_CASE("materials, joints and couplings have options of an engine", "[dsl][joints]") {
  dsl_test::FakeCatalog catalog;
  dsl::CompileOptions options;
  options.plugins = &catalog;
  const std::string block = R"(<tiny formulation="maximal"/>)";
  const auto model =
      compile_scene(R"(<material name="rubber">)" + block + R"(</material>
    <prototype name="Arm"><box name="a" size="1 1 1" material="rubber"/>
    <box name="b" size="1 1 1" xyz="2 0 0" material="rubber" friction="0.9"/><box name="c" size="1 1 1" xyz="4 0 0"/>
    <hinge name="j" parent="a" child="b">)" +
                        block + R"(</hinge><slider name="k" parent="b" child="c"/>
    <couple name="gear" joint="k" to="j">)" +
                        block + R"(</couple></prototype><instance of="Arm" name="arm"/>)",
                    options);
  const auto has = [](const std::map<std::string, Parameters>& of) {
    return of.count("tiny") == 1 &&
           std::get<std::string>(of.at("tiny").at("formulation")) == "maximal";
  };
  CHECK(has(joint(*model, "arm.j").engine_options));
  CHECK(joint(*model, "arm.k").engine_options.empty());
  CHECK(has(model->couplings.at(0).engine_options));
  // A shape that overrides something of its material keeps the rest.
  for (const char* name : {"arm.a", "arm.b"})
    CHECK(has(model->materials[body(*model, name).shapes.at(0).material].engine_options));
  CHECK(model->materials[body(*model, "arm.c").shapes.at(0).material].engine_options.empty());

  const std::string two = R"(<box name="a" size="1 1 1"/><hinge name="j" child="a">)";
  CHECK(codes_of(two + "<tiny speed=\"1\"/></hinge>", options) == "CG0904");
  CHECK(codes_of(two + block + block + "</hinge>", options) == "CG0904");
  CHECK(codes_of(two + "<huge/></hinge>", options) == "CG0201");
}

TEST_CASE("the later joint closes the loop", "[dsl][joints]") {
  const std::string tip = R"(<hinge name="j3" child="b" xyz="2 0 0" axis="0 0 1"/>)";
  const auto model = compile_scene(arms("", "", tip));
  CHECK_FALSE(joint(*model, "j1").closes_loop);
  CHECK_FALSE(joint(*model, "j2").closes_loop);
  CHECK(joint(*model, "j3").closes_loop);
}

TEST_CASE("a loop that does not close is refused, one that does is started", "[dsl][joints]") {
  const std::string tip = R"(<hinge name="j3" child="b" xyz="2 0 0" axis="0 0 1"/>)";
  CHECK(codes_of(arms("position=\"10 deg\"", "", tip)) == "CG0605");
  // a parallelogram: opposite joints turn alike
  const auto model = compile_scene(R"(
    <box name="l" size="0.1 0.1 1" xyz="0 0 0.5"/>
    <box name="t" size="1 0.1 0.1" xyz="0.5 0 1"/>
    <box name="r" size="0.1 0.1 1" xyz="1 0 0.5"/>
    <hinge name="j1" child="l" xyz="0 0 0" axis="0 1 0" position="30 deg"/>
    <hinge name="j2" parent="l" child="t" xyz="0 0 1" axis="0 1 0" position="-30 deg"/>
    <hinge name="j3" parent="t" child="r" xyz="1 0 1" axis="0 1 0" position="30 deg"/>
    <hinge name="j4" child="r" xyz="1 0 0" axis="0 1 0"/>)");
  const Joint& last = joint(*model, "j4");
  CHECK(last.closes_loop);
  CHECK(last.position.at(0) == Approx(M_PI / 6));
  CHECK(near(body(*model, "t").X_WB.p, {0.5 + 0.5, 0, std::sqrt(3.0) / 2}, 1e-12));
}

TEST_CASE("each joint type has the axes and coordinates the model promises", "[dsl][joints]") {
  const auto model = compile_scene(R"(
    <box name="a" size="1 1 1" xyz="0 0 0"/> <box name="b" size="1 1 1" xyz="2 0 0"/>
    <box name="c" size="1 1 1" xyz="4 0 0"/> <box name="d" size="1 1 1" xyz="6 0 0"/>
    <box name="e" size="1 1 1" xyz="8 0 0"/> <box name="f" size="1 1 1" xyz="10 0 0"/>
    <box name="g" size="1 1 1" xyz="12 0 0"/> <box name="h" size="1 1 1" xyz="14 0 0"/>
    <box name="i" size="1 1 1" xyz="16 0 0"/>
    <gimbal name="gimbal" child="i" axis="0 0 1" axis2="1 0 0" lower="none -80 -40 deg"
            position="10 20 30 deg"/>
    <ball name="ball" child="a" upper="60 deg" damping="0.1 N*m*s/rad"/>
    <universal name="universal" child="b" axis="0 0 1" axis2="1 0 0"/>
    <fixed name="fixed" child="c"/>
    <cylindrical name="cylindrical" child="d" lower="none -10 cm" upper="none 10 cm"/>
    <planar name="planar" child="e"/>
    <screw name="screw" child="f" pitch="5 mm"/>
    <free name="free" child="g"/>
    <slider name="slider" child="h" lower="0" upper="1 m" max-effort="20 N"/>)");
  CHECK(joint(*model, "ball").axes.at(0).upper == Approx(M_PI / 3));
  CHECK(joint(*model, "universal").axes.size() == 2);
  CHECK(near(joint(*model, "universal").X_PF.q * Vec3::UnitX(), {0, 0, 1}));
  CHECK(near(joint(*model, "universal").X_PF.q * Vec3::UnitY(), {1, 0, 0}));
  CHECK(joint(*model, "fixed").axes.empty());
  CHECK(joint(*model, "cylindrical").axes.at(1).lower == Approx(-0.1));
  CHECK(std::isinf(joint(*model, "cylindrical").axes.at(0).lower));
  CHECK(joint(*model, "cylindrical").axes.at(0).lower < 0);
  CHECK(joint(*model, "planar").axes.size() == 3);
  CHECK(joint(*model, "screw").pitch == 0.005);
  CHECK(joint(*model, "free").position.at(3) == 1.0);
  CHECK(joint(*model, "slider").axes.at(0).max_effort == 20.0);
  const Joint& gimbal = joint(*model, "gimbal");
  CHECK(near(gimbal.X_PF.q * Vec3::UnitX(), {0, 0, 1}));
  CHECK(near(gimbal.X_PF.q * Vec3::UnitZ(), {0, 1, 0}));
  CHECK(gimbal.axes.at(2).lower == Approx(-40 * M_PI / 180));
  CHECK(gimbal.position.at(1) == Approx(M_PI / 9));
  CHECK(model->joint_speeds == 3 + 2 + 0 + 2 + 3 + 1 + 6 + 1 + 3);
}

TEST_CASE("motors and servos take limits, gains and targets in their joint's units",
          "[dsl][motors]") {
  const auto model = compile_scene(R"(
    <box name="a" size="1 1 1"/> <box name="b" size="1 1 1" xyz="2 0 0"/>
    <hinge name="h" child="a"/> <slider name="s" child="b"/>
    <motor name="m" joint="h" max-torque="0.6 N*m" max-speed="20 rad/s" target="60 rpm"/>
    <motor name="dc" joint="h" mode="dc" kt="0.02 N*m/A" resistance="1.5 ohm" target="6 V"/>
    <servo name="lift" joint="s" kp="200 N/m" kd="10 N*s/m" max-force="50 N" target="10 cm"/>)");
  REQUIRE(model->motors.size() == 3);
  CHECK(model->motors[0].max_effort == 0.6);
  CHECK(model->motors[0].target.value() == Approx(2 * M_PI));
  CHECK(model->motors[1].ke == 0.02);
  CHECK(model->motors[1].target.value() == 6.0);
  CHECK(model->motors[2].mode == MotorMode::servo);
  CHECK(model->motors[2].kp == 200.0);
  CHECK(model->motors[2].target.value() == Approx(0.1));
}

TEST_CASE("a target over time is a signal in the unit of the target", "[dsl][motors]") {
  const std::string parts = R"(<assembly name="bot">
    <box name="a" size="1 1 1"/> <box name="b" size="1 1 1" xyz="2 0 0"/>
    <hinge name="h" child="a"/> <slider name="s" child="b"/>)";
  const auto model = compile_scene(parts + R"(
    <motor name="m" joint="h" target-signal="sin(2 * pi * time / 1 s) * 30 deg/s + h.velocity"/>
    <servo name="lift" joint="s" kp="200 N/m" target-signal="0.1 m * h.position / 1 rad"/>
    </assembly>)");
  CHECK(model->motors[0].target_signal == "sin(2 * pi * time / 1 s) * 30 deg/s + bot.h.velocity");
  CHECK(model->motors[1].target_signal == "0.1 m * bot.h.position / 1 rad");
  const auto codes = [&](const std::string& motor) {
    return codes_of(parts + motor + "</assembly>");
  };
  CHECK(codes("<motor joint=\"h\" target-signal=\"sin(2 rad/s * time)\"/>") == "CG1201");
  CHECK(codes("<motor joint=\"h\" target-signal=\"1 m * sin(2 rad/s * time)\"/>") == "CG1201");
  CHECK(codes("<motor joint=\"h\" target-signal=\"c.x * 1 rad/s\"/>") == "CG1201");
  CHECK(codes("<motor joint=\"h\" target=\"1 rad/s\" target-signal=\"1 rad/s\"/>") == "CG0608");
}

TEST_CASE("a template has forces, springs and targets over time", "[dsl][motors]") {
  const auto model = compile_scene(R"(<template name="kite">
    <body name="a"> <box size="1 1 1"/> </body> <hinge name="h" child="a"/>
    <motor name="m" joint="h" target-signal="h.velocity"/>
    <force name="f" on="a" force="1 0 0" factor="a.x / 1 m"/>
    </template>)");
  const SceneModel& kite = *model->templates.at(0).fragment;
  CHECK(kite.motors.at(0).target_signal == "h.velocity");
  CHECK(kite.forces.at(0).factor == "a.x / 1 m");
}
