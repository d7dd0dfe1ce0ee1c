// Scenes as URDF, SDF and MJCF, and back.
#include <catch2/catch.hpp>
#include <random>

#include "cogrsim/dsl/export_model.h"
#include "cogrsim/model/joint_kinematics.h"
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

SceneModelPtr compiled(const std::string& text) {
  const dsl::CompileResult result = dsl::compile_text(text, "robot.scene.xml");
  INFO(dsl::to_text(result.diagnostics));
  REQUIRE(result.ok());
  return result.model;
}

dsl::ExportResult exported(const SceneModelPtr& model, dsl::ExportFormat format,
                           const std::string& assembly = {}) {
  dsl::ExportOptions options;
  options.format = format;
  options.assembly = assembly;
  auto result = dsl::export_model(*model, options);
  REQUIRE(result);
  return *result;
}

/// The joints' frames are neither at the bodies' origins nor along their axes, and the joints do
/// not start at zero.
const char* const kArm = R"(
<scene name="arm" version="1">
  <assembly name="bot" xyz="0.3 -0.2 1" rpy="10 20 30 deg">
    <body name="base" mass="3 kg" com="0.01 0.02 0.03 m">
      <box size="0.4 0.3 0.2 m"/>
    </body>
    <body name="upper" xyz="0.1 0.2 0.3" rpy="0 0 40 deg" mass="1.5 kg">
      <capsule radius="4 cm" length="0.3 m" rpy="0 90 0 deg"/>
      <sphere radius="5 cm" xyz="0.15 0 0" visible="false"/>
    </body>
    <body name="hand" xyz="0.5 0.3 0.4" mass="0.2 kg" com="0 0.01 0">
      <cylinder radius="3 cm" length="0.1 m"/>
    </body>
    <hinge name="shoulder" parent="base" child="upper" xyz="0.05 0.1 0.2" axis="1 2 3"
           lower="-50 deg" upper="70 deg" damping="0.2 N*m*s/rad" friction="0.1 N*m" position="20 deg"/>
    <slider name="wrist" parent="upper" child="hand" axis="0 1 1" lower="-0.1 m" upper="0.2 m"/>
    <frame name="tool" frame="hand" xyz="0 0 0.1"/>
  </assembly>
</scene>
)";

std::string tail(const std::string& name) { return name.substr(name.rfind('.') + 1); }

/// Poses of all bodies relative to `base` at coordinates by joint name.
std::map<std::string, Pose> poses_at(const SceneModel& model, const std::string& base,
                                     const std::map<std::string, double>& q) {
  std::map<std::string, Pose> out;
  for (const Body& b : model.bodies)
    if (tail(b.name) == base) out[base] = Pose();
  for (std::size_t round = 0; round < model.joints.size(); ++round)
    for (const Joint& j : model.joints) {
      if (j.parent < 0 || j.child < 0) continue;
      const std::string parent = tail(model.bodies[j.parent].name);
      const std::string child = tail(model.bodies[j.child].name);
      if (out.count(parent) == 0 || out.count(child) != 0) continue;
      const auto given = q.find(tail(j.name));
      const double value = given == q.end() ? 0.0 : given->second;
      out[child] = out[parent] * j.X_PF * joint_pose(j, &value) * j.X_CM.inverse();
    }
  return out;
}

}  // namespace

TEST_CASE("a robot written as URDF, SDF or MJCF is the same when it is imported") {
  const SceneModelPtr model = compiled(kArm);
  const auto format =
      GENERATE(dsl::ExportFormat::urdf, dsl::ExportFormat::sdf, dsl::ExportFormat::mjcf);
  const dsl::ExportResult out = exported(model, format, "bot");
  INFO(dsl::format_name(format) << "\n" << out.text);
  Imported back;
  back.read(out.text, format == dsl::ExportFormat::urdf  ? "bot.urdf"
                      : format == dsl::ExportFormat::sdf ? "bot.sdf"
                                                         : "bot.xml");
  REQUIRE(back.model);
  REQUIRE(back.model->joints.size() == 2);
  // SDF's zero is the start.
  const double shift = format == dsl::ExportFormat::urdf ? 0.0 : model->joints[0].position[0];
  for (const Body& before : model->bodies) {
    const Body& after = back.body(tail(before.name));
    INFO(before.name);
    CHECK(after.mass == Approx(before.mass).epsilon(1e-12));
    // The inertia in axes of the link, which has those of the body; in URDF its origin moved.
    CHECK((after.inertia - before.inertia).norm() < 1e-12);
  }
  const Joint& shoulder = back.joint("shoulder");
  CHECK(shoulder.axes[0].lower + shift == Approx(model->joints[0].axes[0].lower).epsilon(1e-9));
  CHECK(shoulder.axes[0].upper + shift == Approx(model->joints[0].axes[0].upper).epsilon(1e-9));
  CHECK(shoulder.axes[0].damping == Approx(0.2));
  CHECK(shoulder.axes[0].friction == Approx(0.1));

  // Centres of mass at random coordinates; 1e-12 is the rounding of decimal text and of ten
  // multiplications.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  for (int i = 0; i < 100; ++i) {
    const double a = uniform(random), b = uniform(random);
    const auto before = poses_at(*model, "base", {{"shoulder", a}, {"wrist", b}});
    const auto after = poses_at(*back.model, "base", {{"shoulder", a - shift}, {"wrist", b}});
    REQUIRE(before.size() == 3);
    REQUIRE(after.size() == 3);
    for (const Body& body : model->bodies) {
      const std::string name = tail(body.name);
      const Vec3 one = before.at(name) * body.com, two = after.at(name) * back.body(name).com;
      CHECK((one - two).norm() < 1e-12);
      CHECK(before.at(name).q.angularDistance(after.at(name).q) < 1e-7);
    }
  }
}

