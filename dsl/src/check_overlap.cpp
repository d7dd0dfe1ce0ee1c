#include "check_overlap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>

namespace cogrsim::dsl {
namespace {

constexpr double kTouching = 1e-5;  // [m] less is how people place things on each other
constexpr std::size_t kMaxTests = 2'000'000;
constexpr std::size_t kMaxFound = 1000;

struct Solid {
  int body = -1, index = -1;
  const Shape* shape = nullptr;
  Pose X_WS;
  double radius = 0.0;  // of the bounding sphere about X_WS.p
};

// A box's half extents seen along a direction in its own axes.
double box_reach(const Vec3& size, const Vec3& direction) {
  return 0.5 * size.cwiseProduct(direction.cwiseAbs()).sum();
}

/// Nearest points of two segments p ± a and q ± b (Ericson, Real-Time Collision Detection, 5.1.9);
/// returns their distance.
double segment_distance(const Vec3& p, const Vec3& a, const Vec3& q, const Vec3& b) {
  const Vec3 d1 = 2 * a, d2 = 2 * b, r = (p - a) - (q - b);
  const double aa = d1.squaredNorm(), ee = d2.squaredNorm(), f = d2.dot(r);
  double s = 0.0, t = 0.0;
  if (aa > 0.0) {
    const double c = d1.dot(r), bb = d1.dot(d2), denominator = aa * ee - bb * bb;
    s = denominator > 1e-12 * aa * ee ? std::clamp((bb * f - c * ee) / denominator, 0.0, 1.0) : 0.0;
    t = ee > 0.0 ? (bb * s + f) / ee : 0.0;
    if (t < 0.0 || t > 1.0 || ee <= 0.0) {
      t = std::clamp(t, 0.0, 1.0);
      s = std::clamp((bb * t - c) / aa, 0.0, 1.0);
    }
  } else if (ee > 0.0) {
    t = std::clamp(f / ee, 0.0, 1.0);
  }
  return (r + s * d1 - t * d2).norm();
}

// Depth along the axis of least overlap; negative when some axis separates the boxes.
double box_box(const Solid& a, const Solid& b) {
  const Mat3 A = a.X_WS.q.toRotationMatrix(), B = b.X_WS.q.toRotationMatrix();
  const Vec3 between = b.X_WS.p - a.X_WS.p;
  double depth = std::numeric_limits<double>::infinity();
  const auto try_axis = [&](const Vec3& axis) {
    const double length = axis.norm();
    if (length < 1e-9) return;  // edges in parallel: the faces decide
    const Vec3 n = axis / length;
    const double reach =
        box_reach(a.shape->size, A.transpose() * n) + box_reach(b.shape->size, B.transpose() * n);
    depth = std::min(depth, reach - std::abs(n.dot(between)));
  };
  for (int i = 0; i < 3; ++i) {
    try_axis(A.col(i));
    try_axis(B.col(i));
    for (int j = 0; j < 3; ++j) try_axis(A.col(i).cross(B.col(j)));
    if (depth < 0.0) return depth;
  }
  return depth;
}

double sphere_box(const Solid& sphere, const Solid& box) {
  const Vec3 p = box.X_WS.inverse() * sphere.X_WS.p;
  const Vec3 half = 0.5 * box.shape->size;
  const Vec3 nearest = p.cwiseMax(-half).cwiseMin(half);
  const double distance = (p - nearest).norm();
  if (distance > 0.0) return sphere.shape->radius - distance;
  return sphere.shape->radius + (half - p.cwiseAbs()).minCoeff();  // the centre is inside
}

// How far `solid` reaches below the plane.
double below_plane(const Solid& plane, const Solid& solid, const SceneModel& model) {
  const Vec3 n = plane.X_WS.q * Vec3::UnitZ();
  const double height = n.dot(solid.X_WS.p - plane.X_WS.p);
  const Shape& shape = *solid.shape;
  const double along = std::abs(n.dot(solid.X_WS.q * Vec3::UnitZ()));
  switch (shape.type) {
    case ShapeType::sphere:
      return shape.radius - height;
    case ShapeType::capsule:
      return shape.radius + 0.5 * shape.length * along - height;
    case ShapeType::cylinder:
      return 0.5 * shape.length * along +
             shape.radius * std::sqrt(std::max(0.0, 1.0 - along * along)) - height;
    case ShapeType::box:
      return box_reach(shape.size, solid.X_WS.q.conjugate() * n) - height;
    case ShapeType::convex_mesh: {
      double lowest = std::numeric_limits<double>::infinity();
      const Vec3 n_S = solid.X_WS.q.conjugate() * n;
      for (const Vec3& v : model.meshes[static_cast<std::size_t>(shape.mesh)].vertices)
        lowest = std::min(lowest, n_S.dot(v));
      return -(height + lowest);
    }
    default:
      return -1.0;
  }
}

bool round(ShapeType type) { return type == ShapeType::sphere || type == ShapeType::capsule; }

// Half of the segment that a sphere or capsule is swept along.
Vec3 core(const Solid& solid) {
  if (solid.shape->type == ShapeType::sphere) return Vec3::Zero();
  return solid.X_WS.q * Vec3(0, 0, 0.5 * solid.shape->length);
}

double solid_solid(const Solid& a, const Solid& b) {
  const ShapeType ta = a.shape->type, tb = b.shape->type;
  if (round(ta) && round(tb))
    return a.shape->radius + b.shape->radius -
           segment_distance(a.X_WS.p, core(a), b.X_WS.p, core(b));
  if (ta == ShapeType::box && tb == ShapeType::box) return box_box(a, b);
  if (ta == ShapeType::sphere && tb == ShapeType::box) return sphere_box(a, b);
  if (ta == ShapeType::box && tb == ShapeType::sphere) return sphere_box(b, a);
  return -1.0;
}

double bounding_radius(const Shape& shape, const SceneModel& model) {
  switch (shape.type) {
    case ShapeType::box:
      return 0.5 * shape.size.norm();
    case ShapeType::sphere:
      return shape.radius;
    case ShapeType::capsule:
      return shape.radius + 0.5 * shape.length;
    case ShapeType::cylinder:
      return std::hypot(shape.radius, 0.5 * shape.length);
    case ShapeType::convex_mesh: {
      double r2 = 0.0;
      for (const Vec3& v : model.meshes[static_cast<std::size_t>(shape.mesh)].vertices)
        r2 = std::max(r2, v.squaredNorm());
      return std::sqrt(r2);
    }
    default:
      return 0.0;
  }
}

struct Cell {
  int level;
  long long x, y, z;
  bool operator==(const Cell& o) const {
    return level == o.level && x == o.x && y == o.y && z == o.z;
  }
};
struct CellHash {
  std::size_t operator()(const Cell& c) const {
    std::size_t h = static_cast<std::size_t>(c.level) + 0x9e3779b97f4a7c15ull;
    for (const long long v : {c.x, c.y, c.z})
      h = (h ^ static_cast<std::size_t>(v)) * 0xff51afd7ed558ccdull + (h >> 29);
    return h;
  }
};

Cell cell_of(const Vec3& p, int level) {
  const double width = std::ldexp(1.0, level);
  const auto index = [&](double v) {
    return static_cast<long long>(std::clamp(std::floor(v / width), -4e18, 4e18));
  };
  return {level, index(p.x()), index(p.y()), index(p.z())};
}

class Finder {
 public:
  explicit Finder(const SceneModel& model) : model_(model), filter_(model) {}

