// Shapes seen from above.
#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/map/map.h"

namespace cogrsim {

namespace {

using Point = Eigen::Vector2d;
using Polygon = std::vector<Point>;

// A polygon of n corners on a circle misses it by 1 - cos(pi / n) of the radius: 4.8e-4 here.
constexpr int kCorners = 102;

double cross(const Point& o, const Point& a, const Point& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

// Andrew's monotone chain, counter-clockwise.
Polygon convex_hull(Polygon points) {
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  Polygon hull(2 * points.size());
  std::size_t k = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    while (k >= 2 && cross(hull[k - 2], hull[k - 1], points[i]) <= 0.0) --k;
    hull[k++] = points[i];
  }
  const std::size_t lower = k + 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) {
    while (k >= lower && cross(hull[k - 2], hull[k - 1], points[i]) <= 0.0) --k;
    hull[k++] = points[i];
  }
  hull.resize(k - 1);
  return hull;
}

void add_ring(Polygon& out, const Pose& X_WS, double radius, double z) {
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners;
    const Vec3 p = X_WS * Vec3(radius * std::cos(angle), radius * std::sin(angle), z);
    out.emplace_back(p.x(), p.y());
  }
}

// A ball's shadow is a circle however it is turned.
void add_ball(Polygon& out, const Vec3& centre, double radius) {
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners;
    out.emplace_back(centre.x() + radius * std::cos(angle), centre.y() + radius * std::sin(angle));
  }
}

}  // namespace

std::vector<Polygon> plan_outline(const SceneModel& model, const Shape& shape, const Pose& X_WB) {
  const Pose X_WS = X_WB * shape.X_BS;
  Polygon points;
  switch (shape.type) {
    case ShapeType::plane:
      return {};
    case ShapeType::box:
      for (int i = 0; i < 8; ++i) {
        const Vec3 corner(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
        const Vec3 p = X_WS * Vec3(corner.cwiseProduct(shape.size));
        points.emplace_back(p.x(), p.y());
      }
      break;
    case ShapeType::sphere:
      add_ball(points, X_WS.p, shape.radius);
      break;
    case ShapeType::cylinder:
      add_ring(points, X_WS, shape.radius, -0.5 * shape.length);
      add_ring(points, X_WS, shape.radius, 0.5 * shape.length);
      break;
    case ShapeType::capsule:
      add_ball(points, X_WS * Vec3(0, 0, -0.5 * shape.length), shape.radius);
      add_ball(points, X_WS * Vec3(0, 0, 0.5 * shape.length), shape.radius);
      break;
    case ShapeType::convex_mesh:
      for (const Vec3& v : model.meshes[static_cast<std::size_t>(shape.mesh)].vertices) {
        const Vec3 p = X_WS * v;
        points.emplace_back(p.x(), p.y());
      }
      break;
    case ShapeType::mesh: {
      const TriangleMesh& mesh = model.meshes[static_cast<std::size_t>(shape.mesh)];
      std::vector<Polygon> triangles;
      triangles.reserve(mesh.triangles.size());
      for (const Eigen::Vector3i& t : mesh.triangles) {
        Polygon triangle;
        for (int k = 0; k < 3; ++k) {
          const Vec3 p = X_WS * mesh.vertices[static_cast<std::size_t>(t[k])];
          triangle.emplace_back(p.x(), p.y());
        }
        // All turn the same way, so that a non-zero fill is their union; edge-on ones add nothing.
        const double area = cross(triangle[0], triangle[1], triangle[2]);
        if (area == 0.0) continue;
        if (area < 0.0) std::swap(triangle[1], triangle[2]);
        triangles.push_back(std::move(triangle));
      }
      return triangles;
    }
    case ShapeType::heightmap: {
      const HeightGrid& grid = model.heightmaps[static_cast<std::size_t>(shape.heightmap)];
      const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());
      for (int i = 0; i < 8; ++i) {
        const Vec3 p =
            X_WS * Vec3(i & 1 ? 0.5 * grid.size_x : -0.5 * grid.size_x,
                        i & 2 ? 0.5 * grid.size_y : -0.5 * grid.size_y, i & 4 ? *high : *low);
        points.emplace_back(p.x(), p.y());
      }
      break;
    }
  }
  return {convex_hull(std::move(points))};
}

}  // namespace cogrsim
