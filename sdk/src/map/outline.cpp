// Outlines of shapes seen from above.
#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/convex.h"
#include "cogrsim/geometry/convex_hull.h"
#include "cogrsim/map/map.h"

namespace cogrsim {

namespace {

using Point = Eigen::Vector2d;
using Polygon = std::vector<Point>;

// A polygon with n corners deviates from its circle by 1 - cos(pi / n) of the radius: 4.8e-4 here.
constexpr int kCorners = 102;

double cross(const Point& o, const Point& a, const Point& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

void add_ring(Polygon& out, const Pose& X_WS, double radius, double z) {
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners;
    const Vec3 p = X_WS * Vec3(radius * std::cos(angle), radius * std::sin(angle), z);
    out.emplace_back(p.x(), p.y());
  }
}

// The projection of a sphere is a circle for every orientation.
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
    case ShapeType::heightmap: {
      const geometry::Bounds box = geometry::local_bounds(model, shape);
      for (int i = 0; i < 8; ++i) points.emplace_back((X_WS * box.corner(i)).head<2>());
      break;
    }
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
      for (const Vec3& v : model.meshes[shape.mesh]->vertices)
        points.emplace_back((X_WS * v).head<2>());
      break;
    case ShapeType::mesh: {
      const TriangleMesh& mesh = *model.meshes[shape.mesh];
      std::vector<Polygon> triangles;
      triangles.reserve(mesh.triangles.size());
      for (const Eigen::Vector3i& t : mesh.triangles) {
        Polygon triangle;
        for (int k = 0; k < 3; ++k) {
          const Vec3 p = X_WS * mesh.vertices[t[k]];
          triangle.emplace_back(p.x(), p.y());
        }
        // All have the same orientation, so that a non-zero fill is their union; edge-on ones add
        // nothing.
        const double area = cross(triangle[0], triangle[1], triangle[2]);
        if (area == 0.0) continue;
        if (area < 0.0) std::swap(triangle[1], triangle[2]);
        triangles.push_back(std::move(triangle));
      }
      return triangles;
    }
  }
  return {geometry::convex_hull(std::move(points))};
}

}  // namespace cogrsim
