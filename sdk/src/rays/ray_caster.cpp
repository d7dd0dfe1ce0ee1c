#include "cogrsim/rays/ray_caster.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "cogrsim/geometry/convex.h"
#include "cogrsim/geometry/convex_hull.h"
#include "cogrsim/geometry/triangles.h"
#include "geometry/solids.h"
#include "rays/box_tree.h"
#include "rays/triangle_set.h"

namespace cogrsim {
namespace {

using geometry::Bounds;
using rays::BoxTree;
using rays::TriangleSet;

/// What lies further than this from the other things would make everybody's padding large [m].
constexpr double kFar = 1e5;
/// Boxes may stray this much beyond where they were when the tree was built.
constexpr double kSlack = 1.25;

/// A shape in the world: its frame's pose, and a sphere around all of it. What every ray asks comes
/// first, in one cache line.
struct alignas(64) Placed {
  Vec3 middle = Vec3::Zero();  // of the sphere, in the world
  double radius = 0.0;         // radius of the sphere [m]
  int body = -1;
  ShapeType type = ShapeType::box;
  const Shape* shape = nullptr;
  int shape_index = -1;
  enum class Group : char { tree, list, nowhere } group = Group::list;
  unsigned box = 0;  // in the tree
  Mat3 R_WS = Mat3::Identity();
  Vec3 p_WS = Vec3::Zero();
  Vec3 middle_S = Vec3::Zero();                  // of the sphere
  geometry::Core core;                           // of a solid
  std::shared_ptr<const TriangleSet> triangles;  // nullptr: a solid or a plane
};

struct Candidate {
  double distance = std::numeric_limits<double>::infinity();
  const Placed* placed = nullptr;
  int triangle = -1;
  int face = 0;
  bool inside = false;
};

bool same(const Pose& a, const Pose& b) { return a.p == b.p && a.q.coeffs() == b.q.coeffs(); }

bool finite(const Pose& pose) {
  return pose.p.allFinite() && pose.q.coeffs().allFinite() && pose.q.norm() > 0.0;
}

bool is_triangles(ShapeType type) {
  return type == ShapeType::convex_mesh || type == ShapeType::mesh || type == ShapeType::heightmap;
}

bool wanted(const Shape& shape, RayTargets targets) {
  switch (targets) {
    case RayTargets::visible:
      return shape.visible;
    case RayTargets::colliding:
      return shape.collides;
    case RayTargets::any:
      break;
  }
  return shape.visible || shape.collides;
}

/// One ray on its way through the scene.
class Cast final : public rays::BoxVisitor {
 public:
  Cast(const Ray& ray, const Vec3& direction, const std::vector<int>& ignored,
       const std::vector<Placed>& placed, const std::vector<int>& in_tree)
      : origin_(ray.origin),
        direction_(direction),
        from_(std::max(ray.min_distance, 0.0)),
        to_(ray.max_distance),
        ignored_(ignored),
        placed_(placed),
        in_tree_(in_tree) {}

  double visit(unsigned index) override {
    meet(placed_[in_tree_[index]]);
    return limit();
  }

  void meet(const Placed& placed) {
    if (placed.type == ShapeType::plane) {
      if (!is_ignored(placed)) meet_plane(placed);
      return;
    }
    // From the point of the line that is nearest to the shape, so that numbers stay small.
    const Vec3 to_middle = placed.middle - origin_;
    const double nearest = to_middle.dot(direction_);
    const Vec3 start = nearest * direction_ - to_middle;
    if (start.squaredNorm() > placed.radius * placed.radius) return;
    if (nearest + placed.radius < from_ || nearest - placed.radius > limit()) return;
    if (is_ignored(placed)) return;
    const Vec3 o = placed.R_WS.transpose() * start + placed.middle_S;
    const Vec3 d = placed.R_WS.transpose() * direction_;
    if (is_triangles(placed.type)) {
      const TriangleSet::Hit hit =
          placed.triangles->nearest(o, d, from_ - nearest, limit() - nearest);
      if (hit.triangle < 0) return;
      const bool inside = placed.triangles->normal(hit.triangle).dot(d) > 0.0;
      offer({nearest + hit.distance, &placed, hit.triangle, 0, inside});
      return;
    }
    const auto crossing = geometry::cross_solid(*placed.shape, o, d);
    if (!crossing) return;
    if (nearest + crossing->in >= from_) {
      offer({nearest + crossing->in, &placed, -1, crossing->in_face, false});
    } else if (nearest + crossing->out >= from_) {
      offer({nearest + crossing->out, &placed, -1, crossing->out_face, true});
    }
  }

