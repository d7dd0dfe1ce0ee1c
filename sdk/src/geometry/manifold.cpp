#include "cogrsim/geometry/manifold.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cogrsim::geometry {
namespace {

constexpr int kMost = 2 * Feature::kMost;
// A face that leans away from the normal by more than this (cosine) determines no heights.
constexpr double kSteepest = 0.1;
constexpr double kParallel = 0.05;  // sine of the angle up to which two edges count as parallel

struct Point2 {
  double x, y;
};

// A feature in axes (t1, t2, n): its outline across n and its height along n.
class Projected {
 public:
  Projected(const Feature& f, const Vec3& t1, const Vec3& t2, const Vec3& n) : count(f.count) {
    for (int i = 0; i < count; ++i) {
      outline[i] = {f.points[i].dot(t1), f.points[i].dot(t2)};
      heights_[i] = f.points[i].dot(n);
    }
    if (count < 3) return;
    // Newell's normal in these axes.
    double nx = 0, ny = 0, nz = 0;
    for (int i = 0, j = count - 1; i < count; j = i++) {
      nx += (outline[j].y - outline[i].y) * (heights_[j] + heights_[i]);
      ny += (heights_[j] - heights_[i]) * (outline[j].x + outline[i].x);
      nz += (outline[j].x - outline[i].x) * (outline[j].y + outline[i].y);
    }
    const double length = std::sqrt(nx * nx + ny * ny + nz * nz);
    flat_enough = length > 0.0 && std::abs(nz) > kSteepest * length;
    if (!flat_enough) return;
    slope_x_ = -nx / nz;
    slope_y_ = -ny / nz;
    if (nz < 0) {
      std::reverse(outline, outline + count);
      std::reverse(heights_, heights_ + count);
    }
  }

  double height(const Point2& p) const {
    if (count == 1) return heights_[0];
    if (count == 2) {
      const double dx = outline[1].x - outline[0].x, dy = outline[1].y - outline[0].y;
      const double square = dx * dx + dy * dy;
      if (square < 1e-24) return std::min(heights_[0], heights_[1]);
      const double s = ((p.x - outline[0].x) * dx + (p.y - outline[0].y) * dy) / square;
      return heights_[0] + std::clamp(s, 0.0, 1.0) * (heights_[1] - heights_[0]);
    }
    return heights_[0] + slope_x_ * (p.x - outline[0].x) + slope_y_ * (p.y - outline[0].y);
  }

  int count = 0;
  bool flat_enough = true;
  Point2 outline[Feature::kMost];  ///< counter-clockwise when a polygon

 private:
  double heights_[Feature::kMost];
  double slope_x_ = 0.0, slope_y_ = 0.0;
};

// Positive inside the half-plane left of a-b.
double side_of(const Point2& a, const Point2& b, const Point2& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

// Sutherland and Hodgman: what of `subject` (closed, or an open segment) lies in the polygon.
int clip(const Projected& polygon, const Projected& subject, Point2* out) {
  Point2 buffer[2][kMost];
  int count = subject.count;
  std::copy(subject.outline, subject.outline + count, buffer[0]);
  int from = 0;
  const bool segment = subject.count == 2;
  for (int e = 0; e < polygon.count && count > 0; ++e) {
    const Point2& a = polygon.outline[e];
    const Point2& b = polygon.outline[(e + 1) % polygon.count];
    const Point2* const in = buffer[from];
    Point2* const result = buffer[1 - from];
    int kept = 0;
    const auto cross_edge = [&](const Point2& p, double sp, const Point2& q, double sq) {
      const double t = sp / (sp - sq);
      if (kept < kMost) result[kept++] = {p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)};
    };
    for (int i = 0; i < count; ++i) {
      const Point2& p = in[i];
      const double sp = side_of(a, b, p);
      if (sp >= 0.0 && kept < kMost) result[kept++] = p;
      if (segment && i == count - 1) break;
      const Point2& q = in[(i + 1) % count];
      const double sq = side_of(a, b, q);
      if ((sp > 0.0 && sq < 0.0) || (sp < 0.0 && sq > 0.0)) cross_edge(p, sp, q, sq);
    }
    count = kept;
    from = 1 - from;
  }
  std::copy(buffer[from], buffer[from] + count, out);
  return count;
}

// The stretch over which two nearly parallel segments lie above each other.
int overlap(const Projected& a, const Projected& b, Point2* out) {
  const double ax = a.outline[1].x - a.outline[0].x, ay = a.outline[1].y - a.outline[0].y;
  const double bx = b.outline[1].x - b.outline[0].x, by = b.outline[1].y - b.outline[0].y;
  const double la = std::hypot(ax, ay), lb = std::hypot(bx, by);
  if (la < 1e-9 || lb < 1e-9 || std::abs(ax * by - ay * bx) > kParallel * la * lb) return 0;
  const auto along = [&](const Point2& p) {
    return ((p.x - a.outline[0].x) * ax + (p.y - a.outline[0].y) * ay) / la;
  };
  const double b0 = along(b.outline[0]), b1 = along(b.outline[1]);
  const double low = std::max(0.0, std::min(b0, b1)), high = std::min(la, std::max(b0, b1));
  if (low > high) return 0;
  int count = 0;
  for (double s : {low, high})
    out[count++] = {a.outline[0].x + ax * s / la, a.outline[0].y + ay * s / la};
  return count;
}

}  // namespace

