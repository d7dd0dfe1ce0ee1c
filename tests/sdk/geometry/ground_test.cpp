// Planes, heightmaps and meshes: penetration of shapes.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "brute_force.h"
#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/triangles.h"
#include "geometry/inside_shape.h"

using namespace cogrsim;
using namespace cogrsim::test;
using geometry::penetration;

namespace {

HeightGrid hills(RandomStream& random, double rise) {
  HeightGrid grid;
  grid.columns = 9;
  grid.rows = 7;
  grid.size_x = 4.0;
  grid.size_y = 3.0;
  for (int i = 0; i < 63; ++i) grid.heights.push_back(random.uniform(-rise, rise));
  return grid;
}

Shape heightmap(SceneModel& model, HeightGrid grid) {
  Shape shape;
  shape.type = ShapeType::heightmap;
  shape.heightmap = static_cast<int>(model.heightmaps.size());
  model.heightmaps.push_back(std::make_shared<const HeightGrid>(std::move(grid)));
  return shape;
}

Shape surface(SceneModel& model, TriangleMesh mesh) {
  Shape shape;
  shape.type = ShapeType::mesh;
  shape.mesh = static_cast<int>(model.meshes.size());
  model.meshes.push_back(std::make_shared<const TriangleMesh>(std::move(mesh)));
  return shape;
}

// Height of the triangle below or above (x, y), from the plane through its corners; NaN: beside it.
double height_on(const geometry::Triangle& t, double x, double y) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  const Vec3 p(x, y, 0.0);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 edge = t[(k + 1) % 3] - t[k];
    if (edge.x() * (y - t[k].y()) - edge.y() * (x - t[k].x()) < 0.0) return kNaN;
  }
  return t[0].z() - (n.x() * (x - t[0].x()) + n.y() * (y - t[0].y())) / n.z();
}

// Points of a convex shape's boundary: the support points of directions spread over the sphere.
std::vector<Vec3> boundary(const SceneModel& model, const Shape& shape, const Pose& X, int count) {
  std::vector<Vec3> out;
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  const Extent extent = extent_of(model, shape, X);
  const Vec3 middle = X.p;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    const Vec3 d(r * std::cos(golden * i), r * std::sin(golden * i), z);
    // From the centre to the boundary: bisection, by whether some direction separates point and
    // shape.
    double in = 0.0, out_at = 2.0;
    for (int k = 0; k < 40; ++k) {
      const double at = 0.5 * (in + out_at);
      (geometry::inside_shape(model, shape, X.inverse() * Vec3(middle + at * d)) ? in : out_at) =
          at;
    }
    out.push_back(middle + in * d);
  }
  return out;
}

}  // namespace

TEST_CASE("the ground of a heightmap lies on its triangles, not between the four samples") {
  RandomStream random(3, "ground");
  const HeightGrid grid = hills(random, 0.5);
  std::vector<geometry::Triangle> triangles;
  geometry::for_triangles(grid, geometry::all_bounds(),
                          [&](const geometry::Triangle& t) { triangles.push_back(t); });
  REQUIRE(triangles.size() == 2 * 8 * 6);
  SceneModel model;
  const Shape shape = heightmap(model, grid);
  for (int i = 0; i < 2000; ++i) {
    const double x = random.uniform(-2.0, 2.0), y = random.uniform(-1.5, 1.5);
    double ground = kNaN;
    for (const geometry::Triangle& t : triangles)
      if (const double h = height_on(t, x, y); !std::isnan(h)) ground = h;
    CHECK(geometry::ground_height(grid, x, y) == Approx(ground).margin(1e-12));
    CHECK(geometry::inside_shape(model, shape, {x, y, ground - 1e-6}));
    CHECK_FALSE(geometry::inside_shape(model, shape, {x, y, ground + 1e-6}));
  }
  // The saddle that distinguishes the two: bilinear it is 0.5 in the middle, its diagonal is 0.
  HeightGrid saddle;
  saddle.columns = saddle.rows = 2;
  saddle.heights = {0.0, 1.0, 1.0, 0.0};
  CHECK(geometry::ground_height(saddle, 0.0, 0.0) == Approx(0.0).margin(1e-15));
  CHECK(geometry::ground_height(saddle, 0.5, 0.5) == Approx(0.0).margin(1e-15));
  CHECK(geometry::ground_height(saddle, 0.5, -0.5) == Approx(1.0));
  CHECK(geometry::ground_height(saddle, 0.500001, 0.0) == -kInfinity);
}

