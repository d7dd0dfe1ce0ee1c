// Parameters, prototypes, repeats, conditions and scopes.
#include <chrono>

#include "build_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const char* const kRobot = R"xml(
  <param name="wheel_r" type="length" default="4 cm" min="1 cm" max="10 cm"/>
  <physics backend="bullet" step="1 ms" seed="42"/>
  <material name="rubber" density="1100 kg/m^3" friction="0.9" color="#202020"/>
  <material name="ply"    density="600 kg/m^3"  friction="0.5"/>
  <prototype name="DiffBot">
    <param name="r" type="length"/>
    <param name="track" type="length" default="18 cm"/>
    <assembly name="robot">
      <assembly name="chassis" rigid="true" xyz="0 0 ${r}">
        <box      name="deck"   size="24 14 4 cm" mass="1.2 kg" material="ply"/>
        <cylinder name="mast"   radius="1 cm" length="12 cm" mass="80 g" xyz="8 0 8 cm"/>
        <sphere   name="caster" radius="${r/2}" mass="50 g" friction="0" xyz="-9 cm 0 ${-r/2}"/>
        <frame    name="eye"    xyz="8 0 14 cm" rpy="0 10 0 deg"/>
      </assembly>
      <for var="side y" in="[['left', 1], ['right', -1]]">
        <cylinder name="wheel_${side}" radius="${r}" length="2 cm" mass="150 g" material="rubber"
                  xyz="0 ${y*track/2} ${r}" rpy="90 0 0 deg"/>
        <hinge name="axle_${side}" parent="chassis" child="wheel_${side}" frame="wheel_${side}" axis="0 0 -1"/>
        <motor name="${side}" joint="axle_${side}" mode="velocity" max-torque="0.6 N*m" max-speed="20 rad/s"/>
      </for>
      <repeat count="5" var="i">
        <pose name="pose_${i}" on="chassis" xyz="12 0 0 cm" rpy="0 0 ${(i-2)*30 deg}" rate="50 Hz"
              noise="normal(0, 3 mm)"/>
      </repeat>
      <controller plugin="wall_follower" rate="50 Hz"/>
    </assembly>
  </prototype>
  <light name="sun" type="directional" direction="0.3 0.2 -1"/>
  <plane name="floor" material="ply"/>
  <frame name="start" xyz="1 0 0" rpy="0 0 90 deg"/>
  <instance of="DiffBot" name="bot" r="${wheel_r}" at="start"/>)xml";

}  // namespace

TEST_CASE("the iteration number of a repeat is i by default", "[dsl][expand]") {
  const auto model = compile_scene(R"(
    <repeat count="3"><sphere name="s_${i}" radius="${(i+1) * 1 cm}" xyz="${i * 1 m} 0 1"/></repeat>)");
  REQUIRE(model->bodies.size() == 3);
  CHECK(near(body(*model, "s_2").X_WB.p, {2, 0, 1}));
}

TEST_CASE("a robot from a prototype", "[dsl][expand]") {
  const auto model = compile_scene(kRobot);
  REQUIRE(model->bodies.size() == 4);
  CHECK(body(*model, "bot.robot.chassis").mass == Approx(1.33));
  // 9 cm to the left of a robot that looks along y
  CHECK(near(body(*model, "bot.robot.wheel_left").X_WB.p, {1 - 0.09, 0, 0.04}));
  CHECK(model
            ->materials[static_cast<std::size_t>(
                body(*model, "bot.robot.wheel_left").shapes[0].material)]
            .name == "rubber");
  REQUIRE(model->motors.size() == 2);
  CHECK(model->motors[1].name == "bot.robot.right");
  REQUIRE(model->sensors.size() == 5);
  CHECK(model->sensors[4].name == "bot.robot.pose_4");
  CHECK(model->sensors[4].noise.at(0).b == Approx(0.003));
  REQUIRE(model->controllers.size() == 1);
  CHECK(model->controllers[0].name == "bot.robot.wall_follower");
  REQUIRE(model->assemblies.size() == 3);
  CHECK(model->assemblies[1].name == "bot.robot");
  CHECK(model->assemblies[1].parent == 0);
  CHECK(near(model->lights.at(0).X_WL.q * Vec3::UnitX(), Vec3(0.3, 0.2, -1).normalized()));
}

