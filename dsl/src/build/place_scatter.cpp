#include "build/place_scatter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/convex.h"
#include "cogrsim/geometry/convex_hull.h"
#include "cogrsim/geometry/triangles.h"

namespace cogrsim::dsl {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr int kCirclePoints = 16;
constexpr int kDraws = 300;  // positions drawn for one bundle before a grid is tried
constexpr int kFine = 48,
              kCoarse = 6;        // grid positions along a side: of one rectangle, of many
constexpr double kStands = 1e-6;  // [m] what stands on something does not overlap it
constexpr int kMaxBins = 128;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

double point_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * d).norm();
}

// Whether some edge of `a`, or an end of it if it is a segment, has all of `b` on its outer side.
bool parted(const std::vector<Vec2>& a, const Vec2& at, const std::vector<Vec2>& b) {
  if (a.size() < 2) return false;
  if (a.size() == 2)
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec2 end = a[i] + at, out = a[i] - a[1 - i];
      if (std::all_of(b.begin(), b.end(), [&](const Vec2& q) { return out.dot(q - end) > 0; }))
        return true;
    }
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec2 p = a[i] + at, d = a[(i + 1) % a.size()] + at - p;
    if (std::all_of(b.begin(), b.end(), [&](const Vec2& q) { return cross(d, q - p) < 0; }))
      return true;
  }
  return false;
}

double edges_distance(const std::vector<Vec2>& a, const Vec2& at, const std::vector<Vec2>& b) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec2& p : a)
    for (std::size_t i = 0; i < b.size(); ++i)
      least = std::min(least, point_segment(p + at, b[i], b[(i + 1) % b.size()]));
  return least;
}

void add_points(const std::vector<Vec3>& points, double radius, std::vector<Solid>& out) {
  Solid solid;
  solid.radius = radius;
  solid.bottom = std::numeric_limits<double>::infinity();
  solid.top = -solid.bottom;
  std::vector<Vec2> flat;
  flat.reserve(points.size());
  for (const Vec3& p : points) {
    flat.emplace_back(p.x(), p.y());
    solid.bottom = std::min(solid.bottom, p.z() - radius);
    solid.top = std::max(solid.top, p.z() + radius);
  }
  solid.outline = geometry::convex_hull(std::move(flat));
  if (!solid.outline.empty()) out.push_back(std::move(solid));
}

}  // namespace

void add_solids(const SceneModel& model, const Shape& shape, const Pose& X_GS,
                std::vector<Solid>& out) {
  std::vector<Vec3> points;
  switch (shape.type) {
    case ShapeType::box:
      for (int i = 0; i < 8; ++i)
        points.push_back(X_GS * geometry::local_bounds(model, shape).corner(i));
      return add_points(points, 0.0, out);
    case ShapeType::sphere:
      return add_points({X_GS.p}, shape.radius, out);
    case ShapeType::capsule:
      return add_points(
          {X_GS * Vec3(0, 0, 0.5 * shape.length), X_GS * Vec3(0, 0, -0.5 * shape.length)},
          shape.radius, out);
    case ShapeType::cylinder: {
      // The polygon circumscribes the circle; its height is exact.
      const double around = shape.radius / std::cos(kPi / kCirclePoints);
      for (int i = 0; i < kCirclePoints; ++i) {
        const double angle = 2 * kPi * i / kCirclePoints;
        for (const double z : {-0.5, 0.5})
          points.push_back(
              X_GS * Vec3(around * std::cos(angle), around * std::sin(angle), z * shape.length));
      }
      add_points(points, 0.0, out);
      const geometry::Bounds bounds = geometry::core_of(model, shape).bounds(X_GS);
      out.back().bottom = bounds.low.z();
      out.back().top = bounds.high.z();
      return;
    }
    case ShapeType::convex_mesh:
      for (const Vec3& v : model.meshes[shape.mesh]->vertices) points.push_back(X_GS * v);
      return add_points(points, 0.0, out);
    case ShapeType::mesh: {
      const TriangleMesh& mesh = *model.meshes[shape.mesh];
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const geometry::Triangle t = geometry::triangle(mesh, i);
        add_points({X_GS * t[0], X_GS * t[1], X_GS * t[2]}, 0.0, out);
      }
      return;
    }
    default:
      return;
  }
}

