// Silhouettes, distances and labels against geometry.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cogrsim/rays/ray_caster.h"
#include "support.h"

namespace cogrsim::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// Area [pixel] and perimeter (of the mean circle) of a sphere's picture: the cone of half angle
/// alpha = asin(r/d) around a ray at angle theta from the axis meets the plane x = 1 in an ellipse
/// of half axes sin alpha cos alpha / (cos^2 theta - sin^2 alpha) and
/// sin alpha / sqrt(cos^2 theta - sin^2 alpha).
struct Disc {
  double area, perimeter;
};
Disc sphere_disc(const Camera& camera, const Vec3& centre, double radius) {
  const Vec3 p = camera.X_WC.inverse() * centre;
  const double sine = radius / p.norm(), cosine2 = p.x() * p.x() / p.squaredNorm();
  const double below = cosine2 - sine * sine;
  const double a = sine * std::sqrt(1.0 - sine * sine) / below, b = sine / std::sqrt(below);
  return {kPi * a * b * camera.fx * camera.fy, 2.0 * kPi * std::sqrt(a * b) * camera.fx};
}

TEST_CASE("a sphere covers the pixels of its projection", "[rendering]") {
  const Vec3 centre =
      GENERATE(Vec3(3, 0, 0), Vec3(3, 1.2, 0.8), Vec3(2, -0.9, -0.5), Vec3(9, 2, 1));
  const double radius = GENERATE(0.25, 0.6);
  ModelBuilder builder;
  builder.sphere("ball", radius, 1.0, {centre, Quat(1, 0, 0, 0)});
  const Camera camera = make_camera(Pose(), 480, 480, 1.6);
  const Picture picture = take(builder.build(), request_of(camera));
  const Disc disc = sphere_disc(camera, centre, radius);
  // Counting pixel middles inside a smooth closed curve errs by far less than a tenth of the pixels
  // along it, and so does a silhouette that is off by 0.05 pixels.
  CHECK(std::abs(count_body(picture, 0) - disc.area) < 0.1 * disc.perimeter);
}

TEST_CASE("a sphere's depth is the analytic distance", "[rendering]") {
  const Vec3 centre(2.5, 0.3, -0.2);
  const double radius = 0.7;
  ModelBuilder builder;
  builder.sphere("ball", radius, 1.0, {centre, Quat(1, 0, 0, 0)});
  const Camera camera = make_camera(Pose(), 320, 240, 1.0);
  const Picture picture = take(builder.build(), request_of(camera));
  int seen = 0;
  for (int row = 0; row < 240; ++row) {
    for (int column = 0; column < 320; ++column) {
      // Through the pixel's middle, one long along x: |t ray - centre| = radius.
      const Vec3 ray(1.0, (camera.cx - column - 0.5) / camera.fx,
                     (camera.cy - row - 0.5) / camera.fy);
      const double a = ray.squaredNorm(), b = ray.dot(centre);
      const double root = b * b - a * (centre.squaredNorm() - radius * radius);
      if (root < 0.0) continue;
      const double t = (b - std::sqrt(root)) / a;
      const Vec3 normal = (t * ray - centre) / radius;
      if (std::abs(normal.dot(ray.normalized())) < 0.3) continue;  // the last pixels of the rim
      ++seen;
      REQUIRE(std::abs(depth_at(picture, column, row) / t - 1.0) < 1e-3);
    }
  }
  CHECK(seen > 10000);
}

