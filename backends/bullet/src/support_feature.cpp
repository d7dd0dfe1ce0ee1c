#include "support_feature.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "convert.h"
#include "shape_factory.h"

namespace cogrsim::bullet {

namespace {

constexpr int kCapCorners = 16;
// A cylinder's end is what it touches with where it looks along its axis more than this (cosine).
constexpr double kCapCosine = 0.7;
// Leaning less than this, a standing cylinder's corners stay with the cylinder [rad]: the
// direction of its lean is noise then, and the polygon's error, (1 - cos(pi / 16)) R 3e-3, is about
// what resting bodies sink in.
constexpr double kUpright = 3e-3;

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

/// The face, by its number, that looks most along d.
std::size_t most_along(const HullFaces& faces, const btVector3& d) {
  const Vec3 direction = from_bt(d);
  std::size_t best = 0;
  double most = -2.0;
  for (std::size_t f = 0; f < faces.normals.size(); ++f) {
    const double along = faces.normals[f].dot(direction);
    if (along > most) {
      most = along;
      best = f;
    }
  }
  return best;
}

}  // namespace

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
      if (const HullFaces& faces = collision.faces; !faces.normals.empty()) {
        const std::size_t face = most_along(faces, d);
        out.kind = SupportFeature::Kind::face;
        out.normal = X_WS.getBasis() * to_bt(faces.normals[face]);
        for (const int v : faces.corners[face])
          out.points[out.count++] = X_WS * to_bt(faces.vertices[static_cast<std::size_t>(v)]);
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
      if (collision.faces.normals.empty()) return false;
      normal = R * to_bt(collision.faces.normals[most_along(collision.faces, d)]);
      return true;
    default:
      return false;
  }
}

}  // namespace cogrsim::bullet
