// Frictions and solids of a source come to the scene.
#include "cogrsim/dsl/export_model.h"
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const Material& material_of(const Imported& in, const std::string& body) {
  const SceneModel& model = *in.model;
  return model.materials[in.body(body).shapes.at(0).material];
}

}  // namespace

TEST_CASE("condim decides which frictions of MJCF act", "[mjcf]") {
  Imported in;
  in.read(R"(<mujoco model="m"><worldbody>
    <body name="a"><freejoint/><geom size="0.1" friction="0.7 0.02 0.003"/></body>
    <body name="b" pos="1 0 0"><freejoint/><geom size="0.1" friction="0.7 0.02 0.003" condim="4"/></body>
    <body name="c" pos="2 0 0"><freejoint/><geom size="0.1" friction="0.7 0.02 0.003" condim="6"/></body>
    <body name="d" pos="3 0 0"><freejoint/><geom size="0.1" condim="6"/></body>
    </worldbody></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  const double expected[4][2] = {{0.0, 0.0}, {0.02, 0.0}, {0.02, 0.003}, {0.005, 0.0001}};
  for (int i = 0; i < 4; ++i) {
    const Material& material = material_of(in, std::string(1, static_cast<char>('a' + i)));
    CHECK(material.spinning_friction == expected[i][0]);
    CHECK(material.rolling_friction == expected[i][1]);
  }
}

TEST_CASE("Bullet's frictions of a URDF link", "[urdf]") {
  Imported in;
  in.read(R"(<robot name="r"><link name="a"><contact><lateral_friction value="0.9"/>
    <rolling_friction value="0.002"/><spinning_friction value="0.01"/><contact_cfm value="0"/></contact>
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>)");
  REQUIRE(in.model);
  const Material& material = material_of(in, "a");
  CHECK(material.friction == 0.9);
  CHECK(material.rolling_friction == 0.002);
  CHECK(material.spinning_friction == 0.01);
  CHECK(in.reports(dsl::Fidelity::left_out, "<contact_cfm> of link 'a'", "concerns Bullet"));
}

TEST_CASE("torsional and rolling friction of SDF", "[sdf]") {
  Imported in;
  in.read(R"(<sdf version="1.9"><model name="m"><link name="a"><collision name="c"><geometry>
    <sphere><radius>0.1</radius></sphere></geometry><surface><friction>
    <ode><mu>0.6</mu></ode><bullet><rolling_friction>0.004</rolling_friction></bullet>
    <torsional><coefficient>0.5</coefficient><patch_radius>0.02</patch_radius></torsional>
    </friction></surface></collision></link></model></sdf>)",
          "m.sdf");
  REQUIRE(in.model);
  const Material& material = material_of(in, "a");
  CHECK(material.friction == 0.6);
  CHECK(material.rolling_friction == 0.004);
  // 3 pi / 16 of coefficient times radius, as libsdformat has it.
  CHECK(material.spinning_friction == Approx(3.0 * 3.14159265358979323846 / 16.0 * 0.01));
}

TEST_CASE("ellipsoids, cones and polylines are solids of the scene", "[mjcf][sdf]") {
  Imported in;
  in.read(R"(<mujoco><worldbody><body name="a"><freejoint/>
    <geom type="ellipsoid" size="0.1 0.2 0.3" mass="2"/></body></worldbody></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.result.scene.find("<ellipsoid") != std::string::npos);
  CHECK(in.body("a").inertia(0, 0) == Approx(2.0 / 5.0 * 0.13).epsilon(1e-12));

  const auto link = [](const std::string& shape) {
    return "<sdf version=\"1.9\"><model name=\"m\"><link name=\"a\"><collision "
           "name=\"c\"><geometry>" +
           shape + "</geometry></collision></link></model></sdf>";
  };
  in.read(link("<cone><radius>0.2</radius><length>0.5</length></cone>"), "m.sdf");
  REQUIRE(in.model);
  CHECK(in.result.scene.find("<cone") != std::string::npos);

  // Its outline is at the bottom.
  in.read(link("<polyline><point>0 0</point><point>2 0</point><point>0 1</point>"
               "<height>0.4</height></polyline>"),
          "m.sdf");
  REQUIRE(in.model);
  const Shape& prism = in.body("a").shapes.at(0);
  CHECK(prism.type == ShapeType::convex_mesh);
  CHECK(prism.X_BS.p.z() == Approx(0.2));
  in.read(link("<polyline><point>0 0</point><point>2 0</point><point>1 0.5</point>"
               "<point>1 2</point><height>1</height></polyline>"),
          "m.sdf");
  CHECK(in.model);
  CHECK(in.reports(dsl::Fidelity::approximate, "", "is the convex hull of its outline"));
}

