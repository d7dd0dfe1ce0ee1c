// What every backend guarantees besides physics: a complete capability table, a clock, a scene.
#include "cogrsim/physics/capabilities.h"
#include "scenes.h"

namespace conformance {
namespace {

constexpr JointType kJoints[] = {JointType::fixed,  JointType::hinge,       JointType::slider,
                                 JointType::screw,  JointType::cylindrical, JointType::universal,
                                 JointType::planar, JointType::ball,        JointType::free,
                                 JointType::gimbal};
constexpr ShapeType kShapes[] = {ShapeType::box,     ShapeType::sphere,   ShapeType::cylinder,
                                 ShapeType::capsule, ShapeType::plane,    ShapeType::convex_mesh,
                                 ShapeType::mesh,    ShapeType::heightmap};

bool immobile(ShapeType type) {
  return type == ShapeType::plane || type == ShapeType::mesh || type == ShapeType::heightmap;
}

// Every id that the documentation of Capabilities lists.
std::vector<std::string> documented_features() {
  std::vector<std::string> ids;
  for (const ShapeType a : kShapes) {
    ids.push_back(std::string("shape.") + to_string(a));
    for (const ShapeType b : kShapes) {
      if (!(immobile(a) && immobile(b))) ids.push_back(pair_feature(a, b));
    }
  }
  for (const JointType type : kJoints) {
    const std::string name = to_string(type);
    ids.push_back("joint." + name);
    ids.push_back("loop." + name);
    if (speed_count(type) == 0 || type == JointType::free) continue;
    for (const char* what : {"limit", "damping", "friction", "stiffness"}) {
      ids.push_back(std::string("joint.") + what + "." + name);
    }
  }
  for (const MotorMode mode : {MotorMode::velocity, MotorMode::torque, MotorMode::position,
                               MotorMode::servo, MotorMode::dc}) {
    ids.push_back(std::string("motor.") + to_string(mode));
  }
  for (const char* id :
       {"body.static", "body.kinematic", "contact.stiffness", "contact.rolling-friction",
        "contact.spinning-friction", "contact.surface-velocity", "runtime.add", "runtime.remove",
        "runtime.save", "runtime.set_state", "report.contact_force", "report.joint_reaction",
        "report.joint_effort"}) {
    ids.push_back(id);
  }
  return ids;
}

TEST_CASE("every documented capability is answered, with a note unless exact", "[contract]") {
  int exact = 0, approximate = 0, unsupported = 0;
  const Capabilities& known = backend().capabilities();
  for (const std::string& id : documented_features()) {
    INFO(id);
    CHECK(known.all().count(id) == 1);
    const Capability capability = known.get(id);
    exact += capability.support == Support::exact ? 1 : 0;
    approximate += capability.support == Support::approximate ? 1 : 0;
    unsupported += capability.support == Support::unsupported ? 1 : 0;
    if (capability.support != Support::exact) CHECK_FALSE(capability.note.empty());
  }
  observe("exact", exact);
  observe("approximate", approximate);
  observe("unsupported", unsupported);
}

TEST_CASE("a backend introduces itself", "[contract]") {
  CHECK(std::string(backend().name()).size() > 0);
  CHECK(std::string(backend().engine_version()).find('.') != std::string::npos);
}

TEST_CASE("a backend says who computes each stage of a step", "[contract]") {
  const SceneModel nothing;
  const auto provenance = provenance_of(backend(), nothing);
  INFO((provenance ? std::string() : provenance.error().message));
  REQUIRE(provenance);
  CHECK(provenance->backend == backend().name());
  CHECK(provenance->version == backend().engine_version());
  CHECK(provenance->options.size() == backend().world_options().size());
  // What is written is what is read back.
  const auto again = parse_provenance(to_json_text(*provenance));
  REQUIRE(again);
  CHECK(to_json_text(*again) == to_json_text(*provenance));
}

TEST_CASE("a world starts as its scene says", "[contract]") {
  Playground place = playground();
  place.builder.model.bodies[3].V_WB = {Vec3(1, 2, 3), Vec3(4, 5, 6)};
  const SceneModelPtr model = place.builder.build();
  Sim sim(model);
  CHECK(sim.world().time() == 0.0);
  REQUIRE(sim.state().poses.size() == model->bodies.size());
  REQUIRE(sim.state().twists.size() == model->bodies.size());
  REQUIRE(sim.state().joint_positions.size() == static_cast<std::size_t>(model->joint_positions));
  REQUIRE(sim.state().joint_velocities.size() == static_cast<std::size_t>(model->joint_speeds));
  REQUIRE(sim.state().joint_efforts.size() == static_cast<std::size_t>(model->joint_speeds));
  REQUIRE(sim.state().motor_efforts.size() == model->motors.size());
  for (std::size_t i = 0; i < model->bodies.size(); ++i) {
    const Body& body = model->bodies[i];
    // Rounding of a change of frame: from the body's origin to its centre of mass and back.
    measure("place [m]", (sim.state().poses[i].p - body.X_WB.p).norm(), 1e-12);
    measure("orientation [rad]", angle_between(sim.state().poses[i].q, body.X_WB.q), 1e-7);
    measure("velocity [m/s]", (sim.state().twists[i].linear - body.V_WB.linear).norm(), 1e-12);
    measure("spin [rad/s]", (sim.state().twists[i].angular - body.V_WB.angular).norm(), 1e-12);
  }
  for (const double effort : sim.state().joint_efforts) CHECK(effort == 0.0);
}

TEST_CASE("steps of changing length", "[contract]") {
  // The clock is the sum of the steps, and falling, resting and turning bodies are unaffected.
  ModelBuilder builder;
  builder.plane("floor");
  const int box = builder.box("box", Vec3(0.3, 0.3, 0.2), 1.0, at(0, 0, 0.1));
  const int ball = builder.sphere("ball", 0.1, 1.0, at(2, 0, 30));
  const int wheel = builder.cylinder("wheel", 0.2, 0.1, 1.0, at(-2, 0, 1));
  const int axle = builder.joint("axle", JointType::hinge, kWorld, wheel, at(-2, 0, 1));
  builder.motor("motor", axle, MotorMode::velocity);
  Sim sim(builder);
  sim.drives[0] = speed_source(3.0);
  double t = 0.0;
  for (int i = 0; i < 400; ++i) {
    const double dt = i % 3 == 0 ? 1e-3 : i % 3 == 1 ? 2.5e-4 : 4e-3;
    sim.step(dt);
    t += dt;
  }
  measure("clock error [s]", std::abs(sim.world().time() - t), 1e-12);
  measure("falling speed error [m/s]", std::abs(sim.twist(ball).linear.z() + 9.81 * t), 1e-9);
  measure("height error at rest [m]", std::abs(sim.pose(box).p.z() - 0.1), 1e-3);
  measure("driven angle error [rad]", std::abs(sim.q(axle) - 3.0 * t), 3.0 * 4e-3);
}

TEST_CASE("bodies without a shape, with an oblique inertia", "[contract]") {
  // Principal axes that are not the body's: spinning about one of them is steady.
  const Quat q_BP = turn(Vec3(1, 2, -1), 0.8);
  const Mat3 R = q_BP.toRotationMatrix();
  const Mat3 inertia = R * Vec3(0.02, 0.03, 0.04).asDiagonal() * R.transpose();
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const int body = builder.body("body", 1.0, inertia, at(0, 0, 0));
  const Vec3 spin = 3.0 * (q_BP * Vec3::UnitZ()), com(0.2, -0.1, 0.3);
  builder.model.bodies[0].com = com;
  builder.model.bodies[0].V_WB = {-spin.cross(com), spin};  // the centre of mass stands still
  Sim sim(builder);
  sim.run(2.0);
  measure("spin error [rad/s]", (sim.twist(body).angular - spin).norm(), 1e-6);
  measure("centre of mass error [m]", (sim.pose(body) * com - com).norm(), 1e-6);
}

}  // namespace
}  // namespace conformance