  std::vector<Overlap> find() {
    collect();
    for (const Solid& plane : planes_)
      for (const Solid& solid : solids_)
        if (!test(plane, solid, true)) return finish();
    // Every solid lies in the cell of its centre, on the level whose cells are as wide as it is; so
    // two that meet lie in neighbouring cells of the coarser one's level.
    std::unordered_map<Cell, std::vector<int>, CellHash> grid;
    std::map<int, int> levels;
    std::vector<int> level(solids_.size());
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      level[i] = static_cast<int>(std::ceil(std::log2(std::max(2.0 * solids_[i].radius, 1e-9))));
      ++levels[level[i]];
      grid[cell_of(solids_[i].X_WS.p, level[i])].push_back(static_cast<int>(i));
    }
    for (std::size_t i = 0; i < solids_.size(); ++i)
      for (auto l = levels.lower_bound(level[i]); l != levels.end(); ++l) {
        const Cell centre = cell_of(solids_[i].X_WS.p, l->first);
        for (long long x = -1; x <= 1; ++x)
          for (long long y = -1; y <= 1; ++y)
            for (long long z = -1; z <= 1; ++z) {
              const auto cell = grid.find({l->first, centre.x + x, centre.y + y, centre.z + z});
              if (cell == grid.end()) continue;
              for (const int j : cell->second) {
                const auto k = static_cast<std::size_t>(j);
                if (l->first == level[i] && k <= i) continue;
                if (!test(solids_[i], solids_[k], false)) return finish();
              }
            }
      }
    return finish();
  }

 private:
  void collect() {
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      const Body& body = model_.bodies[b];
      for (std::size_t s = 0; s < body.shapes.size(); ++s) {
        const Shape& shape = body.shapes[s];
        if (!shape.collides) continue;
        Solid solid{static_cast<int>(b), static_cast<int>(s), &shape, body.X_WB * shape.X_BS, 0.0};
        if (shape.type == ShapeType::plane) {
          planes_.push_back(solid);
        } else if (shape.type != ShapeType::mesh && shape.type != ShapeType::heightmap) {
          solid.radius = bounding_radius(shape, model_);
          solids_.push_back(solid);
        }
      }
    }
  }

  // False: enough.
  bool test(const Solid& a, const Solid& b, bool with_plane) {
    if (++tests_ > kMaxTests) return false;
    const double gap = with_plane ? (a.X_WS.q * Vec3::UnitZ()).dot(b.X_WS.p - a.X_WS.p) - b.radius
                                  : (b.X_WS.p - a.X_WS.p).norm() - a.radius - b.radius;
    if (gap > -kTouching || !filter_.collide(a.body, b.body)) return true;
    const double depth = with_plane ? below_plane(a, b, model_) : solid_solid(a, b);
    if (depth <= kTouching) return true;
    const bool swap = a.body > b.body;
    const Solid& first = swap ? b : a;
    const Solid& second = swap ? a : b;
    Overlap& worst = found_[{first.body, second.body}];
    if (depth > worst.depth) worst = {first.body, second.body, first.index, second.index, depth};
    return found_.size() < kMaxFound;
  }

  std::vector<Overlap> finish() const {
    std::vector<Overlap> out;
    out.reserve(found_.size());
    for (const auto& [pair, overlap] : found_) out.push_back(overlap);
    return out;
  }

  const SceneModel& model_;
  CollisionFilter filter_;
  std::vector<Solid> planes_, solids_;
  std::map<BodyPair, Overlap> found_;
  std::size_t tests_ = 0;
};

}  // namespace

std::vector<Overlap> find_overlaps(const SceneModel& model) { return Finder(model).find(); }

}  // namespace cogrsim::dsl