int add_shape(ModelBuilder& builder, ShapeType type, const Pose& X_WB) {
  switch (type) {
    case ShapeType::box:
      return builder.box("shape", Vec3(0.9, 0.7, 0.5), 1.0, X_WB);
    case ShapeType::sphere:
      return builder.sphere("shape", 0.5, 1.0, X_WB);
    case ShapeType::cylinder:
      return builder.cylinder("shape", 0.4, 0.9, 1.0, X_WB);
    case ShapeType::capsule:
      return builder.capsule("shape", 0.3, 0.8, 1.0, X_WB);
    case ShapeType::plane:
      return builder.plane("shape", X_WB);
    case ShapeType::heightmap: {
      HeightGrid grid;
      grid.columns = 8;
      grid.rows = 7;
      grid.size_x = 1.6;
      grid.size_y = 1.2;
      for (int i = 0; i < 56; ++i) grid.heights.push_back(0.15 * std::sin(1.7 * i));
      return builder.heightmap("shape", grid, X_WB);
    }
    case ShapeType::convex_mesh:
    case ShapeType::mesh:
      break;
  }
  // A pyramid; the convex one has a dent, which is seen though its hull has none.
  TriangleMesh mesh;
  mesh.vertices = {
      {0.6, 0, -0.3}, {-0.3, 0.5, -0.3}, {-0.3, -0.5, -0.3}, {0, 0, 0.5}, {0, -0.1, 0}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const bool convex = type == ShapeType::convex_mesh;
  if (convex) mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 4}, {0, 3, 4}, {3, 2, 4}};
  return builder.mesh("shape", mesh, convex, convex ? 1.0 : 0.0, X_WB);
}

TEST_CASE("depth and segmentation agree with rays on every shape", "[rendering]") {
  const ShapeType type =
      GENERATE(ShapeType::box, ShapeType::sphere, ShapeType::cylinder, ShapeType::capsule,
               ShapeType::plane, ShapeType::convex_mesh, ShapeType::mesh, ShapeType::heightmap);
  const bool far_from_origin = GENERATE(false, true);
  CAPTURE(to_string(type), far_from_origin);
  const Vec3 shift = far_from_origin ? Vec3(5000, -3000, 200) : Vec3(0, 0, 0);
  const Quat turn(Eigen::AngleAxisd(0.6, Vec3(0.3, 0.5, 0.8).normalized()));
  ModelBuilder builder;
  const int shape =
      add_shape(builder, type,
                {shift + Vec3(2.4, 0.1, -0.1),
                 type == ShapeType::plane ? Quat(Eigen::AngleAxisd(0.2, Vec3::UnitY())) : turn});
  const SceneModelPtr model = builder.build();
  Camera camera =
      make_camera(look(shift + Vec3(0, 0, 0.5), shift + Vec3(2.4, 0, 0)), 240, 180, 1.0);
  camera.cx += 31.0;  // off centre, not square
  camera.fy *= 1.1;
  const Picture picture = take(model, request_of(camera));
  RayCaster caster;
  std::vector<Pose> poses;
  for (const Body& body : model->bodies) poses.push_back(body.X_WB);
  caster.update(model, poses);
  const auto expected = [&](double column, double row) {
    const Vec3 ray_C(1.0, (camera.cx - column) / camera.fx, (camera.cy - row) / camera.fy);
    Ray ray;
    ray.origin = camera.X_WC.p;
    ray.direction = camera.X_WC.q * ray_C.normalized();
    const RayHit hit = caster.cast(ray);
    const double depth = hit.distance / ray_C.norm();
    return hit && depth <= camera.far ? depth : std::numeric_limits<double>::infinity();
  };
  int covered = 0, edges = 0;
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const double depth = expected(column + 0.5, row + 0.5);
      const float drawn = depth_at(picture, column, row);
      const bool hit = std::isfinite(depth);
      covered += hit ? 1 : 0;
      if (hit != std::isfinite(drawn)) {
        // Only a silhouette may be off, by less than half a pixel.
        bool edge = false;
        for (const double dx : {-0.5, 0.0, 0.5}) {
          for (const double dy : {-0.5, 0.0, 0.5}) {
            edge = edge || std::isfinite(expected(column + 0.5 + dx, row + 0.5 + dy)) != hit;
          }
        }
        CAPTURE(column, row, depth, drawn);
        REQUIRE(edge);
        ++edges;
        continue;
      }
      REQUIRE(body_at(picture, column, row) == (hit ? shape : -1));
      if (!hit || std::abs(drawn / depth - 1.0) < 1e-3) continue;
      // A glancing face or an edge within: there the graphics library, which puts corners on a
      // grid of 1/256 pixel, may be off. Rays a quarter of a pixel aside detect such pixels.
      double low = depth, high = depth;
      for (const double dx : {-0.25, 0.0, 0.25}) {
        for (const double dy : {-0.25, 0.0, 0.25}) {
          const double other = expected(column + 0.5 + dx, row + 0.5 + dy);
          low = std::min(low, other);
          high = std::max(high, other);
        }
      }
      CAPTURE(column, row, depth, drawn, low, high);
      REQUIRE(high - low > 1e-3 * depth);
      ++edges;
    }
  }
  CHECK(covered > 1000);
  // Silhouettes are some hundred pixels long; of them and of glancing ones but few may differ.
  CHECK(edges < 0.02 * covered + 20);
}