  double from() const { return from_; }
  double limit() const { return std::min(to_, best_.distance); }
  const Candidate& best() const { return best_; }

 private:
  bool is_ignored(const Placed& placed) const {
    return !ignored_.empty() && std::binary_search(ignored_.begin(), ignored_.end(), placed.body);
  }

  // The plane z = 0. A line in the plane does not meet it.
  void meet_plane(const Placed& placed) {
    const Vec3 normal = placed.R_WS.col(2);
    const double slope = normal.dot(direction_);
    if (slope == 0.0) return;
    const double distance = normal.dot(placed.p_WS - origin_) / slope;
    if (distance >= from_) offer({distance, &placed, -1, 0, slope > 0.0});
  }

  // Of equal distances the lower number wins, whatever order they were found in.
  void offer(const Candidate& candidate) {
    if (!(candidate.distance <= to_) || candidate.distance > best_.distance) return;
    if (candidate.distance == best_.distance && best_.placed != nullptr &&
        best_.placed < candidate.placed)
      return;
    best_ = candidate;
  }

  const Vec3& origin_;
  const Vec3& direction_;
  double from_, to_;
  const std::vector<int>& ignored_;
  const std::vector<Placed>& placed_;
  const std::vector<int>& in_tree_;
  Candidate best_;
};

}  // namespace

struct RayCaster::Impl {
  rays::TreeDevice device;
  BoxTree tree{device, true};
  SceneModelPtr model;
  RayTargets targets = RayTargets::visible;
  std::vector<Pose> poses;     // of last time
  std::vector<Placed> placed;  // body by body
  std::vector<int> first;      // of a body in `placed`; nbody + 1
  std::vector<int> in_tree;    // box in the tree -> placed
  std::vector<int> in_list;    // planes, and what is far off
  Vec3 centre = Vec3::Zero();  // what `far off` is measured from
  // By index in the model; nullptr: not needed yet.
  std::vector<std::shared_ptr<const TriangleSet>> meshes, hulls, heightmaps;