double distance(const Solid& a, const Vec2& at, const Solid& b) {
  const bool meet = a.outline.size() + b.outline.size() > 2 && !parted(a.outline, at, b.outline) &&
                    !parted(b.outline, -at, a.outline);
  const double gap = meet ? 0.0
                          : std::min(edges_distance(a.outline, at, b.outline),
                                     edges_distance(b.outline, -at, a.outline));
  return std::max(0.0, gap - a.radius - b.radius);
}

double Bundle::lowest() const {
  double z = std::numeric_limits<double>::infinity();
  for (const Solid& solid : solids) z = std::min(z, solid.bottom);
  return solids.empty() ? 0.0 : z;
}

Scatterer::Scatterer(const Ground& ground, const std::vector<Solid>& obstacles, double clearance,
                     std::size_t& budget)
    : ground_(ground), clearance_(clearance), budget_(budget) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  whole_ = {kFar, -kFar, kFar, -kFar};
  for (const Ground::Rectangle& r : ground.rectangles)
    whole_ = {std::min(whole_.x0, r.x0), std::max(whole_.x1, r.x1), std::min(whole_.y0, r.y0),
              std::max(whole_.y1, r.y1)};
  if (ground.radius > 0) whole_ = {-ground.radius, ground.radius, -ground.radius, ground.radius};
  whole_ = {whole_.x0 - clearance, whole_.x1 + clearance, whole_.y0 - clearance,
            whole_.y1 + clearance};
  const double width = whole_.x1 - whole_.x0, depth = whole_.y1 - whole_.y0;
  bin_ = std::max(width, depth) / kMaxBins;
  columns_ = std::clamp(static_cast<int>(std::ceil(width / bin_)), 1, kMaxBins);
  rows_ = std::clamp(static_cast<int>(std::ceil(depth / bin_)), 1, kMaxBins);
  bin_contents_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (const Solid& solid : obstacles) add(solid);
}

template <class Use>
bool Scatterer::bins(const Bounds& b, Use&& use) const {
  if (b.x1 < whole_.x0 || b.x0 > whole_.x1 || b.y1 < whole_.y0 || b.y0 > whole_.y1) return true;
  const auto index = [&](double v, double origin, int count) {
    return static_cast<int>(std::clamp((v - origin) / bin_, 0.0, count - 1.0));
  };
  const int c0 = index(b.x0, whole_.x0, columns_), c1 = index(b.x1, whole_.x0, columns_);
  const int r0 = index(b.y0, whole_.y0, rows_), r1 = index(b.y1, whole_.y0, rows_);
  for (int r = r0; r <= r1; ++r)
    for (int c = c0; c <= c1; ++c)
      if (!use(static_cast<std::size_t>(r * columns_ + c))) return false;
  return true;
}

void Scatterer::add(Solid solid) {
  Bounds b{1e300, -1e300, 1e300, -1e300};
  for (const Vec2& p : solid.outline)
    b = {std::min(b.x0, p.x() - solid.radius), std::max(b.x1, p.x() + solid.radius),
         std::min(b.y0, p.y() - solid.radius), std::max(b.y1, p.y() + solid.radius)};
  const int index = static_cast<int>(obstacles_.size());
  bool near = false;
  bins(b, [&](std::size_t bin) {
    bin_contents_[bin].push_back(index);
    return near = true;
  });
  if (!near) return;
  obstacles_.push_back(std::move(solid));
  bounds_.push_back(b);
}

