#include "cogrsim/model/scene_model.h"

#include <catch2/catch.hpp>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/model/joint_kinematics.h"

using namespace cogrsim;

namespace {
Pose at(double x, double y = 0, double z = 0) { return {Vec3(x, y, z), Quat(1, 0, 0, 0)}; }
}  // namespace

TEST_CASE("joints get consecutive indices in the flat arrays", "[model]") {
  ModelBuilder b;
  const int a = b.sphere("a", 0.1, 1, at(0)), c = b.sphere("c", 0.1, 1, at(1));
  const int d = b.sphere("d", 0.1, 1, at(2));
  b.joint("ball", JointType::ball, kWorld, a, at(0));
  b.joint("free", JointType::free, kWorld, c, at(0));
  b.joint("hinge", JointType::hinge, c, d, at(1.5));
  const SceneModelPtr model = b.build();
  CHECK(model->joint_positions == 4 + 7 + 1);
  CHECK(model->joint_speeds == 3 + 6 + 1);
  CHECK(model->joints[2].position_offset == 11);
  CHECK(model->joints[2].speed_offset == 9);
  CHECK(model->joints[0].position == std::vector<double>{1, 0, 0, 0});
  CHECK(model->joints[0].axes.size() == 1);
  CHECK(model->joints[1].axes.empty());
}

TEST_CASE("initial coordinates follow bodies that were moved after the joint", "[model]") {
  ModelBuilder b;
  const int cart = b.box("cart", Vec3::Ones(), 1, at(0));
  b.joint("rail", JointType::slider, kWorld, cart, {Vec3::Zero(), z_to(Vec3::UnitX())});
  b.model.bodies[0].X_WB.p.x() = 0.3;
  b.model.bodies[0].V_WB.linear.x() = 2.0;
  const SceneModelPtr model = b.build();
  CHECK(model->joints[0].position[0] == Approx(0.3));
  CHECK(model->joints[0].velocity[0] == Approx(2.0));
}

TEST_CASE("z_to turns z to any axis", "[model]") {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 0, 3), Vec3(0, 0, -1), Vec3(1, -2, 0.5)}) {
    CHECK((z_to(axis) * Vec3::UnitZ() - axis.normalized()).norm() < 1e-14);
  }
}

TEST_CASE("the joint that closes a loop is the later one", "[model]") {
  ModelBuilder b;
  std::vector<int> bars;
  for (int i = 0; i < 3; ++i)
    bars.push_back(b.box("bar" + std::to_string(i), Vec3::Ones(), 1, at(i)));
  const int post = b.box("post", Vec3::Ones(), 0, at(5));
  b.joint("1", JointType::hinge, kWorld, bars[0], at(0));
  b.joint("2", JointType::hinge, bars[0], bars[1], at(1));
  b.joint("3", JointType::hinge, bars[1], bars[2], at(2));
  b.joint("4", JointType::hinge, post, bars[2], at(3));  // a static body is ground, too
  const SceneModelPtr model = b.build();
  for (int i = 0; i < 4; ++i) CHECK(model->joints[i].closes_loop == (i == 3));
}

