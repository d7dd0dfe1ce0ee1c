// Files that someone made to do harm: a coded error in bounded time and memory.
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

TEST_CASE("macros that call each other without end are refused", "[hostile]") {
  Imported in;
  in.read(kXacroHead + "<xacro:macro name=\"m\"><xacro:m/></xacro:macro><xacro:m/></robot>");
  CHECK(in.refuses("CG1402", "deep"));
  std::string nested = kXacroHead;
  for (int i = 0; i < 10000; ++i)
    nested += "<xacro:macro name=\"m" + std::to_string(i) + "\"><xacro:m" + std::to_string(i + 1) +
              "/></xacro:macro>\n";
  in.read(nested + "<xacro:m0/></robot>");
  CHECK(in.refuses("CG1402", "deep"));
}

TEST_CASE("a macro that doubles at each level is refused", "[hostile]") {
  Imported in;
  std::string text = kXacroHead + "<xacro:macro name=\"m0\"><link name=\"x\"/></xacro:macro>\n";
  for (int i = 1; i < 40; ++i) {
    const std::string inner = "<xacro:m" + std::to_string(i - 1) + "/>";
    text +=
        "<xacro:macro name=\"m" + std::to_string(i) + "\">" + inner + inner + "</xacro:macro>\n";
  }
  in.read(text + "<xacro:m39/></robot>");
  CHECK(in.refuses("CG1402", "too much to read"));
}

TEST_CASE("texts and lists do not grow without end", "[hostile]") {
  Imported in;
  std::string text = kXacroHead + "<xacro:property name=\"a0\" value=\"xxxxxxxxxxxxxxxx\"/>\n";
  for (int i = 1; i < 60; ++i)
    text += "<xacro:property name=\"a" + std::to_string(i) + "\" value=\"${a" +
            std::to_string(i - 1) + " + a" + std::to_string(i - 1) + "}\"/>\n";
  in.read(text + "<link name=\"${a59}\"/></robot>");
  CHECK(in.refuses("CG1411", "grow"));
  in.read(kXacroHead + "<link name=\"${" + std::string(50000, '(') + "}\"/></robot>");
  CHECK(in.refuses("CG1411", "nested too deep"));
  in.read(kXacroHead + "<link name=\"${2**2**2**2**2**2}\"/></robot>");
  CHECK(in.refuses("CG1411", "not a finite number"));
}

TEST_CASE("files that include each other are refused", "[hostile]") {
  Imported in;
  in.folder.write("b.xacro",
                  "<robot xmlns:xacro=\"x\"><xacro:include filename=\"robot.urdf\"/></robot>");
  in.read(kXacroHead + "<xacro:include filename=\"b.xacro\"/></robot>");
  CHECK(in.refuses("CG1402", "cycle"));
}

