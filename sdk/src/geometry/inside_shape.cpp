#include "geometry/inside_shape.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/triangles.h"

namespace cogrsim::geometry {

namespace {

/// Winding number of a closed surface about p: the sum of the triangles' solid angles over 4 pi, 1
/// inside and 0 outside. Solid angle of a triangle with corners a, b, c seen from p (Van Oosterom
/// and Strackee 1983, eq. 8): tan(w/2) = a.(b x c) / (|a||b||c| + (a.b)|c| + (a.c)|b| + (b.c)|a|).
double winding_number(const TriangleMesh& mesh, const Vec3& p) {
  double sum = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - p;
    const Vec3 b = mesh.vertices[t[1]] - p;
    const Vec3 c = mesh.vertices[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2.0 * std::atan2(a.dot(b.cross(c)),
                            la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la);
  }
  return sum / (4.0 * kPi);
}

}  // namespace

bool inside_shape(const SceneModel& model, const Shape& shape, const Vec3& p, double margin) {
  switch (shape.type) {
    case ShapeType::box:
      return (p.cwiseAbs() - 0.5 * shape.size).maxCoeff() < -margin;
    case ShapeType::sphere:
      return p.norm() < shape.radius - margin;
    case ShapeType::cylinder:
      return std::hypot(p.x(), p.y()) < shape.radius - margin &&
             std::abs(p.z()) < 0.5 * shape.length - margin;
    case ShapeType::capsule: {
      const double z = std::clamp(p.z(), -0.5 * shape.length, 0.5 * shape.length);
      return (p - Vec3(0, 0, z)).norm() < shape.radius - margin;
    }
    case ShapeType::plane:
      return p.z() < -margin;
    case ShapeType::convex_mesh:
    case ShapeType::mesh:
      return winding_number(*model.meshes[shape.mesh], p) > 0.5;
    case ShapeType::heightmap:
      return p.z() < ground_height(*model.heightmaps[shape.heightmap], p.x(), p.y()) - margin;
  }
  return false;
}

}  // namespace cogrsim::geometry
