// <frame> and <replicate> of MJCF, beside the same model written out; settings that scenes do not have.
#include <cmath>

#include "cogrsim/core/constants.h"
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

constexpr const char* kMjcf =
    "<mujoco model=\"m\"><compiler angle=\"degree\"/>"
    "<default><default class=\"light\"><geom density=\"100\"/></default></default><worldbody>";

/// The scene of a model, without its first lines, which name the source.
std::string scene_of(const std::string& world, const std::string& rest = {}) {
  Imported in;
  in.read(kMjcf + world + "</worldbody>" + rest + "</mujoco>", "m.xml");
  REQUIRE(in.model);
  return in.result.scene;
}

}  // namespace

TEST_CASE("what is in a frame of MJCF is where its pose puts it", "[mjcf][frames]") {
  const std::string framed = scene_of(R"(
    <body name="base">
      <freejoint/>
      <geom size="0.1"/>
      <frame pos="1 0 0" euler="0 0 90">
        <geom type="box" size="0.1 0.2 0.3" pos="1 0 0"/>
        <frame pos="0 0 2" childclass="light">
          <geom type="capsule" size="0.1" fromto="0 0 0 1 0 0"/>
          <body name="arm" pos="0 1 0">
            <frame euler="0 0 90"><joint name="j" axis="1 0 0" pos="0.5 0 0"/></frame>
            <geom size="0.1" pos="0 0 1"/>
          </body>
        </frame>
        <site name="tip" pos="0 0 1"/>
      </frame>
    </body>)");
  const std::string plain = scene_of(R"(
    <body name="base">
      <freejoint/>
      <geom size="0.1"/>
      <geom type="box" size="0.1 0.2 0.3" pos="1 1 0" euler="0 0 90"/>
      <geom type="capsule" size="0.1" density="100" fromto="1 0 2 1 1 2"/>
      <site name="tip" pos="1 0 1" euler="0 0 90"/>
      <body name="arm" pos="0 0 2" euler="0 0 90">
        <joint name="j" axis="0 1 0" pos="0 0.5 0"/>
        <geom size="0.1" density="100" pos="0 0 1"/>
      </body>
    </body>)");
  CAPTURE(framed, plain);
  const auto read = [](const std::string& text) {
    const dsl::CompileResult out = dsl::compile_text(text, "s.scene.xml");
    REQUIRE(out.ok());
    return out.model;
  };
  const auto a = read(framed), b = read(plain);
  REQUIRE(a->bodies.size() == b->bodies.size());
  for (std::size_t i = 0; i < a->bodies.size(); ++i) {
    const Body &x = a->bodies[i], &y = b->bodies[i];
    CHECK(x.name == y.name);
    CHECK((x.X_WB.p - y.X_WB.p).norm() < 1e-12);
    CHECK(x.X_WB.q.angularDistance(y.X_WB.q) < 1e-12);
    CHECK(std::abs(x.mass - y.mass) < 1e-12 * y.mass);
    CHECK((x.com - y.com).norm() < 1e-12);
    CHECK((x.inertia - y.inertia).norm() < 1e-12 * y.inertia.norm());
  }
  const Joint &j = a->joints.at(0), &k = b->joints.at(0);
  CHECK((j.X_CM.p - k.X_CM.p).norm() < 1e-12);
  CHECK((j.X_CM.q * Vec3::UnitZ() - k.X_CM.q * Vec3::UnitZ()).norm() < 1e-12);
  CHECK((a->frames.at(0).X_BF.p - b->frames.at(0).X_BF.p).norm() < 1e-12);
}