TEST_CASE("a value set from outside replaces a parameter's default and is checked like it",
          "[dsl][expand]") {
  dsl::CompileOptions options;
  options.set_parameters["wheel_r"] = "5 cm";
  CHECK(near(body(*compile_scene(kRobot, options), "bot.robot.chassis").X_WB.p, {1, 0, 0.05}));
  options.set_parameters["wheel_r"] = "50 cm";
  CHECK(codes_of(kRobot, options) == "CG0309");
  options.set_parameters["wheel_r"] = "5 kg";
  CHECK(codes_of(kRobot, options) == "CG0310");
  options.set_parameters = {{"weel_r", "5 cm"}};
  const auto result = dsl::compile_text(
      "<scene name=\"t\" version=\"1\"><param name=\"wheel_r\" default=\"1\"/></scene>", "t",
      options);
  REQUIRE(result.diagnostics.size() >= 1);
  CHECK(result.diagnostics[0].code == "CG0307");
  CHECK(result.diagnostics[0].help.find("wheel_r") != std::string::npos);
}

TEST_CASE("a value set from outside needs no blank before its unit", "[dsl][expand]") {
  // The value of --set p=WORD in the scene, as text; "CODE: message (help)" where it is refused.
  const auto made = [](const std::string& param, const std::string& word) {
    dsl::CompileOptions options;
    options.set_parameters["p"] = word;
    const auto result = dsl::compile_text("<scene version=\"1\"><param name=\"p\" " + param +
                                              "/><box name=\"b\" size=\"1 1 1\"/><plot name=\"t\" "
                                              "y=\"b.x\" title=\"${p}\"/></scene>",
                                          "t", options);
    if (result.ok()) return result.model->plots.at(0).title;
    const Diagnostic& first = result.diagnostics.at(0);
    return first.code + ": " + first.message + (first.help.empty() ? "" : " (" + first.help + ")");
  };
  CHECK(made("default=\"1 m\"", "1cm") == "0.01 m");
  CHECK(made("default=\"1 m\"", "1 cm") == "0.01 m");
  CHECK(made("type=\"length\"", "-2.5e-1m") == "-0.25 m");
  CHECK(made("type=\"int\"", "2e3") == "2000");
  CHECK(made("type=\"bool\"", "true") == "true");
  CHECK(made("type=\"text\"", "2m") == "2m");
  CHECK(made("default=\"blue\"", "red") == "red");
  CHECK(made("default=\"0\"", "1 2 3 m") == "[1 m, 2 m, 3 m]");
  CHECK(made("default=\"0\"", "1cm 2cm 3m") == "[0.01 m, 0.02 m, 3 m]");
  CHECK(made("type=\"list\"", "[1, 2 m]") == "[1, 2 m]");
  CHECK(made("default=\"a\"", "[x") == "[x");
  CHECK(made("default=\"a\"", "2nd") == "2nd");
  CHECK(made("type=\"length\"", "2 kg") == "CG0310: --set p=2 kg: expected a length, found a mass");
  CHECK(made("type=\"length\"", "2metres") ==
        "CG0310: --set p=2metres: expected a length, found the text \"2metres\" "
        "(did you mean \"2 m\"?)");
  CHECK(made("type=\"length\"", "1,5") ==
        "CG0310: --set p=1,5: expected a length, found the text \"1,5\" "
        "(did you mean \"1.5\"? numbers have a decimal point)");
  CHECK(made("type=\"length\"", "") == "CG0310: --set p=: expected a length, found nothing");
  CHECK(made("type=\"int\"", "two") ==
        "CG0310: --set p=two: expected a whole number, found the text \"two\"");
  // A long word is processed once, not once for each of its letters.
  CHECK(made("default=\"a\"", std::string(60000, '1') + "x").size() == 60001);
}

TEST_CASE("a number joined to its unit is reported where a number is expected", "[dsl][expand]") {
  const auto help_of = [](const std::string& inside) {
    const auto result = dsl::compile_text("<scene version=\"1\">" + inside + "</scene>", "t");
    REQUIRE_FALSE(result.diagnostics.empty());
    return result.diagnostics[0].help;
  };
  const std::string use = "<sphere name=\"s\" radius=\"";
  CHECK(help_of(use + "2m\"/>") == "did you mean \"2 m\"?");
  CHECK(help_of("<param name=\"r\" default=\"2m\"/>" + use + "${r}\"/>") ==
        "did you mean \"2 m\"?");
  CHECK(help_of("<param name=\"r\" default=\"2m\"/>" + use + "${r * 2}\"/>") ==
        "did you mean \"2 m\"?");
  CHECK(help_of("<param name=\"r\" default=\"2m\" type=\"length\"/>" + use + "${r}\"/>") ==
        "did you mean \"2 m\"?");
  CHECK(help_of("<param name=\"r\" default=\"2 m\"/>" + use + "${r + 2m}\"/>").find("2 m") !=
        std::string::npos);
}

