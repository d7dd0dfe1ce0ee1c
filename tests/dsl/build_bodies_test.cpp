// Bodies, materials and rigid assemblies, against values computed by hand.
#include "../support/temporary_folder.h"
#include "build_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

TEST_CASE("a beginner's scene becomes the model it describes", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <physics backend="bullet" step="1 ms" gravity="0 0 -9.81"/>
    <plane name="floor" material="wood"/>
    <material name="wood" density="600 kg/m^3" friction="0.6" restitution="0.1" color="#b58863"/>
    <box    name="crate" size="40 40 40 cm" mass="3 kg" xyz="0 0 1" material="wood"/>
    <sphere name="ball"  radius="10 cm"     density="300 kg/m^3" xyz="0.1 0 2"/>)");
  CHECK(model->physics.backend == "bullet");
  CHECK(model->physics.step == 1e-3);
  REQUIRE(model->bodies.size() == 3);
  CHECK(body(*model, "floor").kind == BodyKind::static_body);

  const Body& crate = body(*model, "crate");
  CHECK(crate.kind == BodyKind::dynamic);
  CHECK(crate.mass == 3.0);
  CHECK(near(crate.X_WB.p, {0, 0, 1}, 0.0));
  // a cube's moment of inertia is m a^2 / 6
  CHECK(crate.inertia(0, 0) == Approx(3.0 * 0.16 / 6).epsilon(1e-14));
  const Material& wood = model->materials[crate.shapes[0].material];
  CHECK(wood.name == "wood");
  CHECK(wood.friction == 0.6);
  CHECK(wood.restitution == 0.1);

  const Body& ball = body(*model, "ball");
  const double mass = 300.0 * 4.0 / 3.0 * M_PI * 1e-3;
  CHECK(ball.mass == Approx(mass).epsilon(1e-14));
  CHECK(ball.inertia(2, 2) == Approx(0.4 * mass * 0.01).epsilon(1e-14));
}

TEST_CASE("materials and shapes say how a pair combines", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <material name="felt" friction="0.4" friction-combine="min" restitution="0.5" restitution-combine="average"/>
    <plane name="floor" friction="0.9" restitution="0.1"/>
    <sphere name="ball" radius="10 cm" material="felt" xyz="0 0 1"/>
    <sphere name="odd" radius="10 cm" material="felt" friction-combine="max" xyz="1 0 1"/>)");
  const auto pair = [&](const char* with) {
    const auto material = [&](const char* name) {
      return body(*model, name).shapes.at(0).material;
    };
    return surface_pair(*model, material("floor"), material(with));
  };
  CHECK(pair("ball").friction == 0.4);
  CHECK(pair("ball").restitution == Approx(0.3));
  CHECK(pair("odd").friction == 0.9);
  CHECK(pair("odd").restitution == Approx(0.3));
}

TEST_CASE("friction against rolling and spinning, and surfaces that move", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <material name="felt" rolling-friction="2 mm" spinning-friction="5 mm"/> <material name="ice"/>
    <contact between="felt ice" rolling-friction="0"/>
    <plane name="floor" material="felt" surface-velocity="0 50 0 cm/s"/>
    <sphere name="ball" radius="10 cm" material="felt" rolling-friction="0.1 cm" xyz="0 0 1"/>)");
  const auto material = [&](const char* name) {
    const Shape& shape = body(*model, name).shapes.at(0);
    return model->materials[shape.material];
  };
  CHECK(material("floor").rolling_friction == 2e-3);
  CHECK(material("floor").spinning_friction == 5e-3);
  CHECK(material("ball").rolling_friction == 1e-3);
  CHECK(material("ball").spinning_friction == 5e-3);
  CHECK(near(body(*model, "floor").shapes[0].surface_velocity, {0, 0.5, 0}, 0.0));
  CHECK(near(body(*model, "ball").shapes[0].surface_velocity, {0, 0, 0}, 0.0));
  REQUIRE(model->material_pairs.size() == 1);
  CHECK(model->material_pairs[0].rolling_friction == 0.0);
  CHECK_FALSE(model->material_pairs[0].spinning_friction);
}

