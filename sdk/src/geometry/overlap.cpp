#include "cogrsim/geometry/overlap.h"

#include <cmath>
#include <map>

#include "geometry/penetration.h"

namespace cogrsim::geometry {
namespace {

constexpr std::size_t kMostFound = 1000;
// Of comparisons, in units of some 10 ns.
constexpr std::size_t kMostWork = 100'000'000;
constexpr std::size_t kComparison = 64;  // and one for each vertex of a mesh
constexpr std::size_t kRound = 256;      // of an expanding polytope
constexpr double kDeep = 1e4;            // [m]: what is further below a heightmap is not looked for

bool is_ground(const Shape& shape) {
  return shape.type == ShapeType::plane || shape.type == ShapeType::mesh ||
         shape.type == ShapeType::heightmap;
}

/// What is compared, and how much was.
class Comparer {
 public:
  /// Depths of at most `enough` [m] may come out as any number up to it.
  Comparer(const SceneModel& model, double enough) : model_(model), enough_(enough) {}

  std::size_t work() const { return work_; }

  Penetration convex(const Core& a, const Pose& X_WA, const Core& b, const Pose& X_WB) {
    work_ += kComparison + a.count + b.count;
    std::size_t rounds = 0;
    const Penetration out = convex_penetration({a, X_WA}, {b, X_WB}, enough_, rounds);
    work_ += kRound * rounds;
    return out;
  }

  /// The normal is the ground's outward one.
  Penetration ground(const Shape& ground, const Pose& X_WG, const Core& core, const Pose& X_WC) {
    const Pose X_GC = X_WG.inverse() * X_WC;
    const Placed placed{core, X_GC};
    Penetration out;
    switch (ground.type) {
      case ShapeType::plane:
        work_ += 1 + core.count;
        out.depth = core.margin - placed.support(-Vec3::UnitZ()).z();
        break;
      case ShapeType::heightmap:
        out = over_heights(*model_.heightmaps[ground.heightmap], placed);
        break;
      default:
        out = in_triangles(ground.mesh, placed);
    }
    out.normal = X_WG.q * out.normal;
    out.depth = std::max(out.depth, 0.0);
    return out;
  }

 private:
  Penetration over_heights(const HeightGrid& grid, const Placed& placed) {
    work_ += 6 * placed.core.count;
    const Bounds above = placed.core.bounds(placed.X_WS);
    Penetration out;
    for_triangles(grid, above, [&](const Triangle& triangle) {
      if (bounds_of(triangle).high.z() - above.low.z() <= out.depth || work_ > kMostWork) return;
      work_ += kComparison + placed.core.count;
      out.depth = std::max(out.depth, lift_over(placed, triangle, out.depth));
    });
    return out;
  }

  Penetration in_triangles(int index, const Placed& placed) {
    const TriangleMesh& mesh = *model_.meshes[index];
    const auto [known, is_new] = trees_.try_emplace(index);
    if (is_new) {
      std::vector<Bounds> boxes;
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        boxes.push_back(bounds_of(triangle(mesh, i)));
      known->second = BoundsTree(boxes);
    }
    work_ += 6 * placed.core.count;
    const Bounds bounds = placed.core.bounds(placed.X_WS);
    Penetration out;
    known->second.visit(bounds, [&](std::size_t i) {
      const Triangle corners = triangle(mesh, i);
      if (bounds_of(corners).disjoint(bounds)) return true;
      const Penetration in = convex(core_of(corners.data()), {}, placed.core, placed.X_WS);
      if (in.depth > out.depth) out = in;
      return work_ <= kMostWork;
    });
    return out;
  }

  const SceneModel& model_;
  double enough_;
  std::map<int, BoundsTree> trees_;  // by mesh, made when it is met
  std::size_t work_ = 0;
};

/// A colliding shape where it stands.
struct Solid {
  int body = -1, index = -1;
  const Shape* shape = nullptr;
  Pose X_WS;
  Core core;  // of what is no ground
  Bounds bounds;
};

class Finder {
 public:
  explicit Finder(const SceneModel& model)
      : model_(model), filter_(model), comparer_(model, kTouchingDepth) {}