TEST_CASE("a replicate of MJCF has copies along its path, with what refers to them",
          "[mjcf][frames]") {
  Imported in;
  in.read(std::string(kMjcf) + R"(
    <replicate count="4" offset="1 0 0" euler="0 0 90" sep="-">
      <body name="leg" pos="0 0 1">
        <joint name="hip" axis="1 0 0"/>
        <geom size="0.1"/>
      </body>
    </replicate>
    </worldbody>
    <actuator><motor name="pull" joint="hip"/></actuator>
    <sensor><jointpos name="angle" joint="hip"/></sensor></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  // The offset is along x of the copy before: a square.
  const Vec3 corners[] = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  for (int i = 0; i < 4; ++i) {
    const Body& leg = in.body("leg-" + std::to_string(i));
    CHECK((leg.X_WB.p - corners[i]).norm() < 1e-12);
    CHECK(leg.X_WB.q.angularDistance(Quat(Eigen::AngleAxisd(i * kPi / 2, Vec3::UnitZ()))) < 1e-7);
    in.joint("hip-" + std::to_string(i));
  }
  CHECK(in.model->motors.size() == 4);
  CHECK(in.model->sensors.size() == 4);
  CHECK(in.reports(kExact, "<replicate>", "4 copies"));
}

TEST_CASE("replicates in replicates have both suffixes, with as many digits as the count",
          "[mjcf][frames]") {
  Imported in;
  in.read(std::string(kMjcf) + R"(
    <replicate count="10" offset="0 1 0" sep="_">
      <replicate count="2" offset="1 0 0" sep="_">
        <body name="b"><freejoint/><geom size="0.1"/></body>
      </replicate>
    </replicate></worldbody></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.model->bodies.size() == 20);
  CHECK((in.body("b_1_09").X_WB.p - Vec3(1, 9, 0)).norm() < 1e-12);
}

TEST_CASE("a replicate without end is refused", "[mjcf][frames]") {
  Imported in;
  const auto with = [&](const std::string& attributes, const std::string& inside) {
    in.read(std::string(kMjcf) + "\n<replicate " + attributes + ">" + inside +
                "</replicate></worldbody></mujoco>",
            "m.xml");
  };
  const std::string body = "<body><freejoint/><geom size=\"0.1\"/></body>";
  with("count=\"1e9\"", body);
  CHECK(in.refuses("CG1402", "<replicate> makes more than 200000 elements", 2));
  std::string nested = body;
  for (int i = 0; i < 20; ++i) nested = "<replicate count=\"10\">" + nested + "</replicate>";
  with("count=\"10\"", nested);
  CHECK(in.refuses("CG1402", "<replicate> makes more than"));
  for (const char* bad : {"", "count=\"0\"", "count=\"-3\"", "count=\"2.5\""}) {
    with(bad, body);
    CHECK(in.refuses("CG1404", "a whole number above zero", 2));
  }
}

TEST_CASE("settings that scenes do not have are reported once for each kind", "[mjcf][frames]") {
  Imported in;
  // Compiled by programs, which know the engine of what is said to it.
  in.result = dsl::import_model(
      in.folder.write("m.xml", R"(<mujoco><compiler settotalmass="6" boundmass="1"/>
    <default><geom solref="0.01 1"/></default>
    <worldbody><body><freejoint/><geom size="0.1" mass="2" solimp="0.9 0.95 0.001" margin="0"/></body>
    <body><freejoint/><geom size="0.1" mass="0.1" solref="0.02 1" gap="0.1"/></body></worldbody></mujoco>)"),
      in.options);
  CHECK(in.reports(kExact, "softness of contacts", "by materials"));
  CHECK(in.result.scene.find("<mujoco solref=\"0.01 1\"/></material>") != std::string::npos);
  CHECK(in.result.scene.find("<mujoco gap=\"0.1\"/></material>") != std::string::npos);
  CHECK(in.reports(kExact, "mass of body", "boundmass"));
  CHECK(in.reports(kExact, "settotalmass", "scaled by 2"));
  CHECK(in.result.scene.find("mass=\"4") != std::string::npos);
  CHECK(in.result.scene.find("mass=\"2") != std::string::npos);
}

TEST_CASE("links of one model of SDF touch each other only by self_collide", "[sdf][contact]") {
  const auto link = [](const std::string& name, const std::string& more) {
    return "<link name=\"" + name + "\">" + more +
           "<collision name=\"c\"><geometry><sphere><radius>0.1</radius></sphere></geometry>"
           "<surface><contact><collide_bitmask>0x03</collide_bitmask></contact></surface>"
           "</collision></link>";
  };
  const std::string own = "<self_collide>true</self_collide>";
  const auto model = [&](const std::string& flag) {
    return "<sdf version=\"1.9\"><model name=\"m\">" + flag + link("a", "") + link("b", "") +
           link("c", own) + "</model></sdf>";
  };
  Imported in;
  in.read(model(""), "m.sdf");
  REQUIRE(in.model);
  CHECK(in.model->no_collide.size() == 1);  // a and b
  CHECK(in.reports(kExact, "self_collide", "1 pairs of bodies do not touch"));
  in.read(model(own), "m.sdf");
  REQUIRE(in.model);
  CHECK(in.model->no_collide.empty());
}

TEST_CASE("shapes of SDF touch by a bit in common", "[sdf][contact]") {
  const auto model = [](const std::string& name, const std::string& bits) {
    return "<model name=\"" + name +
           "\"><link name=\"l\"><collision name=\"c\"><geometry><sphere><radius>0.1</radius>"
           "</sphere></geometry><surface><contact><collide_bitmask>" +
           bits + "</collide_bitmask></contact></surface></collision></link></model>\n";
  };
  Imported in;
  in.read("<sdf version=\"1.9\"><world name=\"w\">" + model("a", "1") + model("b", "0x02") +
              model("c", "3") + "</world></sdf>",
          "m.sdf");
  REQUIRE(in.model);
  CHECK(in.model->no_collide.size() == 1);  // a and b
  in.read("<sdf version=\"1.9\"><world name=\"w\">\n" + model("a", "many") + "</world></sdf>",
          "m.sdf");
  CHECK(in.refuses("CG1403", "collide_bitmask is 'many'", 2));
}

TEST_CASE("a mass of SDF that no body can have is refused", "[sdf]") {
  Imported in;
  for (const char* mass : {"-1", "inf", "nan"}) {
    in.read("<sdf version=\"1.9\"><model name=\"m\">\n<link name=\"l\"><inertial><mass>" +
                std::string(mass) + "</mass></inertial></link></model></sdf>",
            "m.sdf");
    CAPTURE(mass);
    CHECK(in.result.scene.empty());
    CHECK(!in.result.diagnostics.empty());
  }
}

TEST_CASE("sums beyond all numbers are refused", "[urdf]") {
  const std::string heavy =
      "<inertial><mass value=\"1\"/><inertia ixx=\"1e308\" iyy=\"1e308\" izz=\"1e308\" ixy=\"0\" "
      "ixz=\"0\" iyz=\"0\"/></inertial>";
  Imported in;
  in.read("<robot name=\"r\">\n<link name=\"a\">" + heavy + "</link><link name=\"b\">" + heavy +
          "</link><joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/>"
          "</joint></robot>");
  CHECK(in.refuses("CG1402", "of link 'a' is beyond all numbers", 2));
}

TEST_CASE("a range of an actuator bounds it only if it is one, and is not switched off", "[mjcf]") {
  Imported in;
  const auto with = [&](const std::string& attributes) {
    in.read(
        "<mujoco><worldbody><body><joint name=\"j\"/><geom size=\"0.1\"/></body></worldbody>"
        "\n<actuator><motor joint=\"j\" " +
            attributes + "/></actuator></mujoco>",
        "m.xml");
  };
  with("forcerange=\"-3 2\"");
  REQUIRE(in.model);
  CHECK(in.model->motors.at(0).max_effort == 3.0);
  with("forcerange=\"-3 2\" forcelimited=\"false\"");
  REQUIRE(in.model);
  CHECK(std::isinf(in.model->motors.at(0).max_effort));
  for (const char* bad : {"0 0", "2 -2"}) {
    with("forcerange=\"" + std::string(bad) + "\"");
    CHECK(in.refuses("CG1403", "the second above the first", 2));
  }
  with("forcerange=\"1 2 3\"");
  CHECK(in.refuses("CG1403", "one number too many"));
}
