#include <Eigen/Eigenvalues>

#include <cmath>
#include <cstring>

#include "cogrsim/core/constants.h"
#include "cogrsim/model/mass_properties.h"
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const char* const kArm = R"(<robot name="arm">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base">
    <inertial><origin xyz="0 0 0.05"/><mass value="2"/><inertia ixx="0.01" iyy="0.02" izz="0.015" ixy="0.001" ixz="0" iyz="0"/></inertial>
    <visual><geometry><box size="0.2 0.2 0.1"/></geometry><material name="red"/></visual>
    <collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
  </link>
  <link name="upper">
    <inertial><origin xyz="0 0 0.2" rpy="0 0.3 0.2"/><mass value="1"/><inertia ixx="0.03" iyy="0.02" izz="0.015" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.2"/><geometry><cylinder radius="0.03" length="0.4"/></geometry></collision>
  </link>
  <link name="flange"/>
  <link name="tool"><inertial><mass value="0.5"/><inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0.1 0.1" rpy="0.1 0.2 0.3"/><axis xyz="0 2 0"/>
    <limit lower="0.5" upper="1.5" effort="10" velocity="3"/><dynamics damping="0.1" friction="0.2"/>
  </joint>
  <joint name="mount" type="fixed"><parent link="upper"/><child link="flange"/><origin xyz="0 0 0.4"/></joint>
  <joint name="tool_mount" type="fixed"><parent link="flange"/><child link="tool"/><origin xyz="0.1 0 0" rpy="0 0 1"/></joint>
</robot>)";

}  // namespace

TEST_CASE("links, joints and inertias come over exactly", "[urdf]") {
  Imported in;
  in.read(kArm);
  REQUIRE(in.model);
  CHECK(in.result.format == "URDF");
  CHECK(in.model->bodies.size() == 2);
  const Body& base = in.body("base");
  CHECK(base.mass == 2.0);
  CHECK((base.com - Vec3(0, 0, 0.05)).norm() < 1e-15);
  CHECK(std::abs(base.inertia(0, 1) - 0.001) < 1e-15);
  // Two links that are welded: mass, centre and inertia of both, in the frame of the first.
  const Body& upper = in.body("upper");
  CHECK(std::abs(upper.mass - 1.5) < 1e-15);
  const Vec3 a(0, 0, 0.2), b(0.1, 0, 0.4);
  const Vec3 com = (1.0 * a + 0.5 * b) / 1.5;
  CHECK((upper.com - com).norm() < 1e-14);
  const Mat3 R = (Eigen::AngleAxisd(0.2, Vec3::UnitZ()) * Eigen::AngleAxisd(0.3, Vec3::UnitY()))
                     .toRotationMatrix();
  const auto shifted = [&](double m, const Vec3& from) -> Mat3 {
    const Vec3 d = from - com;
    return m * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
  };
  const Mat3 wanted = R * Vec3(0.03, 0.02, 0.015).asDiagonal() * R.transpose() + shifted(1.0, a) +
                      0.001 * Mat3::Identity() + shifted(0.5, b);
  CHECK((upper.inertia - wanted).norm() < 1e-14);
  const Joint& shoulder = in.joint("shoulder");
  CHECK(shoulder.type == JointType::hinge);
  // Zero is beyond the limits: it starts at the lower one.
  CHECK(shoulder.position == std::vector<double>{0.5});
  CHECK(in.reports(kApproximate, "joint 'shoulder'", "zero lies beyond its limits"));
  const Pose X_PC = base.X_WB.inverse() * upper.X_WB;
  const Quat at_zero =
      Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ()) * Eigen::AngleAxisd(0.2, Vec3::UnitY()) *
           Eigen::AngleAxisd(0.1, Vec3::UnitX()));
  const Quat turned = at_zero * Quat(Eigen::AngleAxisd(0.5, Vec3::UnitY()));
  CHECK((X_PC.p - Vec3(0, 0.1, 0.1)).norm() < 1e-12);
  CHECK(X_PC.q.angularDistance(turned) < 1e-12);
  // What was welded is a frame with the link's name.
  const NamedFrame& tool = in.frame("tool");
  CHECK((tool.X_BF.p - Vec3(0.1, 0, 0.4)).norm() < 1e-14);
  CHECK(tool.X_BF.q.angularDistance(Quat(Eigen::AngleAxisd(1.0, Vec3::UnitZ()))) < 1e-14);
  CHECK(in.frame("flange").body == tool.body);
  CHECK(in.result.count(kLeftOut) == 0);
}

