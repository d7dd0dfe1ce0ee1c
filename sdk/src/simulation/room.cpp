#include "simulation/room.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "signals/gjk.h"

namespace cogrsim {

namespace {

// Nearer than rounding in a scene some hundred metres wide lets one tell.
constexpr double kTouching = 1e-9;  // [m]

bool has_inside(const Shape& shape) {
  return shape.type != ShapeType::mesh && shape.type != ShapeType::heightmap;
}

// Radius around the core of a convex shape: curved all over, it is far easier to measure without.
double margin_of(const Shape& shape) {
  return shape.type == ShapeType::sphere || shape.type == ShapeType::capsule ? shape.radius : 0.0;
}

// Outermost point of the core of a convex shape along d, in the shape's frame.
Vec3 outermost(const SceneModel& model, const Shape& shape, const Vec3& d) {
  const double radial = std::hypot(d.x(), d.y());
  const Vec3 rim = radial > 0.0 ? Vec3(d.x() / radial, d.y() / radial, 0.0) : Vec3::Zero();
  const double end = d.z() >= 0.0 ? 0.5 * shape.length : -0.5 * shape.length;
  switch (shape.type) {
    case ShapeType::box:
      return 0.5 * Vec3(std::copysign(shape.size.x(), d.x()), std::copysign(shape.size.y(), d.y()),
                        std::copysign(shape.size.z(), d.z()));
    case ShapeType::sphere:
      return Vec3::Zero();
    case ShapeType::cylinder:
      return shape.radius * rim + Vec3(0, 0, end);
    case ShapeType::capsule:
      return Vec3(0, 0, end);
    default:
      break;
  }
  const std::vector<Vec3>& vertices = model.meshes[static_cast<std::size_t>(shape.mesh)].vertices;
  const Vec3* best = &vertices.front();
  for (const Vec3& vertex : vertices) {
    if (vertex.dot(d) > best->dot(d)) best = &vertex;
  }
  return *best;
}

// The same of a placed one, in the world. `d` is not 0.
Vec3 outermost(const PlacedShape& placed, const Vec3& d) {
  Vec3 out = placed.X_WS * outermost(*placed.model, *placed.shape, placed.X_WS.q.conjugate() * d);
  const double level = std::hypot(d.x(), d.y());
  if (placed.grown > 0.0 && level > 0.0) {
    out += placed.grown / level * Vec3(d.x(), d.y(), 0.0);
  }
  return out;
}

struct Triangle {
  std::array<Vec3, 3> corners;
};

Vec3 outermost(const Triangle& triangle, const Vec3& d) {
  const auto& c = triangle.corners;
  return *std::max_element(c.begin(), c.end(),
                           [&](const Vec3& a, const Vec3& b) { return a.dot(d) < b.dot(d); });
}

double margin_of(const PlacedShape& placed) { return margin_of(*placed.shape); }
double margin_of(const Triangle&) { return 0.0; }

// Distance between two convex sets: of their cores, less what is around these.
template <class A, class B>
double convex_distance(const A& a, const B& b, const Vec3& towards) {
  const auto difference = [&](const Vec3& d) -> Vec3 { return outermost(a, d) - outermost(b, -d); };
  const Vec3 d = towards.squaredNorm() > 0.0 ? towards : Vec3(1, 0, 0);
  const double apart =
      gjk::origin_distance(difference, difference(d)) - margin_of(a) - margin_of(b);
  return apart <= kTouching ? 0.0 : apart;
}

double plane_distance(const PlacedShape& plane, const PlacedShape& other) {
  const Vec3 up = plane.X_WS.q * Vec3::UnitZ();
  const auto height = [&](const Vec3& point) { return (point - plane.X_WS.p).dot(up); };
  if (has_inside(*other.shape)) {
    return std::max(0.0, height(outermost(other, -up)) - margin_of(other));
  }
  return kInfinity;
}

bool apart(const PlacedShape& a, const Vec3& low, const Vec3& high, double enough) {
  return ((low.array() > a.high.array() + enough) || (high.array() < a.low.array() - enough)).any();
}

template <class Use>
void for_triangles(const PlacedShape& placed, const Vec3& low, const Vec3& high, const Use& use) {
  const auto give = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    const Triangle triangle{{placed.X_WS * a, placed.X_WS * b, placed.X_WS * c}};
    const auto& [p, q, r] = triangle.corners;
    const Vec3 least = p.cwiseMin(q).cwiseMin(r), most = p.cwiseMax(q).cwiseMax(r);
    if (((least.array() > high.array()) || (most.array() < low.array())).any()) return;
    use(triangle);
  };
  if (placed.shape->type == ShapeType::mesh) {
    const TriangleMesh& mesh = placed.model->meshes[static_cast<std::size_t>(placed.shape->mesh)];
    const auto vertex = [&](int i) { return mesh.vertices[static_cast<std::size_t>(i)]; };
    for (const Eigen::Vector3i& t : mesh.triangles) give(vertex(t[0]), vertex(t[1]), vertex(t[2]));
    return;
  }
  const HeightGrid& grid =
      placed.model->heightmaps[static_cast<std::size_t>(placed.shape->heightmap)];
  const auto point = [&](int row, int column) {
    return Vec3(grid.size_x * (double(column) / (grid.columns - 1) - 0.5),
                grid.size_y * (double(row) / (grid.rows - 1) - 0.5),
                grid.heights[static_cast<std::size_t>(row * grid.columns + column)]);
  };
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const Vec3 a = point(row, column), b = point(row, column + 1);
      const Vec3 c = point(row + 1, column + 1), e = point(row + 1, column);
      give(a, b, c);
      give(a, c, e);
    }
  }
}