TEST_CASE("joints with several axes become chains in URDF and several joints in MJCF") {
  const SceneModelPtr model = compiled(R"(
<scene name="joints" version="1">
  <assembly name="bot">
    <body name="a"><box size="1 1 1 m"/></body>
    <body name="b" xyz="2 0 0"><box size="1 1 1 m"/></body>
    <body name="c" xyz="4 0 0"><box size="1 1 1 m"/></body>
    <universal name="cross" parent="a" child="b" xyz="1 0 0"/>
    <screw name="thread" parent="b" child="c" xyz="3 0 0" axis="1 0 0" pitch="2 mm"/>
  </assembly>
</scene>
)");
  const dsl::ExportResult urdf = exported(model, dsl::ExportFormat::urdf, "bot");
  Imported back;
  back.read(urdf.text);
  INFO(urdf.text);
  REQUIRE(back.model);
  // Two axes of the cross, and the screw's angle and travel with a coupling.
  CHECK(back.model->joints.size() == 4);
  REQUIRE(back.model->couplings.size() == 1);
  CHECK(back.model->couplings[0].terms[0].ratio == Approx(0.002 / (2.0 * M_PI)).epsilon(1e-12));
  const dsl::ExportResult mjcf = exported(model, dsl::ExportFormat::mjcf, "bot");
  INFO(mjcf.text);
  back.read(mjcf.text, "bot.xml");
  REQUIRE(back.model);
  CHECK(back.model->couplings.size() == 1);
  CHECK(mjcf.count(kApproximate) == 1);  // the thread's softness
}

TEST_CASE("an export reports what a format cannot say") {
  const SceneModelPtr model = compiled(R"(
<scene name="room" version="1">
  <plane name="floor"/>
  <assembly name="bot">
    <body name="base"><box size="1 1 1 m"/></body>
    <body name="wheel" xyz="0 1 0"><sphere radius="0.2 m"/></body>
    <hinge name="axle" parent="base" child="wheel" axis="0 1 0" rotor-inertia="0.1"/>
    <motor name="drive" joint="axle" mode="velocity" max-torque="2 N*m"/>
    <infrared name="eye" on="base"/>
  </assembly>
  <plot name="speed" y="bot.axle.velocity"/>
</scene>
)");
  const auto find = [](const dsl::ExportResult& result, const std::string& element) {
    for (const dsl::ImportEntry& e : result.entries)
      if (e.element == element) return e;
    FAIL("no entry for " << element);
    return dsl::ImportEntry();
  };
  const dsl::ExportResult urdf = exported(model, dsl::ExportFormat::urdf);
  CHECK(find(urdf, "joint 'bot.axle'").fidelity == kApproximate);
  CHECK(find(urdf, "motor 'bot.drive'").fidelity == kLeftOut);
  CHECK(find(urdf, "motor 'bot.drive'").line == 8);
  CHECK(find(urdf, "infrared 'bot.eye'").fidelity == kLeftOut);
  CHECK(find(urdf, "plot 'speed'").fidelity == kLeftOut);
  CHECK(find(urdf, "plane of body 'floor'").fidelity == kLeftOut);
  const dsl::ExportResult mjcf = exported(model, dsl::ExportFormat::mjcf);
  CHECK(find(mjcf, "joint 'bot.axle'").fidelity == kExact);
  CHECK(find(mjcf, "motor 'bot.drive'").fidelity == kApproximate);
  CHECK(find(mjcf, "plane of body 'floor'").fidelity == kExact);
  const dsl::ExportResult sdf = exported(model, dsl::ExportFormat::sdf);
  CHECK(find(sdf, "infrared 'bot.eye'").fidelity == kApproximate);
  // Scene-wide elements are no part of an assembly.
  for (const dsl::ImportEntry& e : exported(model, dsl::ExportFormat::urdf, "bot").entries)
    CHECK(e.element != "plot 'speed'");
}

TEST_CASE("an export of an unknown assembly names the nearest one") {
  const SceneModelPtr model = compiled(kArm);
  dsl::ExportOptions options;
  options.assembly = "bat";
  const auto result = dsl::export_model(*model, options);
  REQUIRE(!result);
  CHECK(result.error().hint == "did you mean 'bot'?");
}
