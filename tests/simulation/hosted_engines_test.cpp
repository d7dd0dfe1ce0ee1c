// What the adapters of engines that are one object for each scene keep to, beside what EngineWorld does for them.
#include <cmath>

#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

Pose at(double x, double y, double z) { return {Vec3(x, y, z), Quat(1, 0, 0, 0)}; }

std::unique_ptr<World> world_of(const std::string& engine, const SceneModelPtr& model) {
  const auto plugins = loader();
  auto world = (*plugins->backend(engine))->create_world(model);
  if (!world) FAIL(world.error().text());
  return std::move(*world);
}

WorldState state_of(const World& world) {
  WorldState out;
  world.get_state(out);
  return out;
}

void run(World& world, double seconds) {
  const double dt = 1e-3;
  for (std::int64_t left = std::llround(seconds / dt); left > 0; --left) {
    const StepResult result = world.step(dt, {});
    if (result.status != StepStatus::ok) FAIL(result.message);
  }
}

/// A level square of 2 m.
TriangleMesh level(double height) {
  TriangleMesh out;
  out.vertices = {{-1, -1, height}, {1, -1, height}, {1, 1, height}, {-1, 1, height}};
  out.triangles = {{0, 1, 2}, {0, 2, 3}};
  return out;
}

}  // namespace

TEST_CASE("a step that fails moves nothing, and another one follows it", "[hosted]") {
  const std::string engine = GENERATE(as<std::string>(), "bullet", "dart", "ode", "simbody");
  INFO(engine);
  ModelBuilder builder;
  const int ball = builder.sphere("ball", 0.1, 1.0, at(3, 0, 1));
  const int lift = builder.box("lift", Vec3(0.2, 0.2, 0.2), 1.0, at(1, 2, 3));
  builder.model.bodies[lift].kind = BodyKind::kinematic;
  builder.model.bodies[lift].V_WB = {Vec3(0.3, -0.1, 0.2), Vec3(0, 0, 1)};
  const auto world = world_of(engine, builder.build());
  run(*world, 0.1);
  const WorldState before = state_of(*world);
  WorldState wild = before;
  wild.twists[ball].linear.x() = 1e300;
  REQUIRE(world->set_state(wild));
  REQUIRE(world->step(1e-3, {}).status == StepStatus::diverged);
  const WorldState after = state_of(*world);
  for (const int body : {ball, lift}) {
    // Rounding of poses in another frame; a step is 0.4 mm and 1 mrad.
    CHECK((after.poses[body].p - before.poses[body].p).norm() < 1e-12);
    CHECK(after.poses[body].q.angularDistance(before.poses[body].q) < 1e-7);
  }
  REQUIRE(world->set_state(before));
  run(*world, 0.1);
  const Vec3 way = Vec3(1, 2, 3) + 0.2 * Vec3(0.3, -0.1, 0.2);
  CHECK((state_of(*world).poses[lift].p - way).norm() < 1e-9);
}

TEST_CASE("a change that is refused leaves nothing to the next one", "[hosted]") {
  // ODE refuses a hull without volume, and keeps what it has made of meshes.
  ModelBuilder builder;
  const int ball = builder.sphere("ball", 0.1, 1.0, at(0, 0, 1));
  const auto world = world_of("ode", builder.build());
  ModelBuilder bad, good;
  bad.model = good.model = *world->model();
  bad.mesh("floor", level(0.0), false, 0.0, Pose());
  bad.mesh("flat", level(0.0), true, 0.0, at(5, 0, 0));
  REQUIRE_FALSE(world->add(bad.build()));
  good.mesh("floor", level(0.5), false, 0.0, Pose());
  REQUIRE(world->add(good.build()));
  run(*world, 1.0);
  // It lies on the second floor, as deep as a body may after a fall of 0.4 m.
  CHECK(state_of(*world).poses[ball].p.z() == Approx(0.6).margin(2e-3));
}

TEST_CASE("a contact without any stiffness harms nothing", "[hosted]") {
  const std::string engine = GENERATE(as<std::string>(), "bullet", "ode", "simbody");
  INFO(engine);
  ModelBuilder builder;
  const int nothing = builder.material("nothing", 0.5);
  builder.model.materials[nothing].stiffness = 0.0;
  builder.plane("floor");
  const int ball = builder.sphere("ball", 0.1, 1.0, at(0, 0, 0.099), nothing);
  const auto world = world_of(engine, builder.build());
  run(*world, 0.1);
  CHECK(state_of(*world).poses[ball].p.allFinite());
}