TEST_CASE("the triangles near a box are those not separated from it") {
  RandomStream random(4, "near");
  const HeightGrid grid = hills(random, 0.1);
  for (int i = 0; i < 200; ++i) {
    geometry::Bounds where;
    for (int k = 0; k < 2; ++k)
      where.add({random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-1, 1)});
    where.low.z() = -1.0;
    where.high.z() = 1.0;
    int all = 0, near = 0;
    geometry::for_triangles(grid, geometry::all_bounds(), [&](const geometry::Triangle& t) {
      if (!geometry::bounds_of(t).disjoint(where)) ++all;
    });
    geometry::for_triangles(grid, where, [&](const geometry::Triangle& t) {
      if (!geometry::bounds_of(t).disjoint(where)) ++near;
    });
    CHECK(all == near);
  }
}

TEST_CASE("the penetration of every convex shape in a plane is its extent below it") {
  RandomStream random(5, "plane");
  Shape plane;
  plane.type = ShapeType::plane;
  int deep = 0;
  for (const std::string& kind : convex_kinds())
    for (int trial = 0; trial < 40; ++trial) {
      SceneModel model;
      const Shape shape = convex_shape(kind, random, model);
      const Pose X_WP = random_pose(random, 2.0), X_WS = X_WP * random_pose(random, 1.2);
      const Vec3 up = X_WP.q * Vec3::UnitZ();
      const double below = extent_of(model, shape, X_WS)(-up) + up.dot(X_WP.p);
      const auto in = penetration(model, plane, X_WP, shape, X_WS);
      INFO(kind);
      CHECK(in.depth == Approx(std::max(below, 0.0)).margin(1e-12));
      CHECK((in.normal - up).norm() < 1e-12);
      CHECK((penetration(model, shape, X_WS, plane, X_WP).normal + up).norm() < 1e-12);
      if (below > 0.0) ++deep;
    }
  CHECK(deep > 50);
}

TEST_CASE("the penetration in a heightmap is the lift that separates the shape") {
  // Between the points of a boundary that are compared the ground may be higher by the slope times
  // their distance: 1 m sqrt(4 pi / 4000) < 0.06 m apart, a slope of 0.6 for ground and shape each.
  constexpr int kPoints = 4000;
  constexpr double kBetween = 0.08;
  RandomStream random(6, "heightmap");
  int deep = 0;
  for (const std::string& kind : convex_kinds())
    for (int trial = 0; trial < 8; ++trial) {
      SceneModel model;
      const Shape shape = convex_shape(kind, random, model);
      const HeightGrid grid = hills(random, 0.15);
      const Shape ground = heightmap(model, grid);
      Pose X_GS = random_pose(random, 0.8);
      if (trial == 0) X_GS.p.z() = -3.0;  // below the ground, and not near any triangle
      const Pose X_WG = random_pose(random, 4.0), X_WS = X_WG * X_GS;
      double lift = -kInfinity;
      for (const Vec3& p : boundary(model, shape, X_GS, kPoints))
        lift = std::max(lift, geometry::ground_height(grid, p.x(), p.y()) - p.z());
      INFO(kind << ", trial " << trial << ": tried " << lift << " m");
      const auto in = penetration(model, ground, X_WG, shape, X_WS);
      CHECK(in.depth >= lift - 1e-6);
      CHECK(in.depth <= std::max(lift + kBetween, 0.0));
      if (lift <= 0.0) continue;
      ++deep;
      CHECK((in.normal - X_WG.q * Vec3::UnitZ()).norm() < 1e-12);
      // Lifted by this distance it just touches; by less it still penetrates.
      const auto lifted = [&](double by) {
        const Pose X(X_WS.p + by * in.normal, X_WS.q);
        return penetration(model, ground, X_WG, shape, X).depth;
      };
      CHECK(lifted(in.depth + 1e-7) == 0.0);
      CHECK(lifted(in.depth - 1e-3) == Approx(1e-3).margin(1e-7));
    }
  CHECK(deep >= 15);
}

