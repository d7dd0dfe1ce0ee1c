#include "support_feature.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <LinearMath/btConvexHullComputer.h>

#include "shape_factory.h"

namespace cogrsim::bullet {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kCapCorners = 16;
// A cylinder's end is what it touches with where it looks along its axis more than this (cosine).
constexpr double kCapCosine = 0.7;
// Leaning less than this, a standing cylinder's corners stay with the cylinder [rad]: the
// direction of its lean is noise then, and the polygon's error, (1 - cos(pi / 16)) R 3e-3, is about
// what resting bodies sink in.
constexpr double kUpright = 3e-3;

btVector3 centre_of(const std::vector<btVector3>& points) {
  btVector3 sum(0, 0, 0);
  for (const btVector3& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

/// All of `vertices` in the plane, counter-clockwise about its normal.
std::vector<btVector3> corners_in_plane(const btAlignedObjectArray<btVector3>& vertices,
                                        const btVector3& normal, double height, double slack) {
  std::vector<btVector3> corners;
  for (int i = 0; i < vertices.size(); ++i) {
    if (std::abs(normal.dot(vertices[i]) - height) < slack) corners.push_back(vertices[i]);
  }
  const btVector3 centre = centre_of(corners);
  btVector3 x, y;
  btPlaneSpace1(normal, x, y);
  const auto angle = [&](const btVector3& p) {
    return std::atan2(y.dot(p - centre), x.dot(p - centre));
  };
  std::sort(corners.begin(), corners.end(),
            [&](const btVector3& a, const btVector3& b) { return angle(a) < angle(b); });
  return corners;
}

void box_face(const Shape& shape, const btTransform& X_WS, const btVector3& d,
              SupportFeature& out) {
  const btMatrix3x3& R = X_WS.getBasis();
  const int axis = d.absolute().maxAxis();
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const double side = d[axis] > 0.0 ? 1.0 : -1.0;
  out.kind = SupportFeature::Kind::face;
  out.normal = R.getColumn(axis) * side;
  const btVector3 middle = X_WS.getOrigin() + out.normal * (0.5 * shape.size[axis]);
  const btVector3 du = R.getColumn(u) * (0.5 * shape.size[u]);
  const btVector3 dv = R.getColumn(v) * (0.5 * side * shape.size[v]);  // turns the other way below
  out.count = 4;
  out.points[0] = middle - du - dv;
  out.points[1] = middle + du - dv;
  out.points[2] = middle + du + dv;
  out.points[3] = middle - du + dv;
}

void cap(const Shape& shape, const btTransform& X_WS, const btVector3& d, SupportFeature& out) {
  const btMatrix3x3& R = X_WS.getBasis();
  const double side = d.z() > 0.0 ? 1.0 : -1.0;
  out.kind = SupportFeature::Kind::face;
  out.normal = R.getColumn(2) * side;
  const btVector3 middle = X_WS.getOrigin() + out.normal * (0.5 * shape.length);
  const double across = std::hypot(d.x(), d.y());
  const bool leans = across > kUpright;
  const btVector3 x =
      R * btVector3(leans ? d.x() / across : 1.0, leans ? d.y() / across : 0.0, 0.0);
  const btVector3 y = out.normal.cross(x);
  static const auto circle = [] {
    std::array<std::array<double, 2>, kCapCorners> table;
    for (int i = 0; i < kCapCorners; ++i) {
      const double angle = 2.0 * kPi * i / kCapCorners;
      table[static_cast<std::size_t>(i)] = {std::cos(angle), std::sin(angle)};
    }
    return table;
  }();
  out.count = kCapCorners;
  for (int i = 0; i < kCapCorners; ++i) {
    const auto& c = circle[static_cast<std::size_t>(i)];
    out.points[i] = middle + x * (shape.radius * c[0]) + y * (shape.radius * c[1]);
  }
}

void side_line(const Shape& shape, const btTransform& X_WS, SupportFeature& out) {
  const btVector3 half = X_WS.getBasis().getColumn(2) * (0.5 * shape.length);
  out.kind = SupportFeature::Kind::line;
  out.count = 2;
  out.points[0] = X_WS.getOrigin() - half;
  out.points[1] = X_WS.getOrigin() + half;
  out.radius = shape.radius;
}

const HullFace* most_along(const std::vector<HullFace>& faces, const btVector3& d) {
  const HullFace* best = nullptr;
  double most = -2.0;
  for (const HullFace& face : faces) {
    const double along = face.normal.dot(d);
    if (along > most) {
      most = along;
      best = &face;
    }
  }
  return best;
}

}  // namespace

std::vector<HullFace> hull_faces(const std::vector<double>& corners) {
  btConvexHullComputer hull;
  hull.compute(corners.data(), 3 * sizeof(double), static_cast<int>(corners.size() / 3), 0.0, 0.0);
  double size = 0.0;
  btVector3 inside(0, 0, 0);
  for (int i = 0; i < hull.vertices.size(); ++i) {
    inside += hull.vertices[i] / hull.vertices.size();
    size = std::max(size, hull.vertices[i].length());
  }
  std::vector<HullFace> out;
  for (int f = 0; f < hull.faces.size(); ++f) {
    // Newell's normal of the face's loop, about a point of it for the sake of precision.
    const btConvexHullComputer::Edge* const first = &hull.edges[hull.faces[f]];
    const btVector3 origin = hull.vertices[first->getSourceVertex()];
    btVector3 normal(0, 0, 0);
    const btConvexHullComputer::Edge* edge = first;
    do {
      normal += (hull.vertices[edge->getSourceVertex()] - origin)
                    .cross(hull.vertices[edge->getTargetVertex()] - origin);
      edge = edge->getNextEdgeOfFace();
    } while (edge != first);
    const double length = normal.length();
    if (length < 1e-14 * size * size) continue;
    normal /= length;
    if (normal.dot(origin - inside) < 0.0) normal = -normal;
    const bool known = std::any_of(out.begin(), out.end(), [&](const HullFace& face) {
      return face.normal.dot(normal) > 1.0 - 1e-9;
    });
    if (known) continue;
    HullFace face;
    face.normal = normal;
    face.corners = corners_in_plane(hull.vertices, normal, normal.dot(origin), 1e-7 * size);
    if (face.corners.size() < 3) continue;
    const std::size_t most = SupportFeature::kMost;
    if (face.corners.size() > most) {
      std::vector<btVector3> some;
      for (std::size_t i = 0; i < most; ++i)
        some.push_back(face.corners[i * face.corners.size() / most]);
      face.corners = std::move(some);
    }
    out.push_back(std::move(face));
  }
  return out;
}

void find_support_feature(const Shape& shape, const CollisionShape& collision,
                          const btTransform& X_WS, const btVector3& direction,
                          SupportFeature& out) {
  out.kind = SupportFeature::Kind::none;
  out.count = 0;
  out.tread = false;
  const btVector3 d = direction * X_WS.getBasis();  // in the shape's axes
  switch (shape.type) {
    case ShapeType::box:
      box_face(shape, X_WS, d, out);
      break;
    case ShapeType::cylinder:
      if (std::abs(d.z()) > kCapCosine) {
        cap(shape, X_WS, d, out);
      } else {
        side_line(shape, X_WS, out);
        out.tread = true;
      }
      break;
    case ShapeType::capsule:
      side_line(shape, X_WS, out);
      break;
    case ShapeType::convex_mesh:
      if (const HullFace* face = most_along(collision.faces, d)) {
        out.kind = SupportFeature::Kind::face;
        out.normal = X_WS.getBasis() * face->normal;
        for (const btVector3& p : face->corners) out.points[out.count++] = X_WS * p;
      }
      break;
    default:
      break;
  }
}

bool nearest_face_normal(const Shape& shape, const CollisionShape& collision,
                         const btTransform& X_WS, const btVector3& direction, btVector3& normal) {
  const btMatrix3x3& R = X_WS.getBasis();
  const btVector3 d = direction * R;
  switch (shape.type) {
    case ShapeType::box: {
      const int axis = d.absolute().maxAxis();
      normal = d[axis] > 0.0 ? R.getColumn(axis) : -R.getColumn(axis);
      return true;
    }
    case ShapeType::cylinder:
      normal = d.z() > 0.0 ? R.getColumn(2) : -R.getColumn(2);
      return true;
    case ShapeType::convex_mesh:
      if (const HullFace* face = most_along(collision.faces, d)) {
        normal = R * face->normal;
        return true;
      }
      return false;
    default:
      return false;
  }
}

}  // namespace cogrsim::bullet