TEST_CASE("left is left and up is up", "[rendering]") {
  ModelBuilder builder;
  const int left = builder.box("left", Vec3(0.3, 0.3, 0.3), 1.0, at(3, 1, 0));
  const int right = builder.box("right", Vec3(0.3, 0.3, 0.3), 1.0, at(3, -1, 0));
  const int up = builder.box("up", Vec3(0.3, 0.3, 0.3), 1.0, at(3, 0, 0.8));
  const Camera camera = make_camera(Pose(), 320, 240, 1.2);
  const Picture picture = take(builder.build(), request_of(camera));
  for (const auto& [body, point] :
       {std::pair(left, Vec3(2.85, 1, 0)), std::pair(right, Vec3(2.85, -1, 0)),
        std::pair(up, Vec3(2.85, 0, 0.8))}) {
    const Eigen::Vector2d projected = project(camera, point);
    CHECK(body_at(picture, static_cast<int>(projected.x()), static_cast<int>(projected.y())) ==
          body);
  }
  CHECK(project(camera, Vec3(3, 1, 0)).x() < 160);
  CHECK(project(camera, Vec3(3, 0, 0.8)).y() < 120);
}

TEST_CASE("segmentation counts a box as large as it is", "[rendering]") {
  // A face 2 m ahead, 0.8 x 0.5 m, seen straight on: 0.8 fx / 2 by 0.5 fy / 2 pixels.
  ModelBuilder builder;
  const int near = builder.box("near", Vec3(0.2, 0.8, 0.5), 1.0, at(2.1, 0, 0));
  const int wall = builder.box("wall", Vec3(0.2, 100, 100), 0.0, at(5.1, 0, 0));
  Camera camera = make_camera(Pose(), 400, 300, 1.0);
  camera.fx = camera.fy = 350.3;  // no edge runs through the middles of pixels
  const Picture picture = take(builder.build(), request_of(camera));
  const double width = 0.8 * camera.fx / 2.0, height = 0.5 * camera.fy / 2.0;
  const int counted = count_body(picture, near);
  // Each side is at most one pixel longer or shorter.
  CHECK(std::abs(counted - width * height) < width + height + 1.0);
  CHECK(counted + count_body(picture, wall) == 400 * 300);
}

TEST_CASE("near and far bound the visible depth", "[rendering]") {
  ModelBuilder builder;
  const int near = builder.box("near", Vec3(0.1, 0.2, 0.2), 1.0, at(0.45, 0, 0));
  const int wall = builder.box("wall", Vec3(0.2, 10, 10), 0.0, at(8.1, 0, 0));
  const SceneModelPtr model = builder.build();
  Camera camera = make_camera(Pose(), 64, 64, 1.0);
  CHECK(body_at(take(model, request_of(camera)), 32, 32) == near);
  camera.near = 0.55;
  CHECK(body_at(take(model, request_of(camera)), 32, 32) == wall);
  camera.far = 7.0;
  const Picture nothing = take(model, request_of(camera));
  CHECK(body_at(nothing, 32, 32) == -1);
  CHECK(std::isinf(depth_at(nothing, 32, 32)));
  // A millimetre and a kilometre in one picture.
  camera.near = 1e-3;
  camera.far = 1e4;
  const Picture both = take(model, request_of(camera));
  CHECK(depth_at(both, 32, 32) == Approx(0.4).epsilon(1e-3));
  CHECK(depth_at(both, 2, 2) == Approx(8.0).epsilon(1e-3));
}