TEST_CASE("products of inertia that are not given are reported", "[urdf]") {
  Imported in;
  in.read(R"(<robot name="r"><link name="a"><inertial><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixz="0"/></inertial></link></robot>)");
  REQUIRE(in.model);
  CHECK(in.reports(kApproximate, "inertia of link 'a'",
                   "does not give ixy, iyz, which is read as 0"));
}

TEST_CASE("an inertia that no body has is replaced by the nearest possible one", "[urdf]") {
  Imported in;
  in.read(R"(<robot name="r"><link name="a"><inertial><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.5"/></inertial></link></robot>)");
  REQUIRE(in.model);
  CHECK(in.reports(kApproximate, "inertia of link 'a'", "0.1, 0.1, 0.5"));
  const Vec3 m = Eigen::SelfAdjointEigenSolver<Mat3>(in.body("a").inertia).eigenvalues();
  // The projection moves each by a third of the violation, 0.3.
  CHECK((m - Vec3(0.2, 0.2, 0.4)).norm() < 1e-9);
}

TEST_CASE("links without mass become frames, or are given a little", "[urdf]") {
  Imported in;
  in.read(R"(<robot name="r">
    <link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <link name="between"/>
    <link name="b"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <link name="leaf"/>
    <joint name="j1" type="continuous"><parent link="a"/><child link="between"/><axis xyz="1 0 0"/></joint>
    <joint name="j2" type="continuous"><parent link="between"/><child link="b"/><axis xyz="0 1 0"/></joint>
    <joint name="j3" type="prismatic"><parent link="b"/><child link="leaf"/><axis xyz="0 1 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>
  </robot>)");
  REQUIRE(in.model);
  CHECK(in.model->bodies.size() == 3);
  CHECK(in.body("between").mass == Approx(0.001));
  CHECK(in.reports(kApproximate, "link 'between'", "has no mass"));
  CHECK(in.frame("leaf").name.find("leaf") != std::string::npos);
  CHECK(in.reports(kApproximate, "joint 'j3'", "became a frame"));
}

TEST_CASE("what the scene cannot say is reported with its line", "[urdf]") {
  Imported in;
  in.read(R"(<robot name="r">
    <link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
      <visual><geometry><mesh filename="package://no_such/mesh.stl"/></geometry></visual>
      <colision><geometry><sphere radius="1"/></geometry></colision></link>
    <gazebo><plugin name="p" filename="libp.so"/></gazebo>
  </robot>)");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "mesh 'package://no_such/mesh.stl'", "--package no_such=DIR"));
  CHECK(in.reports(kLeftOut, "<colision>", "did you mean <collision>?"));
  CHECK(in.reports(kLeftOut, "plugin 'libp.so'", "is not known"));
  for (const dsl::ImportEntry& e : in.result.entries) CHECK(e.line > 0);
}

TEST_CASE("a robot that is not a tree is refused at its line", "[urdf]") {
  Imported in;
  const std::string link =
      R"(<link name="N"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>)";
  const auto named = [&](const char* name) {
    std::string out = link;
    out.replace(out.find('N'), 1, name);
    return out;
  };
  in.read("<robot name=\"r\">\n" + named("a") + "\n" + named("b") + "\n</robot>");
  CHECK(in.refuses("CG1410", "2 links have no parent: 'a', 'b'", 1));
  in.read(
      "<robot name=\"r\">" + named("a") + named("b") +
      "<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\n"
      "<joint name=\"k\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint></robot>");
  CHECK(in.refuses("CG1410", "form a cycle"));
  in.read("<robot name=\"r\">" + named("arm") +
          "\n<joint name=\"j\" type=\"revolut\"><parent link=\"arm\"/><child "
          "link=\"amr\"/></joint></robot>");
  CHECK(in.refuses("CG1408", "did you mean 'arm'?", 2));
  in.read("<robot name=\"r\"></robot>");
  CHECK(in.refuses("CG1405", "no link"));
}