bool Scatterer::fits(const Bundle& bundle, double x, double y, double lift) {
  const Vec2 at(x, y);
  for (const Solid& solid : bundle.solids) {
    Bounds b{1e300, -1e300, 1e300, -1e300};
    for (const Vec2& p : solid.outline)
      b = {std::min(b.x0, x + p.x() - solid.radius - clearance_),
           std::max(b.x1, x + p.x() + solid.radius + clearance_),
           std::min(b.y0, y + p.y() - solid.radius - clearance_),
           std::max(b.y1, y + p.y() + solid.radius + clearance_)};
    const double bottom = solid.bottom + lift + kStands, top = solid.top + lift - kStands;
    const bool free = bins(b, [&](std::size_t bin) {
      for (const int index : bin_contents_[bin]) {
        const auto k = static_cast<std::size_t>(index);
        const Solid& other = obstacles_[k];
        const Bounds& o = bounds_[k];
        if (other.top <= bottom || other.bottom >= top) continue;
        if (o.x1 < b.x0 || o.x0 > b.x1 || o.y1 < b.y0 || o.y0 > b.y1) continue;
        if (budget_ > 0) --budget_;
        const double gap = distance(solid, at, other);
        if (gap < clearance_ || gap <= 0.0) return false;
      }
      return true;
    });
    if (!free) return false;
  }
  return true;
}

std::optional<Vec3> Scatterer::put(const Bundle& bundle, RandomStream& random) {
  Bounds own{1e300, -1e300, 1e300, -1e300};
  for (const Solid& s : bundle.solids)
    for (const Vec2& p : s.outline)
      own = {std::min(own.x0, p.x() - s.radius), std::max(own.x1, p.x() + s.radius),
             std::min(own.y0, p.y() - s.radius), std::max(own.y1, p.y() + s.radius)};
  if (bundle.solids.empty()) own = {0, 0, 0, 0};
  const double lift = std::max(0.0, -bundle.lowest());
  const auto within_circle = [&](double x, double y) {
    for (const Solid& s : bundle.solids)
      for (const Vec2& p : s.outline)
        if ((p + Vec2(x, y)).norm() + s.radius > ground_.radius) return false;
    return true;
  };
  // The origin's share of a rectangle, u and v from 0 to 1.
  const auto attempt = [&](const Ground::Rectangle& r, double u, double v) -> std::optional<Vec3> {
    const double x0 = r.x0 - own.x0, x1 = r.x1 - own.x1, y0 = r.y0 - own.y0, y1 = r.y1 - own.y1;
    if (budget_ == 0) return std::nullopt;
    --budget_;
    if (x0 > x1 || y0 > y1) return std::nullopt;
    const double x = x0 + u * (x1 - x0), y = y0 + v * (y1 - y0);
    if (ground_.radius > 0 && !within_circle(x, y)) return std::nullopt;
    if (!fits(bundle, x, y, lift)) return std::nullopt;
    return Vec3(x, y, lift);
  };
  std::vector<Ground::Rectangle> all = ground_.rectangles;
  if (ground_.radius > 0)
    all = {{-ground_.radius, ground_.radius, -ground_.radius, ground_.radius}};
  std::optional<Vec3> found;
  for (int i = 0; i < kDraws && !found && !all.empty(); ++i) {
    const auto k = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(all.size())));
    const double u = random.uniform(), v = random.uniform();
    found = attempt(all[std::min(k, all.size() - 1)], u, v);
  }
  const int side = all.size() > 1 ? kCoarse : kFine;
  const auto first = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(all.size())));
  for (std::size_t i = 0; i < all.size() && !found; ++i)
    for (int k = 0; k <= side && !found; ++k)
      for (int l = 0; l <= side && !found && budget_ > 0; ++l)
        found = attempt(all[(first + i) % all.size()], static_cast<double>(k) / side,
                        static_cast<double>(l) / side);
  if (!found) return found;
  for (Solid solid : bundle.solids) {
    for (Vec2& p : solid.outline) p += Vec2(found->x(), found->y());
    solid.bottom += lift;
    solid.top += lift;
    add(std::move(solid));
  }
  return found;
}

}  // namespace cogrsim::dsl