// What has no inside against what has one.
double surface_distance(const PlacedShape& surface, const PlacedShape& other, double enough) {
  const Vec3 margin = Vec3::Constant(enough);
  double best = kInfinity;
  const Vec3 middle = 0.5 * (other.low + other.high);
  for_triangles(surface, other.low - margin, other.high + margin, [&](const Triangle& triangle) {
    best = std::min(best, convex_distance(other, triangle, triangle.corners[0] - middle));
  });
  if (surface.shape->type != ShapeType::heightmap || best == 0.0) return best;
  // Ground is full below: a triangle above the middle of the other means that it is buried.
  const Vec3 far(0, 0, 1e4);
  for_triangles(surface, middle, middle + far, [&](const Triangle& triangle) {
    const auto& [a, b, c] = triangle.corners;
    const Eigen::Vector2d p = middle.head<2>(), u = (b - a).head<2>(), v = (c - a).head<2>();
    const double det = u.x() * v.y() - u.y() * v.x();
    if (det == 0.0) return;
    const Eigen::Vector2d r = p - a.head<2>();
    const double s = (r.x() * v.y() - r.y() * v.x()) / det;
    const double t = (u.x() * r.y() - u.y() * r.x()) / det;
    if (s < 0.0 || t < 0.0 || s + t > 1.0) return;
    if (a.z() + s * (b - a).z() + t * (c - a).z() >= middle.z()) best = 0.0;
  });
  return best;
}

PlacedShape placed(const SceneModel& model, int body, const Shape& shape, const Pose& X_WB,
                   double grown) {
  PlacedShape out{&model, &shape, X_WB * shape.X_BS, body, grown};
  out.low.setConstant(-kInfinity);
  out.high.setConstant(kInfinity);
  if (shape.type == ShapeType::plane) return out;
  if (has_inside(shape)) {
    for (int i = 0; i < 3; ++i) {
      out.high[i] = outermost(out, Vec3::Unit(i))[i] + margin_of(shape);
      out.low[i] = outermost(out, -Vec3::Unit(i))[i] - margin_of(shape);
    }
    return out;
  }
  out.low.setConstant(kInfinity);
  out.high.setConstant(-kInfinity);
  const Vec3 all = Vec3::Constant(kInfinity);
  for_triangles(out, -all, all, [&](const Triangle& triangle) {
    for (const Vec3& corner : triangle.corners) {
      out.low = out.low.cwiseMin(corner);
      out.high = out.high.cwiseMax(corner);
    }
  });
  if (shape.type == ShapeType::heightmap) out.low.setConstant(-kInfinity);
  return out;
}

std::vector<PlacedShape> shapes_of(const SceneModel& model, const WorldState& state, int index) {
  std::vector<PlacedShape> out;
  const Body& body = model.bodies[static_cast<std::size_t>(index)];
  for (const Shape& shape : body.shapes) {
    if (!shape.collides) continue;
    out.push_back(placed(model, index, shape, state.poses[static_cast<std::size_t>(index)], 0));
  }
  return out;
}

}  // namespace

double shape_distance(const PlacedShape& a, const PlacedShape& b, double enough) {
  if (apart(a, b.low, b.high, enough)) return kInfinity;
  if (a.shape->type == ShapeType::plane) {
    return b.shape->type == ShapeType::plane ? kInfinity : plane_distance(a, b);
  }
  if (b.shape->type == ShapeType::plane) return plane_distance(b, a);
  if (!has_inside(*a.shape)) {
    return has_inside(*b.shape) ? surface_distance(a, b, enough) : kInfinity;
  }
  if (!has_inside(*b.shape)) return surface_distance(b, a, enough);
  return convex_distance(a, b, b.X_WS.p - a.X_WS.p);
}

double body_distance(const SceneModel& model, const WorldState& state, int a, int b) {
  double best = kInfinity;
  for (const PlacedShape& one : shapes_of(model, state, a)) {
    for (const PlacedShape& other : shapes_of(model, state, b)) {
      best = std::min(best, shape_distance(one, other, kInfinity));
    }
  }
  return best;
}

Room::Room(const SceneModel& model, const WorldState& state) : model_(model) {
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    if (model.bodies[i].removed) continue;
    for (PlacedShape& shape : shapes_of(model, state, static_cast<int>(i))) {
      shapes_.push_back(shape);
    }
  }
}

std::string Room::in_the_way(const SceneModel& fragment, const Pose& pose, double clearance) const {
  for (std::size_t i = 0; i < fragment.bodies.size(); ++i) {
    const Body& body = fragment.bodies[i];
    for (const Shape& shape : body.shapes) {
      if (!shape.collides) continue;
      Pose X_WB = pose * body.X_WB;
      X_WB.p.z() += kSunk;
      const PlacedShape newcomer = placed(fragment, static_cast<int>(i), shape, X_WB, clearance);
      for (const PlacedShape& other : shapes_) {
        if (shape_distance(newcomer, other, 0.0) > 0.0) continue;
        return model_.bodies[static_cast<std::size_t>(other.body)].name;
      }
    }
  }
  return {};
}

}  // namespace cogrsim
