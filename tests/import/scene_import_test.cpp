// `<import href="robot.urdf"/>` in a scene.
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const char* const kRobot = R"(<robot name="arm">
  <link name="base"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <link name="tip"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
    <collision><geometry><mesh filename="../meshes/tip.dae" scale="1 -1 1"/></geometry></collision></link>
  <joint name="elbow" type="continuous"><parent link="base"/><child link="tip"/>
    <origin xyz="0 0 0.5"/><axis xyz="0 1 0"/></joint>
</robot>)";

// A tetrahedron in centimetres.
const char* const kMesh =
    "<COLLADA><asset><unit meter=\"0.01\"/></asset><library_geometries><geometry id=\"g\"><mesh>"
    "<source id=\"p\"><float_array count=\"12\">0 0 0 100 0 0 0 100 0 0 0 "
    "100</float_array></source>"
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>"
    "<triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>"
    "<p>0 2 1 0 1 3 1 2 3 2 0 3</p></triangles></mesh></geometry></library_geometries>"
    "<library_visual_scenes><visual_scene id=\"s\"><node><translate>0 0 10</translate>"
    "<instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes>"
    "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";

}  // namespace

TEST_CASE("a scene imports a robot as a prototype", "[scene]") {
  TemporaryFolder folder;
  folder.write("robots/urdf/arm.urdf", kRobot);
  folder.write("robots/meshes/tip.dae", kMesh);
  const dsl::CompileResult result = dsl::compile_text(
      "<scene version=\"1\"><import href=\"robots/urdf/arm.urdf\" as=\"robot\"/>"
      "<instance of=\"robot.Arm\" name=\"left\" xyz=\"0 1 2\"/>"
      "<instance of=\"robot.Arm\" name=\"right\" xyz=\"0 -1 2\"/></scene>",
      folder / "scene.scene.xml");
  INFO(dsl::to_text(result.diagnostics));
  REQUIRE(result.ok());
  REQUIRE(result.model->bodies.size() == 4);
  CHECK(result.model->joints.size() == 2);
  CHECK((result.model->bodies[1].X_WB.p - Vec3(0, 1, 2.5)).norm() < 1e-12);
  CHECK((result.model->bodies[3].X_WB.p - Vec3(0, -1, 2.5)).norm() < 1e-12);
  // Once for both: 1 m, raised by 0.1 m and mirrored, with its surface outwards.
  REQUIRE(result.model->meshes.size() == 1);
  const TriangleMesh& mesh = *result.model->meshes[0];
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  double volume = 0.0;
  for (const Vec3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto at = [&](int i) { return mesh.vertices[t[i]]; };
    volume += at(0).dot(at(1).cross(at(2))) / 6.0;
  }
  CHECK((low - Vec3(0, -1, 0)).norm() < 1e-12);
  CHECK((high - Vec3(1, 0, 1.1)).norm() < 1e-12);
  CHECK(volume == Approx(1.0 / 6.0).epsilon(1e-12));
  CHECK(std::any_of(
      result.files_read.begin(), result.files_read.end(),
      [](const std::string& file) { return file.find("tip.dae") != std::string::npos; }));
}

TEST_CASE("an import starts a robot in a keyframe of its file", "[scene][keyframe]") {
  TemporaryFolder folder;
  folder.write(
      "m.xml",
      "<mujoco model=\"m\"><worldbody><body name=\"lift\"><joint name=\"slide\" type=\"slide\"/>"
      "<geom size=\"0.1\" mass=\"1\"/></body></worldbody>"
      "<keyframe><key name=\"low\" qpos=\"0.25\"/><key name=\"high\" qpos=\"0.75\"/></keyframe>"
      "</mujoco>");
  folder.write("parts.scene.xml", "<scene version=\"1\"><prototype name=\"P\"/></scene>");
  const auto compiled = [&](const std::string& content) {
    return dsl::compile_text("<scene version=\"1\">\n" + content + "</scene>",
                             folder / "scene.scene.xml");
  };
  // The same file, with each keyframe once and without one.
  const dsl::CompileResult result = compiled(
      "<param name=\"start\" default=\"high\"/>"
      "<import href=\"m.xml\" as=\"low\" keyframe=\"low\"/>"
      "<import href=\"m.xml\" as=\"high\" keyframe=\"${start}\"/>"
      "<import href=\"m.xml\" as=\"zero\"/>"
      "<instance of=\"low.M\" name=\"a\"/><instance of=\"high.M\" name=\"b\" xyz=\"0 1 0\"/>"
      "<instance of=\"zero.M\" name=\"c\" xyz=\"0 2 0\"/>");
  INFO(dsl::to_text(result.diagnostics));
  REQUIRE(result.ok());
  REQUIRE(result.model->joints.size() == 3);
  CHECK(result.model->joints[0].position.at(0) == 0.25);
  CHECK(result.model->joints[1].position.at(0) == 0.75);
  for (const double q : result.model->joints[2].position) CHECK(q == 0.0);

  for (const auto& [content, help] :
       {std::pair{"<import href=\"m.xml\" keyframe=\"hihg\"/>", "did you mean 'high'?"},
        std::pair{"<import href=\"parts.scene.xml\" keyframe=\"high\"/>", "no keyframes"}}) {
    const dsl::CompileResult bad = compiled(content);
    CHECK_FALSE(bad.ok());
    REQUIRE_FALSE(bad.diagnostics.empty());
    CHECK(bad.diagnostics[0].code == "CG1408");
    CHECK(bad.diagnostics[0].line == 2);
    CHECK_THAT(bad.diagnostics[0].help, Catch::Matchers::Contains(help));
  }
}

