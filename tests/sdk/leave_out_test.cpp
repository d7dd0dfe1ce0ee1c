// What a run leaves out of a scene, and what the scene has instead.
#include "cogrsim/physics/leave_out.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "cogrsim/model/builder.h"
#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/provenance.h"

namespace cogrsim {
namespace {

using Catch::Matchers::Contains;

/// Two balls on hinges with all that axes can have, a coupling that slips, and a mesh below.
SceneModelPtr scene() {
  ModelBuilder builder;
  const int left = builder.sphere("left", 0.1, 1.0, Pose(Vec3(0, 0, 1), Quat::Identity()));
  const int right = builder.sphere("right", 0.1, 1.0, Pose(Vec3(1, 0, 1), Quat::Identity()));
  for (const int body : {left, right}) {
    const int joint =
        builder.joint(body == left ? "a" : "b", JointType::hinge, kWorld, body, Pose());
    JointAxis& axis = builder.model.joints[joint].axes[0];
    axis.lower = -1.0;
    axis.upper = 1.0;
    axis.damping = axis.friction = axis.stiffness = 0.5;
    axis.rotor_inertia = body == left ? 0.2 : 0.0;
  }
  Coupling coupling;
  coupling.name = "gear";
  coupling.joint = 1;
  coupling.terms = {{0, 2.0}};
  coupling.max_effort = 3.0;
  builder.model.couplings.push_back(coupling);
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1, 0.1, 0.1}};
  mesh.triangles = {{0, 2, 4}, {2, 3, 4}, {3, 0, 4}, {0, 1, 2}, {1, 3, 2}, {0, 3, 1}};
  builder.mesh("ground", mesh, false, 0.0, Pose());
  return builder.build();
}

Capabilities everything() {
  Capabilities out;
  set_shape_features(out);
  set_joint_features(out);
  out.set_all(
      {"joint.rotor-inertia.hinge", "joint.coupling", "joint.coupling-effort", "body.static"},
      Support::exact);
  return out;
}

bool refused(const SceneModelPtr& model, const Capabilities& capabilities) {
  for (const Diagnostic& d : check_capabilities(*model, "x", capabilities))
    if (d.severity == Severity::error) return true;
  return false;
}

}  // namespace

TEST_CASE("what an engine lacks is left out when it is asked for, and nothing else",
          "[leave-out]") {
  const SceneModelPtr model = scene();
  Capabilities has = everything();
  CHECK_FALSE(refused(model, has));
  CHECK(leave_out(model, has, {}) == model);
  CHECK(leave_out(model, has, {"lacking"}) == model);
  // Each feature by itself: refused with it, and not without.
  for (const char* feature :
       {"joint.limit.hinge", "joint.damping.hinge", "joint.friction.hinge", "joint.stiffness.hinge",
        "joint.rotor-inertia.hinge", "joint.coupling", "joint.coupling-effort", "shape.sphere",
        "pair.sphere-sphere", "pair.sphere-mesh"}) {
    INFO(feature);
    Capabilities lacks = has;
    lacks.set(feature, Support::unsupported, "for the test");
    CHECK(refused(model, lacks));
    const auto errors = check_capabilities(*model, "x", lacks);
    CHECK_THAT(errors.front().help, Contains(std::string("--without ") + feature));
    for (const char* name : {"lacking", feature}) {
      std::vector<LeftOut> found;
      const SceneModelPtr without = leave_out(model, lacks, {name}, &found);
      CHECK_FALSE(refused(without, lacks));
      REQUIRE(found.size() == 1);
      CHECK(found[0].feature == feature);
      // And nothing is left to take out.
      CHECK(leave_out(without, lacks, {name}) == without);
    }
  }
}