TEST_CASE("frictions and bounce go out and come back, or are reported", "[export]") {
  const dsl::CompileResult compiled = dsl::compile_text(
      R"(<scene name="s" version="1"><body name="ball" xyz="0 0 1"><sphere radius="0.1" friction="0.6"
      rolling-friction="0.003 m" spinning-friction="0.02 m" restitution="0.4"/></body></scene>)",
      "s.scene.xml");
  INFO(dsl::to_text(compiled.diagnostics));
  REQUIRE(compiled.ok());
  const auto format =
      GENERATE(dsl::ExportFormat::urdf, dsl::ExportFormat::sdf, dsl::ExportFormat::mjcf);
  dsl::ExportOptions options;
  options.format = format;
  const auto out = dsl::export_model(*compiled.model, options);
  REQUIRE(out);
  INFO(out->text);
  std::string lost;
  for (const dsl::ImportEntry& e : out->entries)
    if (e.element == "sphere of body 'ball'") lost = e.message;
  if (format == dsl::ExportFormat::urdf) {
    CHECK(lost ==
          "its friction 0.6, its rolling friction 0.003, its spinning friction 0.02, its "
          "restitution 0.4 are left out");
    return;
  }
  const bool mjcf = format == dsl::ExportFormat::mjcf;
  CHECK(lost == (mjcf ? "its restitution 0.4 is left out" : ""));
  Imported back;
  back.read(out->text, mjcf ? "s.xml" : "s.sdf");
  REQUIRE(back.model);
  const Material& m = material_of(back, "ball");
  CHECK(m.friction == 0.6);
  CHECK(m.rolling_friction == 0.003);
  CHECK(std::abs(m.spinning_friction - 0.02) < 1e-15);
  CHECK(m.restitution == (mjcf ? 0.0 : 0.4));
}

TEST_CASE("the rule of a source goes out and comes back, or is reported", "[export]") {
  const auto exported = [](const char* scene, dsl::ExportFormat format) {
    const dsl::CompileResult compiled = dsl::compile_text(scene, "s.scene.xml");
    INFO(dsl::to_text(compiled.diagnostics));
    REQUIRE(compiled.ok());
    dsl::ExportOptions options;
    options.format = format;
    const auto out = dsl::export_model(*compiled.model, options);
    REQUIRE(out);
    std::string lost;
    for (const dsl::ImportEntry& e : out->entries)
      if (e.element == "friction of pairs") lost = e.message;
    return lost;
  };
  const char* const mixed = R"(<scene name="s" version="1"><material name="ice" friction="0.1"/>
      <plane name="floor" material="ice"/><box name="b" size="1 1 1" friction="0.9" xyz="0 0 1"/></scene>)";
  const char* const larger = R"(<scene name="s" version="1">
      <material name="ice" friction="0.1" friction-combine="max"/>
      <plane name="floor" material="ice"/><box name="b" size="1 1 1" friction="0.9" xyz="0 0 1"/></scene>)";
  CHECK(exported(mixed, dsl::ExportFormat::mjcf) ==
        "MuJoCo takes the larger of two: a pair of materials differ; 'ice' and friction 0.9 have "
        "0.3 here, 0.9 there");
  CHECK(exported(mixed, dsl::ExportFormat::sdf).find("have 0.3 here, 0.1 there") !=
        std::string::npos);
  CHECK(exported(larger, dsl::ExportFormat::mjcf).empty());
  CHECK(exported(larger, dsl::ExportFormat::sdf).find("have 0.9 here, 0.1 there") !=
        std::string::npos);
}