  void take_model(const SceneModelPtr& next, RayTargets next_targets);
  void keep_triangles(const SceneModel& next);
  std::shared_ptr<const TriangleSet> triangles(const Shape& shape);
  void set_extent(Placed& out);
  void place(Placed& out, const Pose& X_WB);
  Bounds box_of(const Placed& p) const;
  void build_tree();
};

// Trees over triangles are costly: what did not change keeps them.
void RayCaster::Impl::keep_triangles(const SceneModel& next) {
  const SceneModel empty;
  const SceneModel& last = model ? *model : empty;
  meshes.resize(next.meshes.size());
  hulls.resize(next.meshes.size());
  for (std::size_t i = 0; i < next.meshes.size(); ++i) {
    if (i >= last.meshes.size() || !same_geometry(last.meshes[i], next.meshes[i]))
      meshes[i] = hulls[i] = nullptr;
  }
  heightmaps.resize(next.heightmaps.size());
  for (std::size_t i = 0; i < next.heightmaps.size(); ++i) {
    if (i >= last.heightmaps.size() || !same_geometry(last.heightmaps[i], next.heightmaps[i]))
      heightmaps[i] = nullptr;
  }
}

std::shared_ptr<const TriangleSet> RayCaster::Impl::triangles(const Shape& shape) {
  const auto make = [&](std::shared_ptr<const TriangleSet>& known, const auto& mesh) {
    if (!known) {
      known = std::make_shared<const TriangleSet>(device, mesh());
    }
    return known;
  };
  const auto own = [](TriangleMesh mesh) {
    return std::make_shared<const TriangleMesh>(std::move(mesh));
  };
  if (shape.type == ShapeType::heightmap) {
    const auto i = static_cast<std::size_t>(shape.heightmap);
    return make(heightmaps[i], [&] { return own(geometry::triangles_of(*model->heightmaps[i])); });
  }
  const auto i = static_cast<std::size_t>(shape.mesh);
  if (shape.type == ShapeType::convex_mesh && targets == RayTargets::colliding)
    return make(hulls[i], [&] { return own(geometry::convex_hull(*model->meshes[i])); });
  return make(meshes[i], [&] { return model->meshes[i]; });
}

void RayCaster::Impl::set_extent(Placed& out) {
  const Shape& shape = *out.shape;
  if (shape.type == ShapeType::plane) return;
  if (is_triangles(shape.type)) {
    out.triangles = triangles(shape);
    out.middle_S = out.triangles->box().middle();
    out.radius = out.triangles->box().half().norm();
  } else {
    out.core = geometry::core_of(*model, shape);
    out.radius = geometry::bounding_radius(*model, shape);
  }
  // A margin for the rounding in the test against it.
  out.radius *= 1.0 + 1e-9;
}

void RayCaster::Impl::place(Placed& out, const Pose& X_WB) {
  if (!finite(X_WB)) {
    out.group = Placed::Group::nowhere;
    return;
  }
  const Pose X_WS = Pose(X_WB.p, X_WB.q.normalized()) * out.shape->X_BS;
  out.p_WS = X_WS.p;
  out.R_WS = X_WS.q.normalized().toRotationMatrix();
  out.middle = out.p_WS + out.R_WS * out.middle_S;
  // Rounding of a position far from the origin can be more than that of a small shape.
  const double away = (out.middle - centre).norm() + out.radius;
  const bool listed = out.shape->type == ShapeType::plane || !(away < kFar);
  out.group = listed ? Placed::Group::list : Placed::Group::tree;
}

Bounds RayCaster::Impl::box_of(const Placed& p) const {
  const Vec3 half = p.triangles != nullptr ? Vec3(p.R_WS.cwiseAbs() * p.triangles->box().half())
                                           : p.core.half_extents(p.R_WS);
  return {p.middle - half, p.middle + half};
}

void RayCaster::Impl::take_model(const SceneModelPtr& next, RayTargets next_targets) {
  if (next) keep_triangles(*next);
  const SceneModelPtr last = std::exchange(model, next);
  targets = next_targets;
  placed.clear();
  first.clear();
  poses.clear();
  if (!model) return;
  for (std::size_t b = 0; b < model->bodies.size(); ++b) {
    first.push_back(static_cast<int>(placed.size()));
    const Body& body = model->bodies[b];
    if (body.removed) continue;
    for (std::size_t s = 0; s < body.shapes.size(); ++s) {
      if (!wanted(body.shapes[s], targets)) continue;
      Placed out;
      out.body = static_cast<int>(b);
      out.shape_index = static_cast<int>(s);
      out.shape = &body.shapes[s];
      out.type = out.shape->type;
      set_extent(out);
      placed.push_back(std::move(out));
    }
  }
  first.push_back(static_cast<int>(placed.size()));
}

/// Sorts everything into tree, list and nowhere, and builds the tree.
void RayCaster::Impl::build_tree() {
  // The middle of most things, so that a few that flew away do not count.
  std::vector<double> sorted[3];
  for (const Placed& p : placed) {
    const Pose& X_WB = poses[p.body];
    if (p.shape->type == ShapeType::plane || !finite(X_WB)) continue;
    for (int i = 0; i < 3; ++i) sorted[i].push_back(X_WB.p[i]);
  }
  for (int i = 0; i < 3; ++i) {
    if (sorted[i].empty()) continue;
    const auto middle = sorted[i].begin() + static_cast<std::ptrdiff_t>(sorted[i].size() / 2);
    std::nth_element(sorted[i].begin(), middle, sorted[i].end());
    centre[i] = *middle;
  }
  in_tree.clear();
  in_list.clear();
  std::vector<Bounds> boxes;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    Placed& p = placed[i];
    place(p, poses[p.body]);
    if (p.group == Placed::Group::list) in_list.push_back(static_cast<int>(i));
    if (p.group != Placed::Group::tree) continue;
    p.box = static_cast<unsigned>(boxes.size());
    in_tree.push_back(static_cast<int>(i));
    boxes.push_back(box_of(p));
  }
  tree.build(boxes, kSlack);
}