TEST_CASE("a plane reaches to the horizon at the right distances", "[rendering]") {
  ModelBuilder builder;
  const int floor = builder.plane("floor");
  Camera camera = make_camera(at(3, 4, 0.5), 200, 200, 1.2);
  camera.far = 500.0;
  const Picture picture = take(builder.build(), request_of(camera));
  int seen = 0;
  for (int row = 0; row < 200; ++row) {
    const double down = (row + 0.5 - camera.cy) / camera.fy;  // per metre ahead
    const double depth = down > 0.0 ? 0.5 / down : std::numeric_limits<double>::infinity();
    for (const int column : {0, 77, 199}) {
      if (depth > camera.far) {
        REQUIRE(body_at(picture, column, row) == -1);
      } else {
        REQUIRE(body_at(picture, column, row) == floor);
        REQUIRE(depth_at(picture, column, row) == Approx(depth).epsilon(1e-3));
        ++seen;
      }
    }
  }
  CHECK(seen > 250);
}

TEST_CASE("hidden and invisible things are not drawn", "[rendering]") {
  ModelBuilder builder;
  const int front = builder.box("front", Vec3(0.2, 1, 1), 1.0, at(2, 0, 0));
  const int back = builder.box("back", Vec3(0.2, 2, 2), 1.0, at(3, 0, 0));
  const int ghost = builder.box("ghost", Vec3(0.2, 1, 1), 1.0, at(1, 0, 0));
  builder.model.bodies[ghost].shapes[0].visible = false;
  const SceneModelPtr model = builder.build();
  RenderRequest request = request_of(make_camera(Pose(), 32, 32, 0.5));
  CHECK(body_at(take(model, request), 16, 16) == front);
  request.hidden_bodies = {front};
  CHECK(body_at(take(model, request), 16, 16) == back);
}

TEST_CASE("channels that were not requested are empty", "[rendering]") {
  ModelBuilder builder;
  builder.sphere("ball", 0.5, 1.0, at(2, 0, 0));
  const SceneModelPtr model = builder.build();
  RenderRequest request = request_of(make_camera(Pose(), 32, 24, 0.8));
  request.depth = request.segmentation = false;
  const Picture color = take(model, request);
  CHECK(color.color.data.size() == 3 * 32 * 24);
  CHECK((color.depth.empty() && color.bodies.empty()));
  request.color = false;
  request.depth = true;
  const Picture depth = take(model, request);
  CHECK(depth.depth.size() == 32 * 24);
  CHECK((depth.color.data.empty() && depth.bodies.empty()));
}

TEST_CASE("a picture drawn in parts is one picture", "[rendering]") {
  // Wider than a part; the ball lies on the seam.
  ModelBuilder builder;
  builder.sphere("ball", 0.6, 1.0, at(4, 0.1, 0));
  const Camera camera = make_camera(Pose(), 4300, 91, 1.0);
  const Picture picture = take(builder.build(), request_of(camera));
  // The middle row is one run of the ball's pixels: from its left tangent to its right one.
  const double distance = std::hypot(4.0, 0.1), bearing = std::atan2(0.1, 4.0);
  const double half = std::asin(0.6 / distance);
  const double left = camera.cx - camera.fx * std::tan(bearing + half);
  const double right = camera.cx - camera.fx * std::tan(bearing - half);
  for (int column = 0; column < 4300; ++column) {
    const bool inside = column + 0.5 > left && column + 0.5 < right;
    if (std::abs(column + 0.5 - left) < 2.0 || std::abs(column + 0.5 - right) < 2.0) continue;
    REQUIRE((body_at(picture, column, 45) == 0) == inside);
  }
}

}  // namespace
}  // namespace cogrsim::test
