#include "face_clip.h"

#include <algorithm>
#include <cmath>

namespace cogrsim::bullet {

namespace {

using Kind = SupportFeature::Kind;

// Each half-plane that cuts can add one corner.
constexpr int kMostPoints = 2 * SupportFeature::kMost;
// A face that leans more than this from the normal (cosine) has no height along it.
constexpr double kSteepest = 0.1;
// Outlines reach farther by this part of the face's width, so that a line that runs just along an
// edge is not lost to rounding.
constexpr double kSlack = 1e-5;
// Feature numbers of points whose place in a patch is known.
constexpr int kFirstEnd = 0, kSecondEnd = 1, kMiddle = 6;

struct Point2 {
  double x, y;
};

/// Axes across and along the normal, and where heights are counted from.
struct Axes {
  btVector3 origin, x, y, n;

  Point2 flat(const btVector3& p) const { return {x.dot(p - origin), y.dot(p - origin)}; }
  double height(const btVector3& p) const { return n.dot(p - origin); }
  btVector3 place(const Point2& p, double h) const { return origin + x * p.x + y * p.y + n * h; }
};

/// A face seen along the normal: its outline, and its height over each place of it.
class Polygon {
 public:
  /// `outward`: 1 where the face looks along the normal, -1 where it looks against it.
  Polygon(const SupportFeature& face, const Axes& axes, double outward) : count(face.count) {
    const double cosine = outward * face.normal.dot(axes.n);
    usable = cosine > kSteepest;
    if (!usable) return;
    slope_x_ = -outward * face.normal.dot(axes.x) / cosine;
    slope_y_ = -outward * face.normal.dot(axes.y) / cosine;
    outward_ = outward;
    for (int i = 0; i < count; ++i) {
      // Counter-clockwise in the axes, also where the face looks the other way.
      const btVector3& p = face.points[outward > 0.0 ? i : count - 1 - i];
      outline[i] = axes.flat(p);
      const double h = axes.height(p);
      if (i == 0) base_ = top_ = h;
      if (outward * h > outward * top_) top_ = h;
    }
  }

  /// No place of the face reaches farther than its farthest corner, outlines' slack or not.
  double height(const Point2& p) const {
    const double h = base_ + slope_x_ * (p.x - outline[0].x) + slope_y_ * (p.y - outline[0].y);
    return outward_ > 0.0 ? std::min(h, top_) : std::max(h, top_);
  }

  bool usable = false;
  int count = 0;
  Point2 outline[SupportFeature::kMost];

 private:
  double slope_x_ = 0.0, slope_y_ = 0.0, base_ = 0.0, top_ = 0.0, outward_ = 1.0;
};

/// What of `points`, a closed outline, lies within the polygon (Sutherland and Hodgman, CACM 17,
/// 1974). The result replaces `points`, which has room for kMostPoints.
int clip_outline(const Polygon& polygon, Point2* points, int count) {
  Point2 spare[kMostPoints];
  Point2* in = points;
  Point2* out = spare;
  double side[kMostPoints];
  for (int e = 0; e < polygon.count && count > 0; ++e) {
    const Point2& from = polygon.outline[e];
    const Point2& to = polygon.outline[e + 1 == polygon.count ? 0 : e + 1];
    const double ex = to.x - from.x, ey = to.y - from.y;
    const double slack = kSlack * (ex * ex + ey * ey);
    bool any_out = false;
    for (int i = 0; i < count; ++i) {
      side[i] = ex * (in[i].y - from.y) - ey * (in[i].x - from.x) + slack;
      any_out = any_out || side[i] < 0.0;
    }
    if (!any_out) continue;
    int kept = 0;
    for (int i = 0; i < count && kept + 2 <= kMostPoints; ++i) {
      const int j = i + 1 == count ? 0 : i + 1;
      if (side[i] >= 0.0) out[kept++] = in[i];
      if ((side[i] > 0.0 && side[j] < 0.0) || (side[i] < 0.0 && side[j] > 0.0)) {
        const double t = side[i] / (side[i] - side[j]);
        out[kept++] = {in[i].x + t * (in[j].x - in[i].x), in[i].y + t * (in[j].y - in[i].y)};
      }
    }
    count = kept;
    std::swap(in, out);
  }
  if (in != points) std::copy(in, in + count, points);
  return count;
}

/// The stretch [low, high] of 0..1 along p-q that lies within the polygon; false: none.
bool clip_line(const Polygon& polygon, const Point2& p, const Point2& q, double& low,
               double& high) {
  low = 0.0;
  high = 1.0;
  for (int e = 0; e < polygon.count; ++e) {
    const Point2& from = polygon.outline[e];
    const Point2& to = polygon.outline[e + 1 == polygon.count ? 0 : e + 1];
    const double ex = to.x - from.x, ey = to.y - from.y;
    const double slack = kSlack * (ex * ex + ey * ey);
    const double sp = ex * (p.y - from.y) - ey * (p.x - from.x) + slack;
    const double sq = ex * (q.y - from.y) - ey * (q.x - from.x) + slack;
    if (sp < 0.0 && sq < 0.0) return false;
    if (sp < 0.0) low = std::max(low, sp / (sp - sq));
    if (sq < 0.0) high = std::min(high, sp / (sp - sq));
  }
  return low <= high;
}

class Adder {
 public:
  Adder(const Axes& axes, double threshold, ContactPatch& patch)
      : axes_(axes), threshold_(threshold), patch_(patch) {}

