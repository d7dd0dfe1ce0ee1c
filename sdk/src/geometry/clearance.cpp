#include "geometry/clearance.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/triangles.h"
#include "geometry/gjk.h"
#include "geometry/inside_shape.h"

namespace cogrsim::geometry {

namespace {

// Less than the rounding of positions in a scene some hundred metres wide [m].
constexpr double kTouching = 1e-9;  // [m]

bool has_inside(const PlacedShape& placed) {
  const ShapeType type = placed.shape->type;
  return type != ShapeType::plane && type != ShapeType::mesh && type != ShapeType::heightmap;
}

// Outermost point of the core of a convex shape along d, in the world. `d` is not 0.
Vec3 outermost(const PlacedShape& placed, const Vec3& d) {
  Vec3 out = Placed{placed.core, placed.X_WS}.support(d);
  const double level = std::hypot(d.x(), d.y());
  if (placed.grown > 0.0 && level > 0.0) {
    out += placed.grown / level * Vec3(d.x(), d.y(), 0.0);
  }
  return out;
}

Vec3 outermost(const Triangle& triangle, const Vec3& d) {
  return core_of(triangle.data()).support(d);
}

double margin_of(const PlacedShape& placed) { return placed.core.margin; }
double margin_of(const Triangle&) { return 0.0; }

// Whether two convex sets touch: their cores are no further apart than what is around these.
template <class A, class B>
bool convex_meet(const A& a, const B& b, const Vec3& towards) {
  const auto difference = [&](const Vec3& d) -> Vec3 { return outermost(a, d) - outermost(b, -d); };
  const Vec3 d = towards.squaredNorm() > 0.0 ? towards : Vec3(1, 0, 0);
  return nearest_to_origin(difference, difference(d)).norm() - margin_of(a) - margin_of(b) <=
         kTouching;
}

bool meets_plane(const PlacedShape& plane, const PlacedShape& other) {
  const Vec3 up = plane.X_WS.q * Vec3::UnitZ();
  return (outermost(other, -up) - plane.X_WS.p).dot(up) - margin_of(other) <= 0.0;
}

// What has no inside against what has one.
bool meets_triangles(const PlacedShape& surface, const PlacedShape& other) {
  const Vec3 middle = other.bounds.middle();
  bool found = false;
  for_triangles(*surface.model, *surface.shape, all_bounds(), [&](const Triangle& t) {
    if (found) return;
    const Triangle triangle = {surface.X_WS * t[0], surface.X_WS * t[1], surface.X_WS * t[2]};
    found = !bounds_of(triangle).disjoint(other.bounds) &&
            convex_meet(other, triangle, triangle[0] - middle);
  });
  if (surface.shape->type != ShapeType::heightmap || found) return found;
  // A heightmap is solid below its surface: a shape whose centre is inside overlaps it.
  return inside_shape(*surface.model, *surface.shape, surface.X_WS.inverse() * middle, 0.0);
}

// Whether two shapes touch or overlap. Exact for everything convex (gjk.h) and for planes; meshes
// and heightmaps count as their triangles, a heightmap also with all that is below it. Two of those
// that have no inside never do.
bool meet(const PlacedShape& a, const PlacedShape& b) {
  const bool solid_a = has_inside(a), solid_b = has_inside(b);
  if (a.bounds.disjoint(b.bounds) || !(solid_a || solid_b)) return false;
  if (solid_a && solid_b) return convex_meet(a, b, b.X_WS.p - a.X_WS.p);
  const PlacedShape& ground = solid_a ? b : a;
  const PlacedShape& solid = solid_a ? a : b;
  return ground.shape->type == ShapeType::plane ? meets_plane(ground, solid)
                                                : meets_triangles(ground, solid);
}

PlacedShape placed(const SceneModel& model, int body, const Shape& shape, const Pose& X_WB,
                   double grown) {
  PlacedShape out{&model, &shape, {}, X_WB * shape.X_BS, body, grown, all_bounds()};
  if (shape.type == ShapeType::plane) return out;
  out.bounds = carried(local_bounds(model, shape), out.X_WS);
  if (shape.type == ShapeType::heightmap) out.bounds.low.setConstant(-kInfinity);
  if (!has_inside(out)) return out;
  out.core = core_of(model, shape);
  out.bounds.low -= Vec3(grown, grown, 0.0);
  out.bounds.high += Vec3(grown, grown, 0.0);
  return out;
}

}  // namespace

Clearance::Clearance(const SceneModel& model, const std::vector<Pose>& X_WB) : model_(model) {
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    if (model.bodies[i].removed) continue;
    for (const Shape& shape : model.bodies[i].shapes)
      if (shape.collides)
        shapes_.push_back(placed(model, static_cast<int>(i), shape, X_WB[i], 0.0));
  }
}

std::string Clearance::in_the_way(const SceneModel& fragment, const Pose& pose,
                                  double clearance) const {
  for (std::size_t i = 0; i < fragment.bodies.size(); ++i) {
    const Body& body = fragment.bodies[i];
    for (const Shape& shape : body.shapes) {
      if (!shape.collides) continue;
      Pose X_WB = pose * body.X_WB;
      X_WB.p.z() += kSunk;
      const PlacedShape newcomer = placed(fragment, static_cast<int>(i), shape, X_WB, clearance);
      for (const PlacedShape& other : shapes_) {
        if (meet(newcomer, other)) return model_.bodies[other.body].name;
      }
    }
  }
  return {};
}

}  // namespace cogrsim::geometry