TEST_CASE("the penetration in a mesh is that of the deepest triangle") {
  RandomStream random(8, "mesh");
  int deep = 0;
  for (const std::string& kind : convex_kinds())
    for (int trial = 0; trial < 8; ++trial) {
      SceneModel model;
      const Shape shape = convex_shape(kind, random, model);
      TriangleMesh mesh;
      for (int i = 0; i < 20; ++i)
        mesh.vertices.emplace_back(random.uniform(-2, 2), random.uniform(-2, 2),
                                   random.uniform(-2, 2));
      for (int i = 0; i < 6; ++i) mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
      const Shape ground = surface(model, mesh);
      const Pose X_WG = random_pose(random, 4.0), X_WS = X_WG * random_pose(random, 1.0);
      const Extent S = extent_of(model, shape, X_WS);
      double tried = 0.0;
      for (const Eigen::Vector3i& t : mesh.triangles) {
        std::vector<Vec3> corners;
        for (const int i : t) corners.push_back(X_WG * mesh.vertices[i]);
        tried = std::max(tried, least_overlap(extent_of(corners), S));
      }
      INFO(kind << ", trial " << trial);
      const auto in = penetration(model, ground, X_WG, shape, X_WS);
      // The tried value is never below the true one, and close to it.
      CHECK(in.depth <= tried * (1.0 + 1e-4) + 1e-8);
      CHECK(in.depth >= tried * (1.0 - 1e-3) - 1e-6);
      if (in.depth > 1e-6) ++deep;
    }
  CHECK(deep > 15);
}

TEST_CASE("a shape that rests exactly on ground does not penetrate it") {
  SceneModel model;
  HeightGrid flat;
  flat.columns = flat.rows = 5;
  flat.size_x = flat.size_y = 4.0;
  flat.heights.assign(25, 0.25);
  TriangleMesh floor = geometry::triangles_of(flat);
  Shape plane;
  plane.type = ShapeType::plane;
  plane.X_BS.p.z() = 0.25;
  const std::vector<Shape> grounds = {heightmap(model, flat), surface(model, floor), plane};
  RandomStream random(9, "standing");
  for (const Shape& ground : grounds)
    for (const std::string& kind : convex_kinds())
      for (int trial = 0; trial < 10; ++trial) {
        const Shape shape = convex_shape(kind, random, model);
        Pose X(random.uniform(-0.9, 0.9) * Vec3::UnitX(), random_turn(random));
        if (trial == 0) X.q = Quat(1, 0, 0, 0);
        X.p.z() = 0.25 + extent_of(model, shape, X)(-Vec3::UnitZ()) + X.p.z();
        INFO(to_string(ground.type) << ", " << kind);
        CHECK(penetration(model, ground, ground.X_BS, shape, X).depth < 1e-8);
        X.p.z() -= 1e-3;
        CHECK(penetration(model, ground, ground.X_BS, shape, X).depth ==
              Approx(1e-3).epsilon(1e-4));
      }
}

TEST_CASE("a shape inside a closed mesh touches nothing, and ground touches no ground") {
  SceneModel model;
  HeightGrid flat;
  flat.columns = flat.rows = 2;
  flat.heights.assign(4, 0.0);
  const Shape map = heightmap(model, flat);
  TriangleMesh room;
  for (int i = 0; i < 8; ++i)
    room.vertices.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  for (const auto& [a, b, c] : std::vector<std::array<int, 3>>{{0, 2, 1},
                                                               {1, 2, 3},
                                                               {4, 5, 6},
                                                               {5, 7, 6},
                                                               {0, 1, 4},
                                                               {1, 5, 4},
                                                               {2, 6, 3},
                                                               {3, 6, 7},
                                                               {0, 4, 2},
                                                               {2, 4, 6},
                                                               {1, 3, 5},
                                                               {3, 7, 5}})
    room.triangles.emplace_back(a, b, c);
  const Shape mesh = surface(model, room);
  Shape ball;
  ball.type = ShapeType::sphere;
  ball.radius = 0.5;
  CHECK(penetration(model, mesh, {}, ball, {}).depth == 0.0);
  CHECK(penetration(model, mesh, {}, ball, Pose({0.6, 0, 0}, Quat(1, 0, 0, 0))).depth ==
        Approx(0.1));
  CHECK(penetration(model, mesh, {}, map, {}).depth == 0.0);
}