TEST_CASE("names that the scene language does not take are changed, and reported", "[urdf]") {
  Imported in;
  in.read(R"(<robot name="my robot">
    <link name="base.link 1"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <link name="base/link 1"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <joint name="base.link 1" type="continuous"><parent link="base.link 1"/><child link="base/link 1"/></joint>
  </robot>)");
  REQUIRE(in.model);
  CHECK(in.model->bodies.size() == 2);
  CHECK(in.reports(kExact, "link 'base/link 1'", "is called"));
  // In a scene "world" is the world, which an instance's pose does not move.
  in.read(R"(<robot name="r">
    <link name="world"/>
    <link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <joint name="j" type="continuous"><parent link="world"/><child link="a"/></joint>
  </robot>)");
  REQUIRE(in.model);
  CHECK(in.body("world_link").kind != BodyKind::dynamic);
  CHECK(in.joint("j").parent >= 0);
}

TEST_CASE("meshes are found in the package around the model, and nowhere else", "[urdf]") {
  Imported in;
  const std::string stl =
      "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\n"
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 0 0 "
      "1\nendloop\nendfacet\n"
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 1 0 "
      "0\nendloop\nendfacet\n"
      "facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 0 0 1\nvertex 0 1 "
      "0\nendloop\nendfacet\nendsolid\n";
  in.folder.write("bot_description/package.xml", "<package/>");
  in.folder.write("bot_description/meshes/a.stl", stl);
  in.folder.write("secret.stl", stl);
  const auto robot = [](const std::string& file) {
    return "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
           "iyy=\"1\" izz=\"1\"/>"
           "</inertial><visual><geometry><mesh filename=\"" +
           file + "\" scale=\"2 2 2\"/></geometry></visual></link></robot>";
  };
  in.read(robot("package://bot_description/meshes/a.stl"), "bot_description/urdf/r.urdf");
  REQUIRE(in.model);
  REQUIRE(in.model->meshes.size() == 1);
  CHECK(in.model->meshes[0]->vertices.size() == 4);
  double far = 0.0;
  for (const Vec3& v : in.model->meshes[0]->vertices) far = std::max(far, v.maxCoeff());
  CHECK(far == 2.0);
  // A package has the name in its package.xml, whatever its folder is called.
  in.folder.write("checkout/package.xml", "<package>\n  <name> bot_models </name></package>");
  in.folder.write("checkout/meshes/a.stl", stl);
  in.read(robot("package://bot_models/meshes/a.stl"), "checkout/urdf/r.urdf");
  REQUIRE(in.model);
  CHECK(in.model->meshes.size() == 1);
  in.read(robot("../../secret.stl"), "bot_description/urdf/r.urdf");
  CHECK(in.reports(kLeftOut, "mesh '../../secret.stl'", "lies outside"));
  in.read(robot("package://../secret.stl"), "bot_description/urdf/r.urdf");
  CHECK(in.reports(kLeftOut, "mesh", "is not the name of a package"));
  in.read(robot("/etc/passwd"), "bot_description/urdf/r.urdf");
  CHECK(in.reports(kLeftOut, "mesh '/etc/passwd'", "lies outside"));
}

TEST_CASE("robots with the usual faults of XML are read", "[urdf]") {
  Imported in;
  in.read(
      "\n<?xml version=\"1.0\"?>\n<!-- run -- me --><robot name=\"r\"><link name=\"a\"><inertial>"
      "<mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link></robot>");
  REQUIRE(in.model);
  CHECK(in.result.entries.at(0).line == 3);
}

TEST_CASE("a robot of a name that the scene has gets another", "[urdf]") {
  Imported in;
  const std::string name = GENERATE("world", "floor");
  in.options.floor = true;
  const std::string path = in.folder.write(
      "r.urdf", "<robot name=\"" + name +
                    "\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
                    "iyy=\"1\" izz=\"1\"/></inertial></link></robot>");
  const dsl::ImportResult result = dsl::import_model(path, in.options);
  const dsl::CompileResult compiled = dsl::compile_text(result.scene, in.folder / "r.scene.xml");
  INFO(result.scene);
  INFO(dsl::to_text(compiled.diagnostics));
  CHECK(compiled.ok());
}

