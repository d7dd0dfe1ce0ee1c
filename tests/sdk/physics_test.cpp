// Capabilities, energy, momentum and hash.
#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"
#include "cogrsim/physics/capabilities.h"
#include "cogrsim/physics/frame.h"

using namespace cogrsim;
using Catch::Matchers::Contains;

namespace {

Pose at(double x, double y = 0, double z = 0) { return {Vec3(x, y, z), Quat(1, 0, 0, 0)}; }

WorldState initial_state(const SceneModel& model) {
  WorldState state;
  for (const Body& body : model.bodies) {
    state.poses.push_back(body.X_WB);
    state.twists.push_back(body.V_WB);
  }
  for (const Joint& joint : model.joints) {
    state.joint_positions.insert(state.joint_positions.end(), joint.position.begin(),
                                 joint.position.end());
    state.joint_velocities.insert(state.joint_velocities.end(), joint.velocity.begin(),
                                  joint.velocity.end());
  }
  return state;
}

/// Exactly the features that two spheres on a plane need.
Capabilities spheres_on_planes() {
  Capabilities c;
  for (const char* feature :
       {"shape.sphere", "shape.plane", "pair.sphere-sphere", "pair.sphere-plane", "body.static"}) {
    c.set(feature, Support::exact);
  }
  return c;
}

}  // namespace

TEST_CASE("an undeclared feature is unsupported", "[capabilities]") {
  const Capabilities c = spheres_on_planes();
  CHECK(c.get("shape.sphere").support == Support::exact);
  CHECK(c.get("joint.screw").support == Support::unsupported);
  CHECK(c.get("joint.screw").note == "not known to this backend");
  CHECK(pair_feature(ShapeType::mesh, ShapeType::box) == "pair.box-mesh");
}

TEST_CASE("a scene within the capabilities gives no findings", "[capabilities]") {
  ModelBuilder b;
  b.plane("floor");
  b.sphere("a", 0.1, 1, at(0));
  b.sphere("b", 0.1, 1, at(1));
  CHECK(check_capabilities(*b.build(), "test", spheres_on_planes()).empty());
}

TEST_CASE("a feature that a backend lacks is an error at the element", "[capabilities]") {
  ModelBuilder b;
  b.model.files = {"lift.scene.xml"};
  const int a = b.sphere("a", 0.1, 1, at(0)), c = b.sphere("c", 0.1, 1, at(1));
  Joint& lift =
      b.model
          .joints[static_cast<std::size_t>(b.joint("robot.lift", JointType::screw, a, c, at(0)))];
  lift.origin = {0, 27, 48, 5};
  lift.axes[0].upper = 1.0;
  b.motor("robot.drive", 0, MotorMode::dc);
  Capabilities caps = spheres_on_planes();
  caps.set("joint.screw", Support::unsupported, "the engine has no screw");
  caps.set("joint.limit.screw", Support::approximate, "limits are springs");
  caps.set("motor.dc", Support::exact);
  const auto found = check_capabilities(*b.build(), "cogrsim", caps);
  REQUIRE(found.size() == 2);
  CHECK(found[0].severity == Severity::error);
  CHECK(found[0].code == "CG0801");
  CHECK(found[0].message ==
        "backend 'cogrsim' does not support joint type 'screw' (joint 'robot.lift')");
  CHECK(found[0].file == "lift.scene.xml");
  CHECK(found[0].line == 27);
  CHECK(found[0].column == 48);
  REQUIRE(found[0].notes.size() == 1);
  CHECK(found[0].notes[0].message == "the engine has no screw");
  CHECK_FALSE(found[0].help.empty());
  CHECK(found[1].severity == Severity::warning);
  CHECK(found[1].code == "CG2008");
  CHECK_THAT(found[1].message, Contains("only approximates limits of joint type 'screw'"));
}

TEST_CASE("only shape pairs that could meet count", "[capabilities]") {
  ModelBuilder b;
  const int floor = b.plane("floor");
  const int a = b.box("a", Vec3::Ones(), 1, at(0)), c = b.box("c", Vec3::Ones(), 1, at(3));
  Capabilities caps = spheres_on_planes();
  caps.set("shape.box", Support::exact);
  SECTION("every pair is named once") {
    b.box("d", Vec3::Ones(), 1, at(6));
    const auto found = check_capabilities(*b.build(), "test", caps);
    REQUIRE(found.size() == 2);
    CHECK_THAT(found[0].message,
               Contains("contact of box and box (shapes 'a.shape' and 'c.shape')"));
    CHECK_THAT(found[1].message, Contains("contact of box and plane"));
  }
  SECTION("whichever of the two types moves") {
    b.model.bodies[c].kind = BodyKind::static_body;
    b.model.bodies[a].kind = BodyKind::static_body;
    b.sphere("ball", 0.1, 1, at(9));
    const auto found = check_capabilities(*b.build(), "test", caps);
    REQUIRE(found.size() == 1);
    CHECK_THAT(found[0].message, Contains("contact of sphere and box"));
  }
  SECTION("filtered pairs do not count") {
    b.model.no_collide = {{a, c}, {floor, a}, {floor, c}};
    CHECK(check_capabilities(*b.build(), "test", caps).empty());
  }
  SECTION("nor do shapes that are only visible") {
    for (Body& body : b.model.bodies) body.shapes[0].collides = false;
    CHECK(check_capabilities(*b.build(), "test", caps).empty());
  }
  SECTION("nor two bodies that cannot move") {
    for (Body& body : b.model.bodies) body.kind = BodyKind::static_body;
    CHECK(check_capabilities(*b.build(), "test", caps).empty());
  }
}