TEST_CASE("bombs of YAML are refused", "[hostile]") {
  Imported in;
  std::string bomb = "a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n";
  for (int i = 1; i < 12; ++i) {
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [";
    for (int k = 0; k < 10; ++k)
      bomb += (k > 0 ? "," : "") + std::string("*a") + std::to_string(i - 1);
    bomb += "]\n";
  }
  in.folder.write("bomb.yaml", bomb);
  in.read(kXacroHead + "<link name=\"${len(xacro.load_yaml('bomb.yaml'))}\"/></robot>");
  CHECK(in.refuses("CG1411", "100000 values"));
}

TEST_CASE("names from a file run nothing and leave no folder", "[hostile]") {
  Imported in;
  in.read(
      "<robot name=\"$(touch x)\"><link name=\"$(echo hi)\"><inertial><mass value=\"1\"/>"
      "<inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link></robot>");
  REQUIRE(in.model);
  CHECK(in.result.scene.find("$(") == std::string::npos);
  CHECK(in.result.scene.find("${") == std::string::npos);
  in.read(
      "<robot name=\"r\"><link name=\"${1}\"><inertial><mass value=\"1\"/>"
      "<inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link></robot>");
  REQUIRE(in.model);
}

TEST_CASE("numbers that are none are refused at their element", "[hostile]") {
  Imported in;
  in.read(
      "<robot name=\"r\">\n<link name=\"a\"><inertial><mass "
      "value=\"nan\"/></inertial></link></robot>");
  CHECK(in.refuses("CG1403", "'nan' is not a number", 2));
  in.read(
      "<robot name=\"r\">\n<link name=\"a\"><inertial><mass "
      "value=\"1e999\"/></inertial></link></robot>");
  CHECK(in.refuses("CG1403", "is not a number", 2));
  in.read("<robot name=\"r\"><link name=\"a\"/><!DOCTYPE a></robot>");
  CHECK(in.result.scene.empty());
}

TEST_CASE("entities and document types are not expanded", "[hostile]") {
  Imported in;
  std::string bomb = "<!DOCTYPE robot [<!ENTITY a0 \"aaaaaaaaaa\">";
  for (int i = 1; i < 10; ++i) {
    bomb += "<!ENTITY a" + std::to_string(i) + " \"";
    for (int k = 0; k < 10; ++k) bomb += "&a" + std::to_string(i - 1) + ";";
    bomb += "\">";
  }
  in.read(bomb + "]>\n<robot name=\"&a9;\"><link name=\"a\"/></robot>");
  CHECK(in.result.scene.empty());
  REQUIRE_FALSE(in.result.diagnostics.empty());
  in.read(
      "<!DOCTYPE r [<!ENTITY f SYSTEM \"file:///etc/passwd\">]><robot name=\"r\"><link "
      "name=\"&f;\"/></robot>");
  CHECK(in.result.scene.empty());
}

TEST_CASE("a mesh that claims more than it has is left out", "[hostile]") {
  Imported in;
  const auto robot = [](const std::string& file) {
    return "<robot name=\"r\">\n<link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
           "iyy=\"1\" izz=\"1\"/></inertial><collision><geometry><mesh filename=\"" +
           file + "\"/></geometry></collision></link></robot>";
  };
  std::string stl(84, '\0');
  stl[80] = stl[81] = stl[82] = '\xff';
  stl[83] = 1;  // 33 million triangles, 1.7 GB
  in.folder.write("claim.stl", stl);
  in.read(robot("claim.stl"));
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "mesh 'claim.stl'", "claim.stl"));
  // A COLLADA mesh whose nodes contain each other, and one whose count is larger than its numbers.
  in.folder.write(
      "loop.dae",
      "<COLLADA><library_nodes><node id=\"a\"><instance_node url=\"#b\"/></node>"
      "<node id=\"b\"><instance_node url=\"#a\"/><instance_node url=\"#a\"/></node></library_nodes>"
      "<library_visual_scenes><visual_scene id=\"s\"><node><instance_node url=\"#a\"/></node>"
      "</visual_scene></library_visual_scenes><scene><instance_visual_scene "
      "url=\"#s\"/></scene></COLLADA>");
  in.read(robot("loop.dae"));
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "mesh 'loop.dae'", "cycle"));
  in.folder.write(
      "short.dae",
      "<COLLADA><library_geometries><geometry><mesh><source id=\"p\"><float_array "
      "count=\"1000000000\">"
      "0 0 0 1 0 0 0 1 0</float_array></source><vertices id=\"v\"><input semantic=\"POSITION\" "
      "source=\"#p\"/></vertices><triangles count=\"1000000000\"><input semantic=\"VERTEX\" "
      "source=\"#v\" offset=\"0\"/><p>0 1 "
      "99</p></triangles></mesh></geometry></library_geometries></COLLADA>");
  in.read(robot("short.dae"));
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "mesh 'short.dae'", "beyond the corners"));
}

TEST_CASE("deep and wide files are refused", "[hostile]") {
  Imported in;
  std::string deep = "<robot name=\"r\">";
  for (int i = 0; i < 100000; ++i) deep += "<link>";
  in.read(deep);
  CHECK(in.result.scene.empty());
  std::string bodies = "<mujoco><worldbody>";
  for (int i = 0; i < 1000; ++i) bodies += "<body>";
  in.read(bodies, "m.xml");
  CHECK(in.result.scene.empty());
  in.folder.write("a.xml", "<mujoco><include file=\"a.xml\"/></mujoco>");
  in.read("<mujoco><include file=\"a.xml\"/></mujoco>", "m.xml");
  CHECK(in.refuses("CG1402", "cycle"));
}