TEST_CASE("a scene without a feature has what the table says instead", "[leave-out]") {
  const SceneModelPtr model = scene();
  const Capabilities has = everything();
  std::vector<LeftOut> found;
  const SceneModelPtr free =
      leave_out(model, has, {"limits", "rotor-inertia", "couplings"}, &found);
  CHECK(to_text(found) ==
        "joint.coupling (1 coupling), joint.limit.hinge (2 joints), joint.rotor-inertia.hinge (1 "
        "joint)");
  CHECK_FALSE(free->joints[0].axes[0].has_limit());
  CHECK(free->joints[0].axes[0].rotor_inertia == 0.0);
  CHECK(free->joints[0].axes[0].damping == 0.5);
  CHECK(free->couplings[0].removed);
  CHECK(model->joints[0].axes[0].rotor_inertia == 0.2);  // the scene itself stays

  const SceneModelPtr firm = leave_out(model, has, {"joint.coupling-effort"});
  CHECK_FALSE(firm->couplings[0].removed);
  CHECK(std::isinf(firm->couplings[0].max_effort));

  // The mesh is seen as before, and collides as its hull, which has not the corner inside.
  const SceneModelPtr hulled = leave_out(model, has, {"pair.sphere-mesh"});
  const std::vector<Shape>& shapes = hulled->bodies.back().shapes;
  REQUIRE(shapes.size() == 2);
  CHECK(shapes[0].visible);
  CHECK_FALSE(shapes[0].collides);
  CHECK(shapes[1].type == ShapeType::convex_mesh);
  CHECK(shapes[1].collides);
  CHECK_FALSE(shapes[1].visible);
  CHECK(hulled->meshes[shapes[1].mesh]->triangles.size() == 4);

  const CollisionFilter before(*model), after(*leave_out(model, has, {"pair.sphere-sphere"}));
  CHECK(before.collide(0, 1));
  CHECK_FALSE(after.collide(0, 1));
  CHECK(after.collide(0, 2));
}

TEST_CASE("a loop that is left out is open, without motors and sensors of it", "[leave-out]") {
  ModelBuilder builder;
  const int a = builder.sphere("a", 0.1, 1.0, Pose());
  const int b = builder.sphere("b", 0.1, 1.0, Pose(Vec3(1, 0, 0), Quat::Identity()));
  builder.joint("one", JointType::hinge, kWorld, a, Pose());
  builder.joint("two", JointType::hinge, a, b, Pose());
  const int last = builder.joint("three", JointType::slider, kWorld, b, Pose());
  Motor motor;
  motor.name = "push";
  motor.joint = last;
  builder.model.motors.push_back(motor);
  SensorModel sensor;
  sensor.name = "read";
  sensor.joint = last;
  builder.model.sensors.push_back(sensor);
  mark_loops(builder.model);
  const SceneModelPtr model = builder.build();
  REQUIRE(model->joints[last].closes_loop);
  std::vector<LeftOut> found;
  const SceneModelPtr open = leave_out(model, {}, {"loops"}, &found);
  CHECK(to_text(found) == "loop.slider (1 joint)");
  CHECK(open->joints[last].removed);
  CHECK(open->motors[0].removed);
  CHECK(open->sensors[0].removed);
  CHECK_FALSE(open->joints[0].removed);
}

TEST_CASE("names of what is left out are checked", "[leave-out]") {
  for (const char* good : {"lacking", "couplings", "limits", "loops", "rotor-inertia", "loop",
                           "joint.limit", "joint.limit.ball", "joint.coupling", "pair.box-mesh"})
    CHECK(check_without({good}));
  const auto unknown = check_without({"lacking", "coupling"});
  REQUIRE_FALSE(unknown);
  CHECK(unknown.error().message == "there is nothing 'coupling' to leave out");
  CHECK_THAT(unknown.error().hint, Contains("did you mean 'couplings'?"));
  const auto essential = check_without({"joint.screw"});
  REQUIRE_FALSE(essential);
  CHECK_THAT(essential.error().message, Contains("cannot be left out"));
  for (const char* bad :
       {"", "joint", "shape", "motor.servo", "body.static", "joint.limit.", "limit"})
    CHECK_FALSE(check_without({bad}));
}

TEST_CASE("what was left out is part of a provenance, and of old ones nothing", "[leave-out]") {
  Provenance p;
  p.left_out = {{"joint.coupling", "coupling", 2}};
  for (const StepStage stage : kStepStages) p[stage] = {ComputedBy::none, "x"};
  std::string text = to_json_text(p);
  const auto read = parse_provenance(text);
  REQUIRE(read);
  CHECK(to_text(read->left_out) == "joint.coupling (2 couplings)");
  const std::string key = R"("left_out":[{"count":2,"feature":"joint.coupling","of":"coupling"}],)";
  REQUIRE(text.find(key) != std::string::npos);
  text.erase(text.find(key), key.size());
  REQUIRE(parse_provenance(text));
  CHECK(parse_provenance(text)->left_out.empty());
}

}  // namespace cogrsim