TEST_CASE("the collision filter excludes bodies that must not touch", "[model]") {
  ModelBuilder b;
  const int ball = b.sphere("ball", 0.1, 1, at(0)), arm = b.sphere("arm", 0.1, 1, at(1));
  const int hand = b.sphere("hand", 0.1, 1, at(2)), floor = b.plane("floor");
  const int wall = b.box("wall", Vec3::Ones(), 0, at(3));
  const int lift = b.box("lift", Vec3::Ones(), 1, at(4)),
            belt = b.box("belt", Vec3::Ones(), 1, at(5));
  b.model.bodies[lift].kind = BodyKind::kinematic;
  b.model.bodies[belt].kind = BodyKind::kinematic;
  b.joint("base", JointType::hinge, kWorld, arm, at(1));
  b.joint("elbow", JointType::hinge, arm, hand, at(1.5));
  b.model.joints[static_cast<std::size_t>(b.joint("rub", JointType::hinge, hand, ball, at(0)))]
      .bodies_collide = true;
  b.model.no_collide = {{wall, ball}, {ball, wall}};

  SECTION("by kind, joint and list") {
    const CollisionFilter filter(*b.build());
    CHECK_FALSE(filter.collide(ball, ball));
    CHECK_FALSE(filter.collide(floor, wall));
    CHECK_FALSE(filter.collide(lift, floor));
    CHECK_FALSE(filter.collide(lift, belt));
    CHECK(filter.collide(lift, ball));
    CHECK_FALSE(filter.collide(arm, hand));
    CHECK_FALSE(filter.collide(hand, arm));
    CHECK(filter.collide(hand, ball));
    CHECK(filter.collide(arm, floor));  // a joint to the world excludes nothing
    CHECK(filter.collide(ball, arm));
    CHECK_FALSE(filter.collide(ball, wall));
    CHECK_FALSE(filter.collide(wall, ball));
    CHECK_FALSE(filter.collide(kWorld, ball));
  }
  SECTION("removed bodies neither touch nor exclude") {
    b.model.bodies[ball].removed = true;
    b.model.joints[1].removed = true;
    const CollisionFilter filter(*b.build());
    CHECK_FALSE(filter.collide(ball, arm));
    CHECK(filter.collide(arm, hand));
  }
}

TEST_CASE("the filter holds a long list of pairs", "[model]") {
  SceneModel model;
  const int n = 300;
  model.bodies.resize(n);
  const auto excluded = [](int a, int b) { return (a * 7 + b * 7) % 3 == 0; };
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      if (excluded(a, b)) model.no_collide.emplace_back(b, a);
    }
  }
  finish_model(model);
  const CollisionFilter filter(model);
  bool agrees = true;
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      if (a != b) agrees = agrees && filter.collide(a, b) != excluded(a, b);
    }
  }
  CHECK(agrees);
}

TEST_CASE("the scene sets the contact of two materials", "[model]") {
  ModelBuilder b;
  const int ice = b.material("ice", 0.04, 0.1), rubber = b.material("rubber", 1.0, 0.8);
  const int wet = b.material("", 0.5, 0.0);  // an override of rubber
  b.model.materials[wet].base = rubber;

  SECTION("by the general rule") {
    const SurfacePair pair = surface_pair(b.model, ice, rubber);
    CHECK(pair.friction == Approx(0.2));
    CHECK(pair.restitution == 0.8);
    CHECK_FALSE(pair.stiffness);
    CHECK(pair.rolling_friction == 0.0);
    CHECK(pair.spinning_friction == 0.0);
  }
  SECTION("by the rule of a material, of two rules by the later one") {
    Material &one = b.model.materials[ice], &two = b.model.materials[rubber];
    const auto friction = [&](CombineRule first, CombineRule second) {
      one.friction_combine = first;
      two.friction_combine = second;
      return surface_pair(b.model, ice, rubber).friction;
    };
    using Rule = CombineRule;
    CHECK(friction(Rule::usual, Rule::average) == Approx(0.52));
    CHECK(friction(Rule::min, Rule::usual) == 0.04);
    CHECK(friction(Rule::min, Rule::multiply) == Approx(0.04));
    CHECK(friction(Rule::max, Rule::min) == 1.0);
    CHECK(friction(Rule::geometric, Rule::usual) == Approx(0.2));
    one.restitution_combine = Rule::multiply;
    CHECK(surface_pair(b.model, ice, rubber).restitution == Approx(0.08));
    two.restitution_combine = Rule::min;
    CHECK(surface_pair(b.model, rubber, ice).restitution == Approx(0.08));
    one.restitution_combine = Rule::usual;
    CHECK(surface_pair(b.model, ice, rubber).restitution == 0.1);
  }
  SECTION("the larger rolling and spinning friction holds") {
    b.model.materials[ice].rolling_friction = 1e-3;
    b.model.materials[rubber].rolling_friction = 3e-3;
    b.model.materials[ice].spinning_friction = 2e-3;
    CHECK(surface_pair(b.model, ice, rubber).rolling_friction == 3e-3);
    CHECK(surface_pair(b.model, rubber, ice).spinning_friction == 2e-3);
    MaterialPair own;
    own.a = ice;
    own.b = rubber;
    own.rolling_friction = 0.0;
    b.model.material_pairs.push_back(own);
    CHECK(surface_pair(b.model, ice, rubber).rolling_friction == 0.0);
    CHECK(surface_pair(b.model, ice, rubber).spinning_friction == 2e-3);  // not in the entry
  }
  SECTION("stiffnesses act in series") {
    b.model.materials[ice].stiffness = 3e4;
    CHECK(*surface_pair(b.model, ice, rubber).stiffness == 3e4);
    b.model.materials[rubber].stiffness = 6e4;
    CHECK(*surface_pair(b.model, rubber, ice).stiffness == Approx(2e4));
  }
  SECTION("by the pair's own entry, for overrides too") {
    MaterialPair own;
    own.a = rubber;
    own.b = ice;
    own.friction = 0.3;
    b.model.material_pairs.push_back(own);
    CHECK(surface_pair(b.model, ice, rubber).friction == 0.3);
    CHECK(surface_pair(b.model, ice, rubber).restitution == 0.8);  // not in the entry
    CHECK(surface_pair(b.model, wet, ice).friction == 0.3);
    CHECK(surface_pair(b.model, wet, rubber).friction == Approx(std::sqrt(0.5)));
  }
}