RayCaster::RayCaster() : impl_(std::make_unique<Impl>()) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

void RayCaster::update(const SceneModelPtr& model, const std::vector<Pose>& poses,
                       RayTargets targets) {
  Impl& impl = *impl_;
  const bool other = model != impl.model || targets != impl.targets;
  if (other) impl.take_model(model, targets);
  if (!model) {
    impl.in_list.clear();
    impl.in_tree.clear();
    impl.tree.build({});
    return;
  }
  bool rebuild = other || impl.poses.size() != model->bodies.size();
  if (rebuild) {
    // A body without a pose has none that is finite either.
    Pose none;
    none.p.setConstant(std::numeric_limits<double>::quiet_NaN());
    impl.poses.assign(model->bodies.size(), none);
    std::copy_n(poses.begin(), std::min(poses.size(), impl.poses.size()), impl.poses.begin());
    impl.build_tree();
    return;
  }
  bool moved = false;
  for (std::size_t b = 0; b < std::min(poses.size(), impl.poses.size()); ++b) {
    if (same(poses[b], impl.poses[b])) continue;
    impl.poses[b] = poses[b];
    for (int i = impl.first[b]; i < impl.first[b + 1]; ++i) {
      Placed& p = impl.placed[i];
      const Placed::Group before = p.group;
      impl.place(p, poses[b]);
      if (p.group != before) {
        rebuild = true;
      } else if (p.group == Placed::Group::tree) {
        moved = true;
        if (!impl.tree.move(p.box, impl.box_of(p))) rebuild = true;
      }
    }
  }
  if (rebuild) {
    impl.build_tree();
  } else if (moved) {
    impl.tree.refit();
  }
}

RayHit RayCaster::cast(const Ray& ray, const std::vector<int>& ignored) const {
  const Impl& impl = *impl_;
  RayHit hit;
  const double length = ray.direction.norm();
  if (!ray.origin.allFinite() || !(length > 0.0) || !std::isfinite(length)) return hit;
  const Vec3 direction = ray.direction / length;
  Cast cast(ray, direction, ignored, impl.placed, impl.in_tree);
  if (!(cast.from() <= cast.limit()) || std::isnan(ray.min_distance)) return hit;
  for (const int i : impl.in_list) cast.meet(impl.placed[i]);
  impl.tree.trace(ray.origin, direction, cast.from(), cast.limit(), cast);

  const Candidate& best = cast.best();
  if (best.placed == nullptr) return hit;
  const Placed& placed = *best.placed;
  hit.distance = best.distance;
  hit.body = placed.body;
  hit.shape = placed.shape_index;
  hit.point = ray.origin + best.distance * direction;
  hit.inside = best.inside;
  Vec3 normal_S = Vec3::UnitZ();
  if (placed.triangles != nullptr) {
    normal_S = placed.triangles->normal(best.triangle);
    // A hull's triangles are not the file's.
    const bool hull =
        placed.shape->type == ShapeType::convex_mesh && impl.targets == RayTargets::colliding;
    if (!hull) hit.triangle = best.triangle;
  } else if (placed.shape->type != ShapeType::plane) {
    const Vec3 point_S = placed.R_WS.transpose() * (hit.point - placed.p_WS);
    normal_S = geometry::solid_normal(*placed.shape, point_S, best.face);
  }
  hit.normal = placed.R_WS * normal_S;
  if (best.inside) hit.normal = -hit.normal;
  return hit;
}

void RayCaster::cast(const std::vector<Ray>& rays, std::vector<RayHit>& hits,
                     const std::vector<int>& ignored) const {
  hits.resize(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = cast(rays[i], ignored);
}

}  // namespace cogrsim