void face_contacts(const Feature& fa, const Feature& fb, const Separation& separation,
                   double margin, std::vector<ContactPoint>& out) {
  const Vec3& n = separation.normal;
  const Vec3 least = std::abs(n[0]) < 0.6 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 t1 = (least - n * n.dot(least)).normalized();
  const Vec3 t2 = n.cross(t1);
  const Projected a(fa, t1, t2, n), b(fb, t1, t2, n);

  Point2 points[kMost];
  int count = 0;
  if (a.flat_enough && b.flat_enough) {
    if (a.count >= 3 && b.count >= 2)
      count = clip(a, b, points);
    else if (b.count >= 3 && a.count == 2)
      count = clip(b, a, points);
    else if (a.count == 2 && b.count == 2)
      count = overlap(a, b, points);
  }
  double least_gap = margin;
  bool any = false;
  for (int i = 0; i < count; ++i) {
    const double ha = a.height(points[i]), hb = b.height(points[i]);
    if (hb - ha > margin) continue;
    ContactPoint c;
    c.normal = n;
    c.gap = hb - ha;
    c.point = points[i].x * t1 + points[i].y * t2 + 0.5 * (ha + hb) * n;
    out.push_back(c);
    any = true;
    least_gap = std::min(least_gap, c.gap);
  }
  // A point between the corners has to be clearly nearer: rounding must not add and take points.
  constexpr double kNearer = 1e-5;
  if (separation.has_points && separation.gap <= margin &&
      (!any || separation.gap < least_gap - kNearer - separation.blur)) {
    ContactPoint c;
    c.normal = n;
    c.gap = separation.gap;
    c.point = 0.5 * (separation.on_a + separation.on_b);
    out.push_back(c);
  }
}

void reduce_points(std::vector<ContactPoint>& points, std::size_t first) {
  const std::size_t count = points.size() - first;
  if (count <= 4) return;
  const auto at = [&](std::size_t i) -> ContactPoint& { return points[first + i]; };
  // Equal to rounding must not decide by chance: a later point has to be clearly better.
  constexpr double kClearly = 1.0 + 1e-6;
  constexpr double kSameDepth = 1e-5;  // [m]
  std::size_t pick = 0;
  Vec3 middle = at(0).point;
  for (std::size_t i = 1; i < count; ++i) {
    if (at(i).gap < at(pick).gap - kSameDepth) pick = i;
    middle += at(i).point;
  }
  middle /= double(count);
  // Of those as deep the farthest out: two edges that nearly coincide cross anywhere along them, and
  // that point in place of a corner would leave the corner without support.
  const double deepest = at(pick).gap + kSameDepth;
  double most = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double d = (at(i).point - middle).squaredNorm();
    if (at(i).gap <= deepest && d > most * kClearly) {
      most = d;
      pick = i;
    }
  }
  std::swap(at(0), at(pick));

  most = -1.0;
  pick = 1;
  for (std::size_t i = 1; i < count; ++i) {
    const double d = (at(i).point - at(0).point).squaredNorm();
    if (d > most * kClearly) {
      most = d;
      pick = i;
    }
  }
  std::swap(at(1), at(pick));

  // Farthest on either side of the line between those two.
  const Vec3 n = at(0).normal;
  const Vec3 edge = at(1).point - at(0).point;
  const auto area = [&](std::size_t i) { return n.dot(edge.cross(at(i).point - at(0).point)); };
  pick = 2;
  for (std::size_t i = 3; i < count; ++i)
    if (std::abs(area(i)) > std::abs(area(pick)) * kClearly) pick = i;
  std::swap(at(2), at(pick));
  const double sign = area(2) > 0 ? -1.0 : 1.0;
  pick = 3;
  for (std::size_t i = 4; i < count; ++i)
    if (sign * area(i) > sign * area(pick) + 1e-12) pick = i;
  std::swap(at(3), at(pick));
  points.resize(first + 4);
}

}  // namespace cogrsim::geometry
