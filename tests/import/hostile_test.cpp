// Files that someone made to do harm: a coded error in bounded time and memory.
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {
const std::string kHead = "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n";
}

TEST_CASE("macros that call each other without end are refused", "[hostile]") {
  Imported in;
  in.read(kHead + "<xacro:macro name=\"m\"><xacro:m/></xacro:macro><xacro:m/></robot>");
  CHECK(in.refuses("CG1402", "deep"));
  std::string nested = kHead;
  for (int i = 0; i < 10000; ++i)
    nested += "<xacro:macro name=\"m" + std::to_string(i) + "\"><xacro:m" + std::to_string(i + 1) +
              "/></xacro:macro>\n";
  in.read(nested + "<xacro:m0/></robot>");
  CHECK(in.refuses("CG1402", "deep"));
}

TEST_CASE("a macro that doubles at each level is refused", "[hostile]") {
  Imported in;
  std::string text = kHead + "<xacro:macro name=\"m0\"><link name=\"x\"/></xacro:macro>\n";
  for (int i = 1; i < 40; ++i) {
    const std::string inner = "<xacro:m" + std::to_string(i - 1) + "/>";
    text += "<xacro:macro name=\"m" + std::to_string(i) + "\">" + inner + inner + "</xacro:macro>\n";
  }
  in.read(text + "<xacro:m39/></robot>");
  CHECK(in.refuses("CG1402", "elements"));
}

TEST_CASE("texts and lists do not grow without end", "[hostile]") {
  Imported in;
  std::string text = kHead + "<xacro:property name=\"a0\" value=\"xxxxxxxxxxxxxxxx\"/>\n";
  for (int i = 1; i < 60; ++i)
    text += "<xacro:property name=\"a" + std::to_string(i) + "\" value=\"${a" + std::to_string(i - 1) +
            " + a" + std::to_string(i - 1) + "}\"/>\n";
  in.read(text + "<link name=\"${a59}\"/></robot>");
  CHECK(in.refuses("CG1411", "grow"));
  in.read(kHead + "<link name=\"${" + std::string(50000, '(') + "}\"/></robot>");
  CHECK(in.refuses("CG1411", "nested too deep"));
  in.read(kHead + "<link name=\"${2**2**2**2**2**2}\"/></robot>");
  CHECK(in.result.scene.empty());
}

TEST_CASE("files that include each other are refused", "[hostile]") {
  Imported in;
  in.folder.write("b.xacro", "<robot xmlns:xacro=\"x\"><xacro:include filename=\"robot.urdf\"/></robot>");
  in.read(kHead + "<xacro:include filename=\"b.xacro\"/></robot>");
  CHECK(in.refuses("CG1402", "circle"));
}

TEST_CASE("bombs of YAML are refused", "[hostile]") {
  Imported in;
  std::string bomb = "a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n";
  for (int i = 1; i < 12; ++i) {
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [";
    for (int k = 0; k < 10; ++k) bomb += (k > 0 ? "," : "") + std::string("*a") + std::to_string(i - 1);
    bomb += "]\n";
  }
  in.folder.write("bomb.yaml", bomb);
  in.read(kHead + "<link name=\"${len(xacro.load_yaml('bomb.yaml'))}\"/></robot>");
  CHECK(in.refuses("CG1411", "100000 values"));
}

TEST_CASE("names from a file run nothing and leave no folder", "[hostile]") {
  Imported in;
  in.read("<robot name=\"$(touch x)\"><link name=\"$(echo hi)\"><inertial><mass value=\"1\"/>"
          "<inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link></robot>");
  REQUIRE(in.model);
  CHECK(in.result.scene.find("$(") == std::string::npos);
  CHECK(in.result.scene.find("${") == std::string::npos);
  in.read("<robot name=\"r\"><link name=\"${1}\"><inertial><mass value=\"1\"/>"
          "<inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link></robot>");
  REQUIRE(in.model);
}

TEST_CASE("numbers that are none are refused at their element", "[hostile]") {
  Imported in;
  in.read("<robot name=\"r\">\n<link name=\"a\"><inertial><mass value=\"nan\"/></inertial></link></robot>");
  CHECK(in.refuses("CG1403", "'nan' is not a number", 2));
  in.read("<robot name=\"r\">\n<link name=\"a\"><inertial><mass value=\"1e999\"/></inertial></link></robot>");
  CHECK(in.refuses("CG1403", "is not a number", 2));
  in.read("<robot name=\"r\"><link name=\"a\"/><!DOCTYPE a></robot>");
  CHECK(in.result.scene.empty());
}