  void add(const Point2& p, double height_a, double height_b, int feature) {
    const double distance = height_a - height_b;
    if (distance >= threshold_) return;
    patch_.add({axes_.place(p, height_a), axes_.place(p, height_b), axes_.n, distance, feature});
  }

 private:
  const Axes& axes_;
  double threshold_;
  ContactPatch& patch_;
};

void faces(const SupportFeature& a, const SupportFeature& b, const Axes& axes, Adder& adder) {
  const Polygon below(b, axes, 1.0), above(a, axes, -1.0);
  if (!below.usable || !above.usable) return;
  Point2 points[kMostPoints];
  std::copy(above.outline, above.outline + above.count, points);
  const int count = clip_outline(below, points, above.count);
  for (int i = 0; i < count; ++i) {
    adder.add(points[i], above.height(points[i]), below.height(points[i]), -1);
  }
}

/// `outward`: of the face, as Polygon takes it.
void line_over_face(const SupportFeature& line, const SupportFeature& face, double outward,
                    const Axes& axes, Adder& adder) {
  const Polygon polygon(face, axes, outward);
  if (!polygon.usable) return;
  // The line of the round side that reaches farthest: across the axis, for a cylinder's rim.
  const btVector3 along = line.points[1] - line.points[0];
  const double length2 = along.length2();
  btVector3 down = axes.n * -outward;
  if (line.tread && length2 > 0.0) {
    down -= along * (along.dot(down) / length2);
    down.safeNormalize();
  }
  const btVector3 p = line.points[0] + down * line.radius, q = line.points[1] + down * line.radius;
  const Point2 fp = axes.flat(p), fq = axes.flat(q);
  double low, high;
  if (!clip_line(polygon, fp, fq, low, high)) return;
  const double hp = axes.height(p), hq = axes.height(q);
  const auto add = [&](double t, int feature) {
    const Point2 at{fp.x + t * (fq.x - fp.x), fp.y + t * (fq.y - fp.y)};
    const double h = hp + t * (hq - hp), other = polygon.height(at);
    adder.add(at, outward > 0.0 ? h : other, outward > 0.0 ? other : h, feature);
  };
  add(low, kFirstEnd);
  if (high <= low) return;
  add(high, kSecondEnd);
  // As on planes: it is what rolls without slip while a wheel turns on the spot.
  if (line.tread) add(0.5 * (low + high), kMiddle);
}

void lines(const SupportFeature& a, const SupportFeature& b, double threshold,
           ContactPatch& patch) {
  const btVector3 u = a.points[1] - a.points[0], v = b.points[1] - b.points[0];
  const double u2 = u.length2(), v2 = v.length2();
  if (u2 <= 0.0 || v2 <= 0.0) return;
  // Of A's axis, 0..1, what lies beside B's.
  const double b0 = u.dot(b.points[0] - a.points[0]) / u2,
               b1 = u.dot(b.points[1] - a.points[0]) / u2;
  const double low = std::max(0.0, std::min(b0, b1)), high = std::min(1.0, std::max(b0, b1));
  if (high <= low) return;
  const auto add = [&](double t, int feature) {
    const btVector3 on_axis = a.points[0] + u * t;
    const double s = std::clamp(v.dot(on_axis - b.points[0]) / v2, 0.0, 1.0);
    const btVector3 across = on_axis - (b.points[0] + v * s);
    const double apart = across.length(), distance = apart - a.radius - b.radius;
    if (distance >= threshold || apart < 0.1 * std::min(a.radius, b.radius)) return;
    const btVector3 n = across / apart;
    const btVector3 on_a = on_axis - n * a.radius;
    patch.add({on_a, on_a - n * distance, n, distance, feature});
  };
  add(low, kFirstEnd);
  add(high, kSecondEnd);
}

}  // namespace

void clip_features(const SupportFeature& a, const SupportFeature& b, const btVector3& normal,
                   double threshold, ContactPatch& patch) {
  if (a.kind == Kind::none || b.kind == Kind::none) return;
  if (a.kind == Kind::line && b.kind == Kind::line) {
    lines(a, b, threshold, patch);
    return;
  }
  Axes axes;
  axes.origin = b.points[0];
  axes.n = normal;
  btPlaneSpace1(normal, axes.x, axes.y);
  Adder adder(axes, threshold, patch);
  if (a.kind == Kind::face && b.kind == Kind::face) {
    faces(a, b, axes, adder);
  } else if (a.kind == Kind::line) {
    line_over_face(a, b, 1.0, axes, adder);
  } else {
    line_over_face(b, a, -1.0, axes, adder);
  }
}

}  // namespace cogrsim::bullet
