// The backend cogrsim on several threads: no bit of a result depends on how many.
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

// Columns of boxes, balls and cylinders that fall over each other: heaps, small islands, free flight.
ModelBuilder columns() {
  ModelBuilder builder("columns");
  builder.plane("floor");
  constexpr int kRow = 8, kHigh = 4;
  for (int i = 0; i < kRow * kRow * kHigh; ++i) {
    const int level = i / (kRow * kRow);
    Pose X;
    X.p = Vec3(0.21 * (i % kRow), 0.21 * (i / kRow % kRow), 0.15 + 0.25 * level);
    X.p.x() += 0.03 * level;
    X.q = Quat(Eigen::AngleAxisd(0.3 * i, Vec3(1, 2, 3).normalized()));
    const std::string name = "body_" + std::to_string(i);
    if (i % 3 == 0) builder.box(name, Vec3(0.2, 0.15, 0.1), 1.0, X);
    if (i % 3 == 1) builder.sphere(name, 0.08, 0.5, X);
    if (i % 3 == 2) builder.cylinder(name, 0.06, 0.15, 0.7, X);
  }
  return builder;
}

std::uint64_t hash_on(SceneModel model, int threads) {
  model.physics.engine_options["cogrsim"]["threads"] = std::int64_t{threads};
  auto simulation = simulate(std::make_shared<const SceneModel>(std::move(model)), "cogrsim");
  CHECK(simulation->run_until(0.8) == RunStatus::completed);
  return state_hash(simulation->frame()->state);
}

}  // namespace

TEST_CASE("free bodies move the same on any number of threads", "[threads]") {
  const SceneModel model = *columns().build();
  const std::uint64_t alone = hash_on(model, 1);
  CHECK(hash_on(model, 2) == alone);
  CHECK(hash_on(model, 5) == alone);
}

TEST_CASE("jointed bodies among free ones move the same on any number of threads", "[threads]") {
  ModelBuilder builder = columns();
  for (int i = 0; i < 4; ++i) {
    Pose X;
    X.p = Vec3(0.4 * i, -0.6, 0.5);
    const int arm = builder.box("arm_" + std::to_string(i), Vec3(0.1, 0.9, 0.1), 5.0, X);
    builder.joint("hinge_" + std::to_string(i), JointType::hinge, kWorld, arm, X);
    builder.model.joints.back().velocity = {3.0};
  }
  const SceneModel model = *builder.build();
  const std::uint64_t alone = hash_on(model, 1);
  CHECK(hash_on(model, 2) == alone);
  CHECK(hash_on(model, 3) == alone);
}
