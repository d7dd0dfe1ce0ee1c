// Which pairs of bodies are compared, and found to overlap.
#include <catch2/catch.hpp>

#include <map>

#include "brute_force.h"
#include "cogrsim/model/builder.h"

using namespace cogrsim;
using namespace cogrsim::test;
using geometry::find_overlaps;

namespace {

Pose at(double x, double y, double z) { return {Vec3(x, y, z), Quat(1, 0, 0, 0)}; }

}  // namespace

TEST_CASE("the tree of boxes loses no pair of a heap") {
  RandomStream random(11, "heap");
  ModelBuilder builder("heap");
  builder.plane("floor");
  HeightGrid grid;
  grid.columns = grid.rows = 6;
  grid.size_x = grid.size_y = 10.0;
  for (int i = 0; i < 36; ++i) grid.heights.push_back(random.uniform(0.0, 0.3));
  builder.heightmap("hills", grid, {});
  for (int i = 0; i < 150; ++i) {
    const std::string& kind = convex_kinds()[static_cast<std::size_t>(i) % 5];
    const int body = builder.body("b" + std::to_string(i), i % 7 == 0 ? 0.0 : 1.0, Mat3::Identity(),
                                  random_pose(random, 2.5));
    for (int k = 0; k <= i % 2; ++k) {
      Shape shape = convex_shape(kind, random, builder.model);
      shape.X_BS = random_pose(random, 0.3);
      builder.model.bodies[body].shapes.push_back(shape);
    }
    if (i % 7 == 0) builder.model.bodies.back().kind = BodyKind::static_body;
  }
  builder.joint("pin", JointType::hinge, 3, 4, {});
  const SceneModelPtr model = builder.build();
  const CollisionFilter filter(*model);
  std::map<std::pair<int, int>, double> expected;
  for (int a = 0; a < static_cast<int>(model->bodies.size()); ++a)
    for (int b = a + 1; b < static_cast<int>(model->bodies.size()); ++b) {
      if (!filter.collide(a, b)) continue;
      const Body& A = model->bodies[a];
      const Body& B = model->bodies[b];
      for (const Shape& s : A.shapes)
        for (const Shape& t : B.shapes) {
          const double depth =
              geometry::penetration(*model, s, A.X_WB * s.X_BS, t, B.X_WB * t.X_BS).depth;
          if (depth > geometry::kTouchingDepth)
            expected[{a, b}] = std::max(expected[{a, b}], depth);
        }
    }
  const geometry::Overlaps found = find_overlaps(*model);
  CHECK(found.complete);
  CHECK(expected.size() > 200);
  REQUIRE(found.pairs.size() == expected.size());
  std::size_t i = 0;
  for (const auto& [pair, depth] : expected) {
    const geometry::Overlap& overlap = found.pairs[i++];
    INFO(pair.first << " and " << pair.second);
    CHECK(std::pair(overlap.body_a, overlap.body_b) == pair);
    CHECK(overlap.depth == Approx(depth).epsilon(2e-4));
  }
}

TEST_CASE("joined, filtered and non-colliding bodies are not compared") {
  const auto count = [](const std::function<void(ModelBuilder&)>& change) {
    ModelBuilder builder("two");
    builder.cylinder("a", 0.5, 1.0, 1.0, at(0, 0, 0));
    builder.cylinder("b", 0.5, 1.0, 1.0, at(0.3, 0, 0));
    change(builder);
    return find_overlaps(*builder.build()).pairs.size();
  };
  CHECK(count([](ModelBuilder&) {}) == 1);
  CHECK(count([](ModelBuilder& b) { b.joint("j", JointType::hinge, 0, 1, {}); }) == 0);
  CHECK(count([](ModelBuilder& b) {
          b.model.joints[static_cast<std::size_t>(b.joint("j", JointType::hinge, 0, 1, {}))]
              .bodies_collide = true;
        }) == 1);
  CHECK(count([](ModelBuilder& b) { b.model.no_collide.push_back({0, 1}); }) == 0);
  CHECK(count([](ModelBuilder& b) { b.model.bodies[1].shapes[0].collides = false; }) == 0);
  CHECK(count([](ModelBuilder& b) {
          for (Body& body : b.model.bodies) body.kind = BodyKind::static_body;
        }) == 0);
  CHECK(count([](ModelBuilder& b) { b.model.bodies[0].removed = true; }) == 0);
}

TEST_CASE("normal and point say where two bodies meet") {
  ModelBuilder builder("two");
  builder.box("b", Vec3(1, 1, 1), 1.0, at(0, 0, 0));
  builder.sphere("s", 0.5, 1.0, at(0, 0, 0.9));
  const geometry::Overlaps found = find_overlaps(*builder.build());
  REQUIRE(found.pairs.size() == 1);
  CHECK(found.pairs[0].depth == Approx(0.1));
  CHECK((found.pairs[0].normal - Vec3::UnitZ()).norm() < 1e-9);
  CHECK((found.pairs[0].point - Vec3(0, 0, 0.45)).norm() < 1e-9);
}

TEST_CASE("checks of models made to be slow are aborted and reported") {
  Shape rod;
  rod.type = ShapeType::cylinder;
  const auto rods = [&](int bodies, int shapes, const Pose& X, const Vec3& step) {
    SceneModel model;
    for (int i = 0; i < bodies; ++i) {
      Body body;
      body.name = "r" + std::to_string(i);
      body.X_WB = {X.p + i * step, X.q};
      body.shapes.assign(static_cast<std::size_t>(shapes), rod);
      model.bodies.push_back(body);
    }
    return find_overlaps(model);
  };
  // Across each other's boxes, side by side: none touches another.
  rod.radius = 0.0003;
  rod.length = 1000.0;
  Pose X;
  X.q = Quat(Eigen::AngleAxisd(0.7853981633974483, Vec3::UnitX()));
  const geometry::Overlaps near = rods(3000, 1, X, {0, 0.001, 0});
  CHECK(near.pairs.empty());
  CHECK_FALSE(near.complete);
  // Two bodies of many shapes at the same position, where each comparison takes long.
  rod.radius = 1.0;
  const geometry::Overlaps same = rods(2, 1000, {}, Vec3::Zero());
  CHECK(same.pairs.size() == 1);
  CHECK_FALSE(same.complete);
}