TEST_CASE("a root without mass is the world if it is called so", "[urdf]") {
  Imported in;
  const std::string name = GENERATE("world", "root");
  const std::string mass = GENERATE("", "<inertial><mass value=\"1\"/></inertial>");
  in.read("<robot name=\"r\"><link name=\"" + name + "\">" + mass + R"(</link>
    <link name="base"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <link name="arm"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <joint name="stand" type="fixed"><parent link=")" +
          name + R"("/><child link="base"/><origin xyz="0 0 2"/></joint>
    <joint name="j" type="continuous"><parent link="base"/><child link="arm"/></joint>
    </robot>)");
  REQUIRE(in.model);
  const bool is_world = name == "world" && mass.empty();
  const NamedFrame& base = in.frame("base");
  CHECK((in.model->bodies.at(base.body).kind == BodyKind::static_body) == is_world);
  CHECK(base.X_BF.p.z() == 2.0);
  CHECK(in.body("arm").kind == BodyKind::dynamic);
  CHECK(in.reports(kExact, "link 'world'", "is the world") == is_world);
}

TEST_CASE("a floating joint below a link is no joint", "[urdf]") {
  Imported in;
  in.read(R"(<robot name="r"><link name="world"/>
    <link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <joint name="f" type="floating"><parent link="world"/><child link="a"/><origin xyz="1 0 0"/></joint>
    </robot>)");
  REQUIRE(in.model);
  CHECK(in.model->joints.empty());
  const Body& a = in.body("a");
  CHECK(a.kind == BodyKind::dynamic);
  CHECK(a.X_WB.p.x() == 1.0);
}

TEST_CASE("a thin rod without a moment about its axis is given a little", "[urdf]") {
  Imported in;
  in.read(
      "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
      "iyy=\"1\" "
      "izz=\"0\"/></inertial></link></robot>");
  REQUIRE(in.model);
  CHECK(in.body("a").inertia(2, 2) > 0.0);
  CHECK(in.reports(kApproximate, "inertia of link 'a'"));
}