TEST_CASE("names are looked up outwards, and instances have scopes of their own",
          "[dsl][expand]") {
  const auto model = compile_scene(R"(
    <prototype name="Pair">
      <box name="a" size="1 1 1"/> <box name="b" size="1 1 1" xyz="2 0 0"/>
      <hinge name="j" parent="a" child="b"/>
      <export name="tip" of="b"/>
    </prototype>
    <instance of="Pair" name="p"/>
    <instance of="Pair" name="q" xyz="0 5 0"/>
    <box name="lid" size="1 1 1" frame="q.tip" xyz="0 0 2"/>
    <fixed name="glue" parent="q.tip" child="lid"/>)");
  CHECK(joint(*model, "q.j").parent == find_body(*model, "q.a"));
  CHECK(joint(*model, "glue").parent == find_body(*model, "q.b"));
  CHECK(near(body(*model, "lid").X_WB.p, {2, 5, 2}));
}

TEST_CASE("prototypes may contain themselves as long as an if ends it", "[dsl][expand]") {
  const auto model = compile_scene(R"(
    <prototype name="Tower"> <param name="n" type="int"/>
      <box name="brick" size="1 1 1"/>
      <if test="n gt 1"> <instance of="Tower" name="up" n="${n-1}" xyz="0 0 1"/> </if>
    </prototype>
    <instance of="Tower" name="t" n="4"/>)");
  CHECK(model->bodies.size() == 4);
  CHECK(near(body(*model, "t.up.up.up.brick").X_WB.p, {0, 0, 3}));
  CHECK(codes_of(R"(
    <prototype name="T"> <instance of="T" name="t"/> </prototype> <instance of="T" name="x"/>)") ==
        "CG0305");
}

TEST_CASE("random numbers follow the seed and the element, not the order", "[dsl][expand]") {
  const std::string thing = R"(<box name="b" size="1 1 1" xyz="${uniform(0, 1)} 0 5"/>)";
  dsl::CompileOptions options;
  const double alone = body(*compile_scene(thing, options), "b").X_WB.p.x();
  const double later =
      body(*compile_scene(R"(<box name="a" size="1 1 1" xyz="${uniform(0, 1)} 9 5"/>)" + thing,
                          options),
           "b")
          .X_WB.p.x();
  CHECK(alone == later);
  options.seed = 7;
  CHECK(body(*compile_scene(thing, options), "b").X_WB.p.x() != alone);
}

TEST_CASE("ten thousand bodies, repeated and spelled out, are the same scene", "[dsl][expand]") {
  std::string spelled;
  for (int i = 0; i < 10000; ++i)
    spelled += "<box name=\"b_" + std::to_string(i) +
               "\" size=\"10 10 10 cm\" mass=\"1 kg\" xyz=\"" + std::to_string(i % 100) + " " +
               std::to_string(i / 100) + " 1\"/>\n";
  const auto a = compile_scene(R"(<repeat count="10000" var="i">
    <box name="b_${i}" size="10 10 10 cm" mass="1 kg" xyz="${i % 100} ${floor(i/100)} 1"/>
  </repeat>)");
  const auto b = compile_scene(spelled);
  REQUIRE(a->bodies.size() == 10000);
  REQUIRE(b->bodies.size() == 10000);
  CHECK(a->bodies[1234].name == b->bodies[1234].name);
  CHECK(a->bodies[1234].X_WB.p == b->bodies[1234].X_WB.p);
}

TEST_CASE("one mistake is one message", "[dsl][expand]") {
  // nothing that depends on the faulty element is reported
  CHECK(codes_of(R"(
    <box name="a" size="1 1 kg 1"/> <box name="b" size="1 1 1" frame="a"/>
    <hinge name="j" parent="a" child="b"/> <motor joint="j" name="m"/>)")
            .find(' ') == std::string::npos);
  CHECK(
      codes_of(
          R"(<bxo name="a" size="1 1 1"/> <hinge name="j" child="a"/> <motor name="m" joint="j"/>)") ==
      "CG0201");
  CHECK(codes_of(
            R"(<repeat count="-1"> <box name="a" size="1 1 1"/> </repeat> <hinge child="a"/>)") ==
        "CG0311");
  // the same mistake in every iteration is reported once
  CHECK(codes_of(R"(<repeat count="9" var="i"> <box name="a_${i}" size="1 1"/> </repeat>)")
            .find(' ') == std::string::npos);
}