TEST_CASE("ellipsoids, cones and prisms are hulls of the right volume", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <ellipsoid name="egg" radii="20 30 50 cm" xyz="0 0 2"/>
    <cone name="pylon" radius="30 cm" length="80 cm" xyz="2 0 2"/>
    <prism name="wedge" outline="0 0 3 0 0 1" length="2" xyz="4 0 2"/>)");
  const Body &egg = body(*model, "egg"), &pylon = body(*model, "pylon"),
             &wedge = body(*model, "wedge");
  // m = 4/3 pi a b c rho, I = m (b^2 + c^2) / 5. The hull's second moments are 1.1e-5 larger.
  const double m = 4.0 / 3.0 * M_PI * 0.2 * 0.3 * 0.5 * 1000.0;
  CHECK(egg.mass == Approx(m).epsilon(1e-12));
  CHECK(near(egg.com, {0, 0, 0}, 1e-12));
  CHECK(egg.inertia(0, 0) == Approx(m * 0.34 / 5.0).epsilon(2e-5));
  CHECK(egg.inertia(2, 2) == Approx(m * 0.13 / 5.0).epsilon(2e-5));
  // m = pi r^2 l rho / 3, its centre l/4 above the base, I = 3/10 m r^2 about the axis; a polygon of 32
  // sides has 8.3e-6 more than a circle of its area.
  const double c = M_PI * 0.09 * 0.8 / 3.0 * 1000.0;
  CHECK(pylon.mass == Approx(c).epsilon(1e-12));
  CHECK(near(pylon.com, {0, 0, -0.2}, 1e-12));
  CHECK(pylon.inertia(2, 2) == Approx(0.3 * c * 0.09).epsilon(1e-5));
  // Half of a box; the centre of a triangle is at a third of its sides.
  CHECK(wedge.mass == Approx(3000.0).epsilon(1e-12));
  CHECK(near(wedge.com, {1.0, 1.0 / 3.0, 0}, 1e-12));
  // No point of the hull is farther from the ellipsoid than 0.52 % of its half axes.
  const Shape& shape = egg.shapes.at(0);
  REQUIRE(shape.type == ShapeType::convex_mesh);
  for (const Vec3& p : model->meshes[shape.mesh]->vertices)
    CHECK(std::abs(p.cwiseQuotient(Vec3(0.2, 0.3, 0.5)).norm() - 1.0) < 0.0052);
}

TEST_CASE("a rigid assembly is one body with the mass of its parts", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <assembly name="robot" xyz="1 2 0">
      <assembly name="chassis" rigid="true" xyz="0 0 4 cm">
        <box      name="deck"   size="24 14 4 cm" mass="1.2 kg" color="red"/>
        <cylinder name="mast"   radius="1 cm" length="12 cm" mass="80 g" xyz="8 0 8 cm"/>
        <sphere   name="caster" radius="2 cm" mass="50 g" friction="0" xyz="-9 0 -2 cm"/>
        <frame    name="eye"    xyz="8 0 14 cm" rpy="0 10 0 deg"/>
      </assembly>
      <imu name="imu" on="chassis.eye"/>
    </assembly>)");
  REQUIRE(model->bodies.size() == 1);
  const Body& chassis = body(*model, "robot.chassis");
  REQUIRE(chassis.shapes.size() == 3);
  CHECK(chassis.shapes[1].name == "robot.chassis.mast");
  CHECK(near(chassis.X_WB.p, {1, 2, 0.04}));

  const double total = 1.2 + 0.08 + 0.05;
  CHECK(chassis.mass == Approx(total).epsilon(1e-14));
  const Vec3 com = (0.08 * Vec3(0.08, 0, 0.08) + 0.05 * Vec3(-0.09, 0, -0.02)) / total;
  CHECK(near(chassis.com, com, 1e-15));
  // parallel axes, about the y axis through the common centre: d^2 = dx^2 + dz^2
  const auto far = [&](double m, double x, double z) {
    return m * ((x - com.x()) * (x - com.x()) + (z - com.z()) * (z - com.z()));
  };
  const double iyy = 1.2 / 12 * (0.24 * 0.24 + 0.04 * 0.04) + far(1.2, 0, 0) +
                     0.08 * (3 * 0.01 * 0.01 + 0.12 * 0.12) / 12 + far(0.08, 0.08, 0.08) +
                     0.4 * 0.05 * 0.02 * 0.02 + far(0.05, -0.09, -0.02);
  CHECK(chassis.inertia(1, 1) == Approx(iyy).epsilon(1e-12));

  const Material& caster = model->materials[chassis.shapes[2].material];
  CHECK(caster.friction == 0.0);
  REQUIRE(model->sensors.size() == 1);
  CHECK(model->sensors[0].body == 0);
  CHECK(near(model->sensors[0].X_BS.p, {0.08, 0, 0.14}));
  REQUIRE(model->frames.size() == 1);
  CHECK(model->frames[0].name == "robot.chassis.eye");
  CHECK(model->frames[0].body == 0);
}

TEST_CASE("assemblies have the poses of their elements", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <assembly name="a" xyz="1 2 0" rpy="0 0 90 deg">
      <box name="b" size="1 1 1" mass="1 kg" xyz="0 0 3"/>
      <assembly name="c" rigid="true" xyz="2 0 0"><box name="d" size="1 1 1" mass="1 kg"/></assembly>
    </assembly>)");
  REQUIRE(model->assemblies.size() == 2);
  // sums of a few products of numbers below 4, in double
  CHECK(near(model->assemblies[0].X_WA.p, {1, 2, 0}, 1e-14));
  CHECK(near(model->assemblies[0].X_WA * Vec3(1, 0, 0), {1, 3, 0}, 1e-14));
  CHECK(near(model->assemblies[1].X_WA.p, {1, 4, 0}, 1e-14));
}

