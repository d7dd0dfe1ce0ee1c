#include "simulation/room.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "geometry/gjk.h"
#include "geometry/triangles.h"

namespace cogrsim {

namespace {

// Nearer than rounding in a scene some hundred metres wide lets one tell.
constexpr double kTouching = 1e-9;  // [m]

bool has_inside(const Shape& shape) {
  return shape.type != ShapeType::mesh && shape.type != ShapeType::heightmap;
}

// Outermost point of the core of a convex shape along d, in the world. `d` is not 0.
Vec3 outermost(const PlacedShape& placed, const Vec3& d) {
  Vec3 out = geometry::Placed{placed.core, placed.X_WS}.support(d);
  const double level = std::hypot(d.x(), d.y());
  if (placed.grown > 0.0 && level > 0.0) {
    out += placed.grown / level * Vec3(d.x(), d.y(), 0.0);
  }
  return out;
}

Vec3 outermost(const geometry::Triangle& triangle, const Vec3& d) {
  return geometry::core_of(triangle.data()).support(d);
}

double margin_of(const PlacedShape& placed) { return placed.core.margin; }
double margin_of(const geometry::Triangle&) { return 0.0; }

// Distance between two convex sets: of their cores, less what is around these.
template <class A, class B>
double convex_distance(const A& a, const B& b, const Vec3& towards) {
  const auto difference = [&](const Vec3& d) -> Vec3 { return outermost(a, d) - outermost(b, -d); };
  const Vec3 d = towards.squaredNorm() > 0.0 ? towards : Vec3(1, 0, 0);
  const double apart =
      gjk::nearest_to_origin(difference, difference(d)).norm() - margin_of(a) - margin_of(b);
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

// The triangles of a mesh or heightmap that meet `where`, all in the world.
template <class Use>
void for_triangles(const PlacedShape& placed, const geometry::Bounds& where, const Use& use) {
  geometry::for_triangles(*placed.model, *placed.shape, geometry::all_bounds(),
                          [&](const geometry::Triangle& t) {
                            const geometry::Triangle triangle = {
                                placed.X_WS * t[0], placed.X_WS * t[1], placed.X_WS * t[2]};
                            if (!geometry::bounds_of(triangle).apart(where)) use(triangle);
                          });
}

// What has no inside against what has one.
double surface_distance(const PlacedShape& surface, const PlacedShape& other, double enough) {
  const Vec3 margin = Vec3::Constant(enough);
  double best = kInfinity;
  const Vec3 middle = 0.5 * (other.bounds.low + other.bounds.high);
  for_triangles(surface, {other.bounds.low - margin, other.bounds.high + margin},
                [&](const geometry::Triangle& triangle) {
                  best = std::min(best, convex_distance(other, triangle, triangle[0] - middle));
                });
  if (surface.shape->type != ShapeType::heightmap || best == 0.0) return best;
  // Ground is full below: where the middle of the other is in it, that is buried.
  const Vec3 p = surface.X_WS.inverse() * middle;
  const HeightGrid& grid =
      surface.model->heightmaps[static_cast<std::size_t>(surface.shape->heightmap)];
  return p.z() <= geometry::ground_height(grid, p.x(), p.y()) ? 0.0 : best;
}

PlacedShape placed(const SceneModel& model, int body, const Shape& shape, const Pose& X_WB,
                   double grown) {
  PlacedShape out{&model, &shape, {}, X_WB * shape.X_BS, body, grown, geometry::all_bounds()};
  if (shape.type == ShapeType::plane) return out;
  if (has_inside(shape)) {
    out.core = geometry::core_of(model, shape);
    out.bounds = out.core.bounds(out.X_WS);
    const Vec3 level(grown, grown, 0.0);
    out.bounds.low -= level;
    out.bounds.high += level;
    return out;
  }
  out.bounds = {};
  for_triangles(out, geometry::all_bounds(), [&](const geometry::Triangle& triangle) {
    out.bounds.add(geometry::bounds_of(triangle));
  });
  if (shape.type == ShapeType::heightmap) out.bounds.low.setConstant(-kInfinity);
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
  if (a.bounds.apart(b.bounds, enough)) return kInfinity;
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
