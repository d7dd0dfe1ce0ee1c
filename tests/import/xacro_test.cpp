#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const std::string kBox =
    "<xacro:macro name=\"mass\" params=\"m:=1\"><inertial><mass value=\"${m}\"/>"
    "<inertia ixx=\"${m/12}\" iyy=\"${m/12}\" izz=\"${m/12}\"/></inertial></xacro:macro>\n";

}  // namespace

TEST_CASE("properties, macros, blocks, conditions and expressions", "[xacro]") {
  Imported in;
  in.read(kXacroHead + kBox + R"(
    <xacro:property name="n" value="3"/>
    <xacro:property name="twice" value="${2*n}"/>
    <xacro:property name="table" value="${dict()}"/>
    <xacro:macro name="leg" params="name side:=1 *where **more mass:=^|0.5">
      <link name="${name}"><xacro:mass m="${mass if side &gt; 0 else 2*mass}"/><xacro:insert_block name="more"/></link>
      <joint name="hip_${name}" type="continuous"><parent link="base"/><child link="${name}"/>
        <xacro:insert_block name="where"/><axis xyz="0 ${side} 0"/></joint>
    </xacro:macro>
    <link name="base"><xacro:mass m="${twice + sin(radians(30))}"/></link>
    <xacro:leg name="left"><origin xyz="0 ${n/10} 0"/><more/></xacro:leg>
    <xacro:leg name="right" side="-1"><origin xyz="0 ${-n/10} 0"/><more/></xacro:leg>
    <xacro:if value="${n == 3 and 'ab' in 'cabs'}"><link name="never"/><joint name="f" type="fixed"><parent link="base"/><child link="never"/></joint></xacro:if>
    <xacro:unless value="true"><link name="gone"/></xacro:unless>
  </robot>)",
          "robot.urdf.xacro");
  REQUIRE(in.model);
  CHECK(in.body("base").mass == Approx(6.5));
  CHECK(in.body("left").mass == 0.5);
  CHECK(in.body("right").mass == 1.0);
  CHECK((in.body("right").X_WB.p - in.body("left").X_WB.p - Vec3(0, -0.6, 0)).norm() < 1e-12);
  CHECK(in.frame("never").body == in.frame("never").body);
}

TEST_CASE("files are included and YAML is read", "[xacro]") {
  Imported in;
  in.folder.write("parts/legs.xacro", "<robot xmlns:xacro=\"x\">" + kBox + "</robot>");
  in.folder.write("config/sizes.yaml",
                  "masses:\n  base: 4.5\n  list: [1, 2, 3]\nangle: !degrees 90\n");
  in.options.arguments["size"] = "7";
  in.read(kXacroHead + R"x(
    <xacro:arg name="size" default="1"/>
    <xacro:include filename="parts/legs.xacro"/>
    <xacro:arg name="folder" default="config"/>
    <xacro:property name="sizes" value="${xacro.load_yaml('$(arg folder)/sizes.yaml')}"/>
    <link name="base"><xacro:mass m="${sizes['masses']['base'] + sizes.masses.list[1] + $(arg size)}"/></link>
  </robot>)x");
  REQUIRE(in.model);
  CHECK(in.body("base").mass == Approx(13.5));
  // No variable of the environment is set for a model: $(optenv …) has its default.
  in.read(kXacroHead + kBox +
          "<link name=\"b\"><xacro:mass m=\"$(optenv HOME 3)\"/></link></robot>");
  REQUIRE(in.model);
  CHECK(in.body("b").mass == 3.0);
}

TEST_CASE("what is wrong in a xacro file is reported at its line", "[xacro]") {
  Imported in;
  const auto fails = [&](const std::string& text, const std::string& message, int line) {
    in.read(kXacroHead + kBox + text + "</robot>");
    INFO(text);
    for (const Diagnostic& d : in.result.diagnostics)
      INFO(d.line << ": " << d.message << "; " << d.help);
    CHECK(in.refuses("CG1411", message, line));
  };
  std::string nested = "1";
  for (int i = 0; i < 5000; ++i) nested = "${" + nested + "}";
  fails("<xacro:maas m=\"1\"/>", "did you mean <xacro:mass>?", 3);
  fails("<link name=\"${x}\"/>", "'x' is not defined", 3);
  fails("<link name=\"${1/0}\"/>", "a division by zero", 3);
  fails("<xacro:mass n=\"1\"/>", "has no parameter 'n'", 3);
  fails("\n<xacro:if value=\"perhaps\"/>", "neither true nor false", 4);
  fails("<xacro:include filename=\"../outside.xacro\"/>", "lies outside", 3);
  fails("<link name=\"$(env HOME)\"/>", "are not read", 3);
  fails("<link name=\"" + nested + "\"/>", "nested too deep", 3);
  fails("<link name=\"${abs()}\"/>", "abs() has too few arguments", 3);
  for (const char* piece : {"(", "[", "-", "not ", "abs(", "2**", "1 if 0 else "}) {
    std::string deep;
    for (int i = 0; i < 1000; ++i) deep += piece;
    fails("<link name=\"${" + deep + "1}\"/>", "nested too deep", 3);
  }
  fails("<xacro:property name=\"a\" value=\"${a}\"/><link name=\"${a}\"/>", "is defined by itself",
        3);
}

TEST_CASE("macros that make nothing and call each other twice are bounded", "[xacro]") {
  std::string text = "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">";
  for (int i = 0; i < 60; ++i) {
    const std::string call = "<xacro:m" + std::to_string(i + 1) + "/>";
    text += "<xacro:macro name=\"m" + std::to_string(i) + "\" params=\"\">" + call + call +
            "</xacro:macro>";
  }
  text += "<xacro:macro name=\"m60\" params=\"\"/><xacro:m0/><link name=\"a\"/></robot>";
  Imported in;
  in.read(text, "r.urdf.xacro");
  CHECK(in.result.scene.empty());
  REQUIRE(in.result.diagnostics.size() == 1);
  CHECK(in.result.diagnostics[0].code == "CG1402");
}