TEST_CASE("mass and material of a rigid assembly hold for the whole", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <material name="steel" density="7800 kg/m^3" friction="0.4"/>
    <material name="foam" density="50 kg/m^3" friction="0.9" color="blue"/>
    <assembly name="a" rigid="true" mass="6 kg" material="steel">
      <box name="l" size="1 1 1" material="foam" xyz="-1 0 0"/>
      <box name="r" size="1 1 1" xyz="1 0 0"/>
    </assembly>)");
  const Body& a = body(*model, "a");
  CHECK(a.mass == 6.0);
  CHECK(near(a.com, Vec3::Zero()));  // the same steel on both sides
  CHECK(a.inertia(0, 0) == Approx(6.0 / 6).epsilon(1e-12));
  CHECK(a.inertia(2, 2) == Approx(6.0 / 6 + 6.0).epsilon(1e-12));
  const Material& left = model->materials[a.shapes[0].material];
  CHECK(left.friction == 0.4);
  CHECK(left.color.b > 0.9);  // each part keeps its appearance
}

TEST_CASE("a body takes mass, centre and inertia as written", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <body name="b" mass="2 kg" com="1 0 0 cm" inertia="1 2 2.5 0.1 0 0 kg*m^2">
      <box size="1 1 1"/>
    </body>)");
  const Body& b = body(*model, "b");
  CHECK(b.mass == 2.0);
  CHECK(near(b.com, {0.01, 0, 0}));
  CHECK(b.inertia(0, 1) == Approx(0.1));
  CHECK(b.inertia(2, 2) == Approx(2.5));
}

TEST_CASE("shapes that override a property share a derived material", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <material name="rubber" friction="0.9"/>
    <repeat count="5" var="i">
      <sphere name="s_${i}" radius="1 cm" material="rubber" friction="0.1" xyz="${i} 0 0"/>
    </repeat>)");
  REQUIRE(model->materials.size() == 3);  // default, rubber, its slippery variant
  CHECK(model->materials[2].base == 1);
  CHECK(model->materials[2].friction == 0.1);
}

TEST_CASE("poses follow parents and named frames in any order", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <box name="b" size="1 1 1" frame="a" xyz="1 0 0"/>
    <box name="a" size="1 1 1" frame="origin" xyz="0 0 1"/>
    <frame name="origin" xyz="0 5 0" rpy="0 0 90 deg"/>)");
  CHECK(near(body(*model, "a").X_WB.p, {0, 5, 1}));
  CHECK(near(body(*model, "b").X_WB.p, {0, 6, 1}, 1e-12));
}

TEST_CASE("an assembly moves as a whole at the start", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <assembly name="a" linear-velocity="1 0 0" angular-velocity="0 0 2 rad/s">
      <box name="b" size="1 1 1" xyz="0 3 0"/>
    </assembly>
    <box name="k" kinematic="true" size="1 1 1" xyz="9 0 0" linear-velocity="0 1 0"/>)");
  CHECK(near(body(*model, "a.b").V_WB.linear, {1 - 6, 0, 0}));
  CHECK(near(body(*model, "a.b").V_WB.angular, {0, 0, 2}));
  CHECK(body(*model, "k").kind == BodyKind::kinematic);
  CHECK(near(body(*model, "k").V_WB.linear, {0, 1, 0}));
}

TEST_CASE("collide names pairs of bodies and of assemblies", "[dsl][build]") {
  const auto model = compile_scene(R"(
    <assembly name="a"> <box name="p" size="1 1 1"/> <box name="q" size="1 1 1" xyz="2 0 0"/> </assembly>
    <box name="c" size="1 1 1" xyz="4 0 0"/>
    <collide between="a c" with="false"/>
    <collide between="a.p c" with="true"/>)");
  REQUIRE(model->no_collide.size() == 1);
  CHECK(model->no_collide[0] == BodyPair{1, 2});
}

TEST_CASE("a scene and its templates share the meshes of a file", "[dsl][build]") {
  const TemporaryFolder folder;
  folder.write("wedge.obj",
               "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
               "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const std::string path = folder.write("s.scene.xml", R"(<scene>
    <mesh name="a" file="wedge.obj" convex="true" mass="1 kg"/>
    <mesh name="b" file="wedge.obj" convex="true" mass="1 kg" scale="2" xyz="9 0 0"/>
    <template name="T"><mesh name="c" file="wedge.obj" convex="true" mass="1 kg"/></template>
  </scene>)");
  const dsl::CompileResult result = dsl::compile_file(path);
  REQUIRE(result.model);
  REQUIRE(result.model->meshes.size() == 2);
  REQUIRE(result.model->templates.size() == 1);
  const SceneModel& fragment = *result.model->templates[0].fragment;
  CHECK(fragment.meshes == std::vector<MeshPtr>{result.model->meshes[0]});
}

TEST_CASE("heights are listed row by row from the lowest y", "[dsl][build]") {
  const auto model =
      compile_scene(R"(<heightmap name="h" size="2 1" columns="3" heights="0 1 2 3 4 5 cm"/>)");
  REQUIRE(model->heightmaps.size() == 1);
  const HeightGrid& grid = *model->heightmaps[0];
  CHECK(grid.columns == 3);
  CHECK(grid.rows == 2);
  CHECK(grid.heights[5] == Approx(0.05));
  CHECK(body(*model, "h").kind == BodyKind::static_body);
}