TEST_CASE("all other features of a scene are checked", "[capabilities]") {
  ModelBuilder b;
  const int a = b.sphere("a", 0.1, 1, at(0)), c = b.sphere("c", 0.1, 1, at(1));
  b.model.bodies[c].kind = BodyKind::kinematic;
  b.model.materials[0].stiffness = 1e5;
  b.joint("first", JointType::hinge, c, a, at(0));
  Joint& second =
      b.model
          .joints[static_cast<std::size_t>(b.joint("second", JointType::ball, kWorld, a, at(0)))];
  second.axes[0].damping = second.axes[0].friction = second.axes[0].stiffness = 1;
  b.motor("m", 0, MotorMode::servo);
  std::string codes;
  for (const Diagnostic& d : check_capabilities(*b.build(), "test", spheres_on_planes())) {
    codes += d.message + "\n";
  }
  for (const char* words :
       {"kinematic bodies", "contact stiffness", "joint type 'hinge'",
        "loops closed by joint type 'ball'", "damping of joint type 'ball'",
        "friction of joint type 'ball'", "stiffness of joint type 'ball'", "motor mode 'servo'"}) {
    CHECK_THAT(codes, Contains(words));
  }
}

TEST_CASE("energy and momentum of a body with an offset centre of mass", "[frame]") {
  ModelBuilder b;
  b.model.physics.gravity = Vec3(0, -2, -9.81);
  const int body = b.body("rod", 2.0, Mat3(Vec3(0.1, 0.2, 0.25).asDiagonal()), at(1, 0, 3));
  Body& rod = b.model.bodies[body];
  rod.com = Vec3(0.5, 0, 0);
  rod.X_WB.q = Quat(Eigen::AngleAxisd(1.5707963267948966, Vec3::UnitZ()));  // x of it to y
  rod.V_WB = {Vec3(1, 0, 0), Vec3(0, 0, 4)};
  b.plane("floor");  // has no energy
  const SceneModelPtr model = b.build();
  const WorldState state = initial_state(*model);
  // The centre lies at (1, 0.5, 3) and moves with (1, 0, 0) + (0,0,4) x (0, 0.5, 0) = (-1, 0, 0).
  CHECK(energy_of(*model, state).kinetic == Approx(0.5 * 2 * 1 + 0.5 * 0.25 * 16));
  CHECK(energy_of(*model, state).potential == Approx(2 * (9.81 * 3 + 2 * 0.5)));
  const Momentum momentum = momentum_of(*model, state);
  CHECK((momentum.linear - Vec3(-2, 0, 0)).norm() < 1e-14);
  // r x p = (1, 0.5, 3) x (-2, 0, 0) = (0, -6, 1), and 0.25 * 4 about its own z.
  CHECK((momentum.angular - Vec3(0, -6, 2)).norm() < 1e-14);
}

TEST_CASE("springs of joints store energy", "[frame]") {
  ModelBuilder b;
  b.model.physics.gravity.setZero();
  const int a = b.sphere("a", 0.1, 1, at(0)), c = b.sphere("c", 0.1, 1, at(0));
  Joint& slider =
      b.model.joints[static_cast<std::size_t>(b.joint("s", JointType::slider, kWorld, a, at(0)))];
  slider.axes[0].stiffness = 100;
  slider.axes[0].rest = 0.1;
  slider.position = {0.3};
  Joint& ball =
      b.model.joints[static_cast<std::size_t>(b.joint("b", JointType::ball, kWorld, c, at(0)))];
  ball.axes[0].stiffness = 10;
  ball.position = {-std::cos(0.4), -std::sin(0.4), 0, 0};  // 0.8 rad, by the other quaternion
  const SceneModelPtr model = b.build();
  CHECK(energy_of(*model, initial_state(*model)).potential ==
        Approx(0.5 * 100 * 0.04 + 0.5 * 10 * 0.64));
}

TEST_CASE("the state hash sees every bit of the state and nothing else", "[frame]") {
  ModelBuilder b;
  const int a = b.sphere("a", 0.1, 1, at(0));
  b.joint("s", JointType::slider, kWorld, a, at(0));
  const SceneModelPtr model = b.build();
  const WorldState state = initial_state(*model);
  const std::uint64_t hash = state_hash(state);
  CHECK(state_hash(initial_state(*model)) == hash);
  WorldState other = state;
  other.joint_efforts = {1.0};
  CHECK(state_hash(other) == hash);
  const double tiny = 5e-324;
  other = state, other.poses[0].p.y() = tiny;
  CHECK(state_hash(other) != hash);
  other = state, other.poses[0].q.z() = tiny;
  CHECK(state_hash(other) != hash);
  other = state, other.twists[0].angular.x() = tiny;
  CHECK(state_hash(other) != hash);
  other = state, other.joint_positions[0] += tiny;
  CHECK(state_hash(other) != hash);
  other = state, other.joint_velocities[0] += tiny;
  CHECK(state_hash(other) != hash);
}