TEST_CASE("what is wrong with an imported robot is reported at the import", "[scene]") {
  TemporaryFolder folder;
  const auto compiled = [&](const char* robot) {
    folder.write("arm.urdf", robot);
    return dsl::compile_text(
        "<scene version=\"1\">\n<import href=\"arm.urdf\" as=\"robot\"/></scene>",
        folder / "scene.scene.xml");
  };
  const dsl::CompileResult bad = compiled("<robot name=\"arm\">\n<link/></robot>");
  CHECK_FALSE(bad.ok());
  REQUIRE_FALSE(bad.diagnostics.empty());
  CHECK(bad.diagnostics[0].code == "CG1404");
  CHECK(bad.diagnostics[0].line == 2);
  REQUIRE(bad.diagnostics[0].notes.size() == 1);
  const SourcePosition& there = bad.diagnostics[0].notes[0];
  CHECK(there.file == "arm.urdf");
  CHECK(there.line == 2);
  CHECK(there.column == 2);
  // What is left out is a warning, and a mesh outside of the scene's folder is left out.
  const dsl::CompileResult lost = compiled(
      "<robot name=\"arm\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
      "iyy=\"1\" "
      "izz=\"1\"/></inertial>\n<visual><geometry><mesh "
      "filename=\"/etc/passwd\"/></geometry></visual></link></robot>");
  CHECK(lost.ok());
  CHECK(std::any_of(lost.diagnostics.begin(), lost.diagnostics.end(), [](const Diagnostic& d) {
    return d.code == "CG2004" && d.message.find("lies outside") != std::string::npos;
  }));
}

TEST_CASE("a mesh of points is their hull", "[scene]") {
  TemporaryFolder folder;
  const auto compiled = [&](const std::string& mesh) {
    return dsl::compile_text("<scene version=\"1\"><body name=\"b\">" + mesh + "</body></scene>",
                             folder / "scene.scene.xml");
  };
  const dsl::CompileResult cube = compiled(
      "<mesh convex=\"true\" mass=\"6 kg\" points=\"0 0 0 1 0 0 0 1 0 0 0 1 1 1 0 1 0 1 0 1 1 1 1 "
      "1 0.5 "
      "0.5 0.5\"/>");
  INFO(dsl::to_text(cube.diagnostics));
  REQUIRE(cube.ok());
  CHECK((cube.model->bodies[0].com - Vec3(0.5, 0.5, 0.5)).norm() < 1e-12);
  CHECK((cube.model->bodies[0].inertia - Mat3::Identity()).norm() < 1e-12);  // m a²/6
  CHECK_FALSE(compiled("<mesh convex=\"true\" points=\"0 0 0 1 0 0 0 1 0 1 1 0\"/>").ok());
  CHECK_FALSE(compiled("<mesh convex=\"true\" points=\"0 0 0 1 0 0 0 1 0 0 0 1 5\"/>").ok());
  CHECK_FALSE(compiled("<mesh points=\"0 0 0 1 0 0 0 1 0 0 0 1\"/>").ok());
  CHECK_FALSE(compiled("<mesh convex=\"true\"/>").ok());
}

TEST_CASE("a robot of MJCF stands in a scene of others", "[scene][mjcf]") {
  TemporaryFolder folder;
  folder.write("bot.xml",
               R"(<mujoco model="bot"><worldbody><geom type="plane" size="1 1 1" friction="0.7"/>
    <body name="foot" pos="0 0 1"><freejoint/><geom size="0.1" friction="0.2" priority="1"/></body>
    <body name="hand" pos="1 0 1"><freejoint/><geom size="0.1" friction="0.6"/></body></worldbody></mujoco>)");
  const auto compiled = [&](const std::string& prefix, const std::string& more) {
    const std::string as = prefix.empty() ? "" : " as=\"" + prefix + "\"";
    const std::string of = prefix.empty() ? "Bot" : prefix + ".Bot";
    const dsl::CompileResult result =
        dsl::compile_text("<scene version=\"1\"><import href=\"bot.xml\"" + as +
                              "/><plane name=\"floor\" friction=\"0.4\"/><instance of=\"" + of +
                              "\" name=\"one\" xyz=\"5 0 0\"/>" + more + "</scene>",
                          folder / "scene.scene.xml");
    INFO(dsl::to_text(result.diagnostics));
    REQUIRE(result.ok());
    return result.model;
  };
  const auto friction = [](const SceneModel& model, const std::string& a, const std::string& b) {
    const auto material = [&](const std::string& name) {
      return model.bodies[std::size_t(find_body(model, name))].shapes.at(0).material;
    };
    return surface_pair(model, material(a), material(b)).friction;
  };
  const std::string prefix = GENERATE("", "parts");
  const SceneModelPtr alone = compiled(prefix, "");
  CHECK(alone->bodies.size() == 3);
  CHECK(friction(*alone, "one.hand", "floor") == 0.6);  // the larger one holds
  CHECK(friction(*alone, "one.foot", "one.hand") == 0.2);
  const SceneModelPtr both =
      compiled(prefix, "<instance of=\"" + (prefix.empty() ? "" : prefix + ".") +
                           "Bot_scenery\" name=\"hall\" xyz=\"0 0 -1\"/>");
  CHECK(both->bodies.size() == 4);
  CHECK(both->bodies[std::size_t(find_body(*both, "hall.world_link"))].X_WB.p == Vec3(0, 0, -1));
  CHECK(friction(*both, "one.foot", "hall.world_link") == 0.2);
  CHECK(friction(*both, "one.hand", "hall.world_link") == 0.7);
}