TEST_CASE("an assembly has the bodies of those inside it", "[model]") {
  ModelBuilder b;
  const int a = b.sphere("a", 0.1, 1, at(0)), c = b.sphere("c", 0.1, 1, at(1));
  const int d = b.sphere("d", 0.1, 1, at(2)), e = b.sphere("e", 0.1, 1, at(3));
  const int robot = b.assembly("robot", {a}), gripper = b.assembly("robot.gripper", {c, d});
  b.assembly("table", {e});
  b.model.assemblies[gripper].parent = robot;
  b.model.bodies[d].removed = true;
  CHECK(bodies_of(b.model, robot) == std::vector<int>{a, c});
  CHECK(bodies_of(b.model, gripper) == std::vector<int>{c});
}

TEST_CASE("names are looked up among existing elements", "[model]") {
  ModelBuilder b;
  const int a = b.sphere("a", 0.1, 1, at(0)), again = b.sphere("a", 0.1, 1, at(0));
  CHECK(find_body(b.model, "a") == a);
  b.model.bodies[a].removed = true;
  CHECK(find_body(b.model, "a") == again);
  CHECK(find_body(b.model, "b") == -1);
  CHECK(find_joint(b.model, "a") == -1);
}

TEST_CASE("positions read file:line:column", "[model]") {
  SceneModel model;
  model.files = {"maze.scene.xml"};
  const SourcePosition position = source_position(model, {0, 27, 48, 3});
  CHECK(position.position_text() == "maze.scene.xml:27:48");
  CHECK(position.length == 3);
  CHECK(source_position(model, SourceSpan{}).file.empty());
  CHECK(SourcePosition{"table.csv", 7}.position_text() == "table.csv:7");
  CHECK(SourcePosition{"table.csv"}.position_text() == "table.csv");
}

TEST_CASE("an error becomes a diagnostic and an error again without loss", "[model]") {
  const Error error("wrong", SourcePosition{"maze.scene.xml", 27, 48, 3}, "correct it", "CG0904");
  CHECK(error.text() == "maze.scene.xml:27:48: wrong\nhelp: correct it");
  const Diagnostic d = to_diagnostic(error, "CG0801");
  CHECK(d.file == "maze.scene.xml");
  CHECK(d.line == 27);
  CHECK(d.column == 48);
  CHECK(d.length == 3);
  CHECK(d.code == "CG0904");
  const Error back = to_error(d);
  CHECK(back.text() == error.text());
  CHECK(back.length == 3);
  CHECK(back.code == "CG0904");
  // What is no position in a file stays text.
  const Diagnostic of_robot = to_diagnostic(Error("wrong", "robot 'a'"), "CG0801");
  CHECK(of_robot.message == "robot 'a': wrong");
  CHECK(of_robot.file.empty());
  CHECK(of_robot.code == "CG0801");
}