TEST_CASE("files outside the model's folder are not read", "[hostile]") {
  Imported in;
  in.folder.write("secret.yaml", "key: 1\n");
  in.folder.write("secret.xml", "<mujoco/>");
  in.read(kXacroHead + "<link name=\"${xacro.load_yaml('../secret.yaml')['key']}\"/></robot>",
          "robot/r.urdf");
  CHECK(in.refuses("CG1411", "lies outside", 2));
  in.read("<mujoco>\n<include file=\"../secret.xml\"/></mujoco>", "robot/m.xml");
  CHECK(in.refuses("CG1412", "lies outside", 2));
  std::filesystem::create_symlink(in.folder / "secret.xml", in.folder.path / "robot" / "link.xml");
  in.read("<mujoco>\n<include file=\"link.xml\"/></mujoco>", "robot/m.xml");
  CHECK(in.refuses("CG1412", "lies outside", 2));
}

TEST_CASE("models of SDF that include each other are refused", "[hostile]") {
  Imported in;
  const std::string include = "<include><uri>m.sdf</uri></include>";
  in.read("<sdf version=\"1.9\"><model name=\"m\">" + include + include + "</model></sdf>",
          "m.sdf");
  CHECK(in.refuses("CG1402", "cycle"));
}

TEST_CASE("a mesh of a gigabyte is not read", "[hostile]") {
  Imported in;
  in.folder.write("big.stl", std::string(84, '\0'));
  std::filesystem::resize_file(in.folder / "big.stl", std::uintmax_t{1} << 30);
  in.read(
      "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
      "iyy=\"1\" "
      "izz=\"1\"/></inertial><collision><geometry><mesh filename=\"big.stl\"/></geometry>"
      "</collision></link></robot>");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "mesh 'big.stl'", "big.stl"));
}

TEST_CASE("names of meshes and models lead to no file outside", "[hostile]") {
  Imported in;
  const std::string tetrahedron =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const std::string outside = in.folder.write("parts/t.obj", tetrahedron);
  in.folder.write(".hidden/t.obj", tetrahedron);
  in.folder.write("robot/.hidden/t.obj", tetrahedron);
  const auto robot = [](const std::string& file) {
    return "<robot name=\"r\">\n<link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
           "iyy=\"1\" izz=\"1\"/></inertial><collision><geometry><mesh filename=\"" +
           file + "\"/></geometry></collision></link></robot>";
  };
  for (const std::string& name :
       {std::string("../parts/t.obj"), outside, "file://" + outside,
        std::string("package://.hidden/t.obj"), std::string("package://robot/.hidden/t.obj"),
        std::string("package://robot/../parts/t.obj"), std::string("package://parts/t.obj")}) {
    INFO(name);
    in.read(robot(name), "robot/r.urdf");
    CHECK(in.reports(kLeftOut, "mesh '" + name + "'"));
    CHECK(in.model->meshes.empty());
  }
  in.folder.write("parts/package.xml", "<package/>");
  in.read(robot("package://parts/t.obj"), "robot/r.urdf");
  REQUIRE(in.model);
  CHECK(in.model->meshes.size() == 1);
  in.options.packages = {{"any", (in.folder / "parts")}};
  in.read(robot("package://any/t.obj"), "robot/r.urdf");
  REQUIRE(in.model);
  CHECK(in.model->meshes.size() == 1);
  in.options.packages.clear();

  in.folder.write("secret.sdf",
                  "<sdf version=\"1.9\"><model name=\"s\"><link name=\"l\"/></model></sdf>");
  in.read(
      "<sdf version=\"1.9\"><model name=\"m\"><link name=\"own\"/><include><uri>../secret.sdf</uri>"
      "</include></model></sdf>",
      "robot/m.sdf");
  CHECK(in.reports(kLeftOut, "include '../secret.sdf'", "lies outside"));
  in.folder.write("secret.xacro", kXacroHead + "</robot>");
  in.read(kXacroHead + "<xacro:include filename=\"../secret.xacro\"/></robot>", "robot/r.urdf");
  CHECK(in.refuses("CG1411", "lies outside", 2));
}