  Overlaps find() {
    collect();
    std::vector<Bounds> boxes;
    for (const Solid& solid : solids_) boxes.push_back(solid.bounds);
    const BoundsTree tree(boxes);
    bool complete = true;
    for (std::size_t g = 0; g < grounds_.size() && complete; ++g)
      tree.visit(grounds_[g].bounds,
                 [&](std::size_t i) { return complete = compare(grounds_[g], solids_[i]); });
    for (std::size_t i = 0; i < solids_.size() && complete; ++i)
      tree.visit(solids_[i].bounds, [&](std::size_t j) {
        return complete = j <= i || compare(solids_[i], solids_[j]);
      });
    Overlaps out;
    out.complete = complete;
    for (const auto& [pair, overlap] : found_) out.pairs.push_back(overlap);
    return out;
  }

 private:
  void collect() {
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      const Body& body = model_.bodies[b];
      for (std::size_t s = 0; s < body.shapes.size(); ++s) {
        const Shape& shape = body.shapes[s];
        if (!shape.collides) continue;
        Solid solid;
        solid.body = static_cast<int>(b);
        solid.index = static_cast<int>(s);
        solid.shape = &shape;
        solid.X_WS = body.X_WB * shape.X_BS;
        if (!is_ground(shape)) solid.core = core_of(model_, shape);
        solid.bounds = bounds_of(solid);
        (is_ground(shape) ? grounds_ : solids_).push_back(solid);
      }
    }
  }

  Bounds bounds_of(const Solid& solid) {
    const Shape& shape = *solid.shape;
    if (shape.type == ShapeType::plane) return all_bounds();
    if (shape.type == ShapeType::heightmap) {
      // All below it is in it.
      const HeightGrid& grid = *model_.heightmaps[shape.heightmap];
      const double high = *std::max_element(grid.heights.begin(), grid.heights.end());
      const Vec3 top(0.5 * grid.size_x, 0.5 * grid.size_y, high);
      return carried({Vec3(-top.x(), -top.y(), high - kDeep), top}, solid.X_WS);
    }
    if (shape.mesh < 0) return solid.core.bounds(solid.X_WS);
    // Many bodies may have the same large mesh.
    const auto [known, is_new] = mesh_bounds_.try_emplace(shape.mesh);
    if (is_new)
      for (const Vec3& v : model_.meshes[shape.mesh]->vertices) known->second.add(v);
    return carried(known->second, solid.X_WS);
  }

  // False: enough.
  bool compare(const Solid& a, const Solid& b) {
    ++looked_at_;
    if (comparer_.work() + looked_at_ > kMostWork) return false;
    if (a.bounds.disjoint(b.bounds, -kTouchingDepth) || !filter_.collide(a.body, b.body))
      return true;
    const Penetration in = is_ground(*a.shape) ? comparer_.ground(*a.shape, a.X_WS, b.core, b.X_WS)
                                               : comparer_.convex(a.core, a.X_WS, b.core, b.X_WS);
    if (in.depth <= kTouchingDepth) return true;
    const bool swap = a.body > b.body;
    const Solid& first = swap ? b : a;
    const Solid& second = swap ? a : b;
    Overlap& worst = found_[{first.body, second.body}];
    if (in.depth > worst.depth) {
      const Vec3 low = a.bounds.low.cwiseMax(b.bounds.low);
      const Vec3 high = a.bounds.high.cwiseMin(b.bounds.high);
      worst = {first.body,        second.body, first.index,
               second.index,      in.depth,    swap ? Vec3(-in.normal) : in.normal,
               0.5 * (low + high)};
    }
    return found_.size() < kMostFound;
  }

  const SceneModel& model_;
  CollisionFilter filter_;
  Comparer comparer_;
  std::vector<Solid> grounds_, solids_;
  std::map<int, Bounds> mesh_bounds_;
  std::map<BodyPair, Overlap> found_;
  std::size_t looked_at_ = 0;
};

}  // namespace

Penetration penetration(const SceneModel& model, const Shape& a, const Pose& X_WA, const Shape& b,
                        const Pose& X_WB) {
  constexpr double kRounding = 1e-9;  // [m]
  Comparer comparer(model, kRounding);
  if (is_ground(a) && is_ground(b)) return {};
  if (is_ground(a)) return comparer.ground(a, X_WA, core_of(model, b), X_WB);
  if (!is_ground(b)) return comparer.convex(core_of(model, a), X_WA, core_of(model, b), X_WB);
  Penetration out = comparer.ground(b, X_WB, core_of(model, a), X_WA);
  out.normal = -out.normal;
  return out;
}

Overlaps find_overlaps(const SceneModel& model) { return Finder(model).find(); }

}  // namespace cogrsim::geometry