TEST_CASE("an inertia that is zero is taken from the shapes", "[urdf]") {
  Imported in;
  // 8 m^3 of box and 1 m^3 of ball: of 4 kg the box has 32/9 and the ball 4/9.
  const double ball = std::cbrt(0.75 / kPi);  // its radius
  in.read(R"(<robot name="r"><link name="a"><inertial><origin xyz="0 0 0.1"/><mass value="4"/>
      <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="2 2 2"/></geometry></collision>
    <collision><geometry><sphere radius=")" +
          std::to_string(ball) + R"("/></geometry></collision>
    <visual><geometry><box size="9 9 9"/></geometry></visual></link></robot>)");
  REQUIRE(in.model);
  const Body& a = in.body("a");
  CHECK(a.com.z() == 0.1);
  // m (2² + 2²) / 12 and 2 m r² / 5; the radius was written with six decimals.
  const double moment = 32.0 / 9.0 * 8.0 / 12.0 + 4.0 / 9.0 * 0.4 * ball * ball;
  CHECK((a.inertia - moment * Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-5);
  CHECK(in.reports(kApproximate, "inertia of link 'a'", "is zero: taken as its shapes'"));
  // So is what a program's rounding left of zero.
  in.read(R"(<robot name="r"><link name="a"><inertial><mass value="6"/>
      <inertia ixx="-5e-20" iyy="2e-21" izz="0" ixy="0" ixz="1e-35" iyz="0"/></inertial>
    <collision><geometry><box size="1 1 1"/></geometry></collision></link></robot>)");
  REQUIRE(in.model);
  CHECK((in.body("a").inertia - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-12);
  // What is only seen counts where nothing is touched; a mesh as its box.
  in.folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\nf 1 2 4\n");
  in.read(R"(<robot name="r"><link name="a"><inertial><mass value="12"/></inertial>
    <visual><geometry><mesh filename="m.obj"/></geometry></visual></link></robot>)");
  REQUIRE(in.model);
  CHECK((in.body("a").inertia - Mat3(Vec3(13, 10, 5).asDiagonal())).cwiseAbs().maxCoeff() < 1e-12);
  // Without shapes it is a point, which is given a little.
  in.read(
      R"(<robot name="r"><link name="a"><inertial><mass value="1"/></inertial></link></robot>)");
  REQUIRE(in.model);
  CHECK(in.body("a").inertia.maxCoeff() < 1e-9);
  CHECK(in.reports(kApproximate, "inertia of link 'a'", "the nearest possible ones"));
  // Between joints that move it is a ball of 1 cm.
  in.read(R"(<robot name="r"><link name="base"/>
    <link name="a"><inertial><mass value="2"/></inertial></link>
    <link name="b"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint>
    <joint name="k" type="continuous"><axis xyz="0 1 0"/><parent link="a"/><child link="b"/>
    </joint></robot>)");
  REQUIRE(in.model);
  CHECK((in.body("a").inertia - 8e-5 * Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-15);
  CHECK(in.reports(kApproximate, "inertia of link 'a'", "a ball's of 1 cm"));
}

TEST_CASE("a mesh that moves is decomposed if that is asked", "[urdf][mesh]") {
  Imported in;
  // An L of two bars of 1 m x 0.2 m x 0.2 m; the hull fills half a square of 0.8 m.
  std::string text;
  for (const char* z : {"0", "0.2"})
    for (const char* xy : {"0 0", "1 0", "1 0.2", "0.2 0.2", "0.2 1", "0 1"})
      text += std::string("v ") + xy + " " + z + "\n";
  text += "f 1 4 3 2\nf 1 6 5 4\nf 7 8 9 10\nf 7 10 11 12\n";
  for (int i = 1; i <= 6; ++i) {
    const int j = i % 6 + 1;
    text += "f " + std::to_string(i) + " " + std::to_string(j) + " " + std::to_string(j + 6) + " " +
            std::to_string(i + 6) + "\n";
  }
  in.folder.write("ell.obj", text);
  const std::string robot =
      "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"0.1\" "
      "ixy=\"0\" "
      "ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/></inertial><collision><geometry>"
      "<mesh filename=\"ell.obj\" scale=\"0.5 0.5 0.5\"/></geometry></collision></link></robot>";
  in.read(robot);
  REQUIRE(in.model);
  CHECK(in.model->bodies[0].shapes.size() == 1);
  std::vector<std::string> named;
  in.options.convex_parts = 8;
  in.options.decomposing = [&](const std::string& mesh) { named.push_back(mesh); };
  in.read(robot);
  REQUIRE(in.model);
  REQUIRE(in.model->bodies[0].shapes.size() == 2);
  CHECK(named == std::vector<std::string>{"ell.obj"});
  CHECK(in.result.files.size() == 2);
  CHECK(in.reports(kApproximate, "collision mesh of 'a'", "2 convex parts, which cover 0 %"));
  double volume = 0.0;
  for (const Shape& s : in.model->bodies[0].shapes) {
    CHECK(s.type == ShapeType::convex_mesh);
    volume += shape_volume(s, in.model->meshes);
  }
  CHECK(volume == Approx(0.125 * 0.2 * (0.2 + 0.8 * 0.2)).epsilon(1e-12));
}

TEST_CASE("links that would not be seen show what they collide with", "[urdf][mesh]") {
  Imported in;
  const auto robot = [](const std::string& visual) {
    return "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
           "iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>" +
           visual +
           "<collision><geometry><sphere radius=\"0.5\"/></geometry></collision></link></robot>";
  };
  const auto visible = [&] { return in.body("a").shapes.back().visible; };
  in.read(robot(""));
  REQUIRE(in.model);
  CHECK(visible());
  CHECK(in.body("a").shapes.back().collides);
  CHECK(in.reports(kApproximate, "link 'a'", "collision shapes are shown"));
  // Also where the file of what was to be seen cannot be read, and only there.
  in.folder.write("broken.glb", "glTF");
  in.read(robot("<visual><geometry><mesh filename=\"broken.glb\"/></geometry></visual>"));
  REQUIRE(in.model);
  CHECK(visible());
  CHECK(in.reports(kLeftOut, "mesh 'broken.glb'", "cut short"));
  in.read(robot("<visual><geometry><box size=\"1 1 1\"/></geometry></visual>"));
  REQUIRE(in.model);
  CHECK_FALSE(visible());
  CHECK_FALSE(in.reports(kApproximate, "link 'a'"));
}

TEST_CASE("links whose meshes cannot be read show the box of their inertia", "[urdf][sdf][mjcf]") {
  // A box of 0.2 x 0.4 x 0.6 m of 12 kg, which is turned by 45 degrees about z.
  const Mat3 I = (Mat3() << 0.46, 0.06, 0, 0.06, 0.46, 0, 0, 0, 0.2).finished();
  struct Case {
    const char *name, *text;
  };
  const Case cases[] = {
      {"r.urdf", R"(<robot name="r"><link name="a"><inertial><origin xyz="0.1 0 0.2"/>
        <mass value="12"/><inertia ixx="0.46" ixy="0.06" ixz="0" iyy="0.46" iyz="0" izz="0.2"/>
        </inertial><visual><geometry><mesh filename="../no.stl"/></geometry></visual>
        <collision><geometry><mesh filename="../no.stl"/></geometry></collision></link></robot>)"},
      {"r.sdf", R"(<sdf version="1.9"><model name="r"><link name="a"><inertial>
        <pose>0.1 0 0.2 0 0 0</pose><mass>12</mass><inertia><ixx>0.46</ixx><ixy>0.06</ixy>
        <iyy>0.46</iyy><izz>0.2</izz></inertia></inertial><visual name="v"><geometry><mesh>
        <uri>../no.stl</uri></mesh></geometry></visual></link></model></sdf>)"},
      {"r.xml", R"(<mujoco model="r"><asset><mesh name="m" file="../no.stl"/></asset><worldbody>
        <body name="a"><freejoint/><inertial pos="0.1 0 0.2" mass="12"
        fullinertia="0.46 0.46 0.2 0.06 0 0"/><geom type="mesh" mesh="m"/></body></worldbody>
        </mujoco>)"}};
  for (const Case& c : cases) {
    INFO(c.name);
    Imported in;
    in.read(c.text, c.name);
    REQUIRE(in.model);
    const Body& a = in.body("a");
    REQUIRE(a.shapes.size() == 1);
    const Shape& box = a.shapes[0];
    CHECK(box.type == ShapeType::box);
    CHECK(box.visible);
    CHECK_FALSE(box.collides);
    CHECK((box.X_BS.p - a.com).norm() < 1e-12);
    // The box filled evenly has the inertia of the link.
    const Mat3 Q = box.X_BS.q.toRotationMatrix();
    const Vec3 squares = box.size.cwiseAbs2();
    const Vec3 m = Vec3::Constant(squares.sum()) - squares;  // its mass is 12 kg
    CHECK((Q * m.asDiagonal() * Q.transpose() - I).norm() < 1e-9);
    CHECK(in.reports(kApproximate, "link 'a'", "the box of the inertia"));
    // The box stands on the floor that an import has.
    in.options.floor = true;
    const dsl::ImportResult placed = dsl::import_model(in.folder / c.name, in.options);
    CHECK(placed.scene.find("xyz=\"0 0 0.1") != std::string::npos);
    // The way out is said, and once for all files with the same reason.
    CHECK(in.reports(kLeftOut, "mesh '../no.stl'", "lies outside of the model's folder"));
    CHECK(in.reports(kLeftOut, "mesh '../no.stl'", "--package NAME=DIR"));
    CHECK_FALSE(in.reports(kLeftOut, "mesh", "no.stl"));
  }
  // What has no shape by itself, such as a link between two joints, gets none.
  Imported in;
  in.read(
      "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
      "iyy=\"1\" "
      "izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link></robot>");
  REQUIRE(in.model);
  CHECK(in.body("a").shapes.empty());
}

TEST_CASE("meshes of glTF are seen in their colour and copied whole", "[urdf][mesh]") {
  Imported in;
  // Positions (0 0 0), (1 0 0), (0 1 0) in a file beside the text.
  const std::string text =
      "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"buffers\":[{\"byteLength\":36,"
      "\"uri\":\"part.bin\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{"
      "\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"materials\":[{"
      "\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0,0,1]}}],\"meshes\":[{\"primitives\":[{"
      "\"attributes\":{\"POSITION\":0},\"material\":0}]}]}";
  const float numbers[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::string bytes(sizeof numbers, '\0');
  std::memcpy(bytes.data(), numbers, sizeof numbers);
  in.folder.write("visual/part.gltf", text);
  in.folder.write("visual/part.bin", bytes);
  const std::string robot =
      "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
      "iyy=\"1\" "
      "izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial><visual><geometry><mesh "
      "filename=\"visual/part.gltf\"/></geometry></visual></link></robot>";
  for (const char* copies : {"", "copied"}) {
    in.options.copy_meshes = copies;
    in.read(robot);
    REQUIRE(in.model);
    REQUIRE(in.body("a").shapes.size() == 1);
    const Shape& shape = in.body("a").shapes[0];
    CHECK(in.model->materials[shape.material].color.r == 1.0);
    CHECK(in.model->materials[shape.material].color.g == 0.0);
    const TriangleMesh& mesh = *in.model->meshes.at(0);
    REQUIRE(mesh.vertices.size() == 3);
    CHECK((mesh.vertices[2] - Vec3(0, 0, 1)).norm() < 1e-12);
    // A copy is one file.
    CHECK(in.result.files.size() == (std::string(copies).empty() ? 0 : 1));
  }
  CHECK(in.result.files.at(0).name == "copied/part.obj");
}

TEST_CASE("a copied mesh never takes the place of another", "[urdf][mesh]") {
  TemporaryFolder robots;
  Imported in;
  in.options.copy_meshes = "meshes";
  const auto triangle = [](int size) {
    return "v 0 0 0\nv " + std::to_string(size) +
           " 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 "
           "4\nf 1 4 3\n";
  };
  const auto imported = [&](const std::string& name, int size) {
    robots.write(name + "/pelvis.obj", triangle(size));
    const std::string file = robots.write(
        name + "/robot.urdf",
        "<robot name=\"r\"><link name=\"a\"><visual><geometry><mesh filename=\"pelvis.obj\"/>"
        "</geometry></visual></link></robot>");
    in.options.scene_folder = in.folder.path.string();
    const dsl::ImportResult result = dsl::import_model(file, in.options);
    REQUIRE(result.files.size() == 1);
    REQUIRE(dsl::write_beside(in.options.scene_folder, result.files, {true, {}, {}}));
    return result.files[0].name;
  };
  CHECK(imported("one", 1) == "meshes/pelvis.obj");
  CHECK(imported("two", 2) == "meshes/pelvis_2.obj");
  CHECK(imported("three", 1) == "meshes/pelvis.obj");  // the same file is shared
  CHECK(imported("four", 3) == "meshes/pelvis_3.obj");
  CHECK(imported("two", 2) == "meshes/pelvis_2.obj");  // and a second import changes nothing
}

TEST_CASE("one scale and an undeclared world are read as other programs do", "[urdf]") {
  Imported in;
  in.folder.write("m.obj",
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  const auto robot = [](const std::string& scale, const std::string& parent) {
    return "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
           "iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial><visual><geometry><mesh "
           "filename=\"m.obj\" scale=\"" +
           scale +
           "\"/></geometry></visual></link>\n<joint name=\"j\" type=\"continuous\"><parent "
           "link=\"" +
           parent + "\"/><child link=\"a\"/><origin xyz=\"0 0 2\"/></joint></robot>";
  };
  in.read(robot("0.5", "world"));
  REQUIRE(in.model);
  CHECK((in.model->meshes.at(0)->vertices.at(1) - Vec3(0.5, 0, 0)).norm() < 1e-12);
  CHECK(in.reports(kExact, "scale of <mesh>", "all axes"));
  CHECK(in.reports(kExact, "link 'world'", "not declared"));
  CHECK(in.body("a").X_WB.p.z() == 2.0);
  CHECK(in.joint("j").type == JointType::hinge);
  in.read(robot("0.5 0.5", "world"));
  CHECK(in.refuses("CG1403", "2 numbers"));
  in.read(robot("1 2 3", "base"));
  CHECK(in.refuses("CG1408", "no link 'base'", 2));
}
