// Couplings, rotor inertias and weights of a source come to the scene.
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const char* const kLink =
    R"(<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>)";

std::string link(const std::string& name) {
  return "<link name=\"" + name + "\">" + kLink + "</link>";
}

std::string joint(const std::string& name, const std::string& child, const std::string& more) {
  return "<joint name=\"" + name + "\" type=\"revolute\"><parent link=\"base\"/><child link=\"" +
         child +
         "\"/><axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"5\" velocity=\"2\"/>" +
         more + "</joint>";
}

}  // namespace

TEST_CASE("mimic becomes a coupling", "[urdf]") {
  Imported in;
  // `second` comes before `first`, which it follows, and starts with it.
  in.read("<robot name=\"r\">" + link("base") + link("a") + link("b") + link("c") +
          joint("second", "b", R"(<mimic joint="first" multiplier="-0.5" offset="0.1"/>)") +
          joint("first", "a", R"(<mimic joint="zero" multiplier="2"/>)") + joint("zero", "c", "") +
          "</robot>");
  REQUIRE(in.model);
  const SceneModel& model = *in.model;
  REQUIRE(model.couplings.size() == 2);
  const auto named = [&](int joint) { return model.joints[joint].name; };
  CHECK(named(model.couplings[0].joint) == "r.first");
  CHECK(named(model.couplings[0].terms.at(0).joint) == "r.zero");
  CHECK(model.couplings[0].terms.at(0).ratio == 2.0);
  CHECK(named(model.couplings[1].joint) == "r.second");
  CHECK(model.couplings[1].terms.at(0).ratio == -0.5);
  CHECK(model.couplings[1].offset == 0.1);
  CHECK(in.joint("second").position.at(0) == 0.1);
}

TEST_CASE("couplings that cannot hold are left out", "[urdf]") {
  Imported in;
  const auto robot = [](const std::string& a, const std::string& b) {
    return "<robot name=\"r\">" + link("base") + link("a") + link("b") + joint("one", "a", a) +
           joint("two", "b", b) + "</robot>";
  };
  in.read(robot("", R"(<mimic joint="one" offset="3"/>)"));
  CHECK(
      in.reports(dsl::Fidelity::left_out, "coupling of joint 'two' to 'one'", "beyond its limits"));
  CHECK(in.model);
  in.read(robot(R"(<mimic joint="two"/>)", R"(<mimic joint="one"/>)"));
  CHECK(in.reports(dsl::Fidelity::left_out, "coupling of joint 'two' to 'one'", "form a cycle"));
  CHECK(in.model);
  in.read(robot("", R"(<mimic joint="nowhere"/>)"));
  CHECK(in.reports(dsl::Fidelity::left_out, "coupling of joint 'two'", "no joint 'nowhere'"));
}

TEST_CASE("armature, equality and gravcomp of MJCF come to the scene", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco model="m"><worldbody>
    <body name="a" gravcomp="1"><joint name="left" type="slide" axis="0 1 0" armature="0.3"/>
      <geom size="0.1" mass="1"/></body>
    <body name="b" pos="1 0 0" gravcomp="0.25"><joint name="right" type="slide" axis="0 1 0"/>
      <geom size="0.1" mass="1"/></body>
    </worldbody><equality><joint joint1="right" joint2="left" polycoef="0.02 -1 0 0 0"/></equality>
    </mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  const SceneModel& model = *in.model;
  CHECK(in.body("a").gravity_scale == 0.0);
  CHECK(in.body("b").gravity_scale == 0.75);
  CHECK(in.joint("left").axes.at(0).rotor_inertia == 0.3);
  REQUIRE(model.couplings.size() == 1);
  CHECK(model.couplings[0].offset == 0.02);
  CHECK(model.couplings[0].terms.at(0).ratio == -1.0);
}

TEST_CASE("a joint that follows another has limits that exclude zero", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco><worldbody>
    <body name="a"><joint name="left" type="slide" range="0.02 0.05"/><geom size="0.1" mass="1"/></body>
    <body name="b" pos="1 0 0"><joint name="right" type="slide" range="-0.05 -0.02"/>
      <geom size="0.1" mass="1"/></body>
    </worldbody><equality><joint joint1="left" joint2="right" polycoef="0 -1 0 0 0"/></equality>
    </mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  REQUIRE(in.model->couplings.size() == 1);
  CHECK(in.joint("right").position.at(0) == -0.02);
  CHECK(in.joint("left").position.at(0) == 0.02);
}

TEST_CASE("a link of SDF without gravity is weightless", "[sdf]") {
  Imported in;
  in.read(R"(<sdf version="1.9"><model name="m"><link name="a"><gravity>false</gravity><inertial>
    <mass>1</mass></inertial></link></model></sdf>)",
          "m.sdf");
  REQUIRE(in.model);
  CHECK(in.body("a").gravity_scale == 0.0);
}

// Each start was found by following the chain to its end, and each name by reading all: the cube of
// the length.
TEST_CASE("a long chain of couplings is read in bounded time", "[urdf][hostile]") {
  constexpr int kLength = 2000;
  std::string robot = "<robot name=\"r\">" + link("base");
  for (int i = 0; i < kLength; ++i) {
    const std::string number = std::to_string(i);
    const std::string mimic =
        i + 1 < kLength ? "<mimic joint=\"j" + std::to_string(i + 1) + "\"/>" : std::string();
    robot += link("l" + number) + joint("j" + number, "l" + number, mimic);
  }
  Imported in;
  in.options.scene_folder = in.folder.path.string();
  in.result = dsl::import_model(in.folder.write("robot.urdf", robot + "</robot>"), in.options);
  std::size_t couplings = 0;
  for (std::size_t at = 0; (at = in.result.scene.find("<couple ", at)) != std::string::npos; ++at)
    ++couplings;
  CHECK(couplings == kLength - 1);
  // The last of the chain, which no other precedes, stands first.
  CHECK(in.result.scene.find("<couple joint=\"j1998\" to=\"j1999\"/>") <
        in.result.scene.find("<couple joint=\"j1997\" to=\"j1998\"/>"));
}

TEST_CASE("a loop with a joint that a coupling moves at the start is left out", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco><compiler angle="radian"/><worldbody>
    <body name="a"><freejoint/><geom size="0.1"/>
      <body name="b"><joint name="hip" axis="0 0 1"/><geom size="0.1"/></body></body>
    <body name="c"><joint name="x" type="slide" axis="1 0 0"/><geom size="0.1"/></body></worldbody>
    <equality><connect name="loop" body1="b" body2="c" anchor="0 0 0"/><weld name="held" body1="a"/>
      <joint joint1="hip" joint2="x" polycoef="1 2"/></equality></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "loop 'loop'", "coupling"));
  CHECK(in.joint("held").type == JointType::fixed);
}
