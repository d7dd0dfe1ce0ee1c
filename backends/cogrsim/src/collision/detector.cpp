#include "collision/detector.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cogrsim::dynamics {

namespace {

// Half of a shape's least extent along its axes [m].
double thinness_of(const Collider& c) {
  double least = c.bounding_radius;
  for (int k = 0; k < 3 && c.is_convex(); ++k) {
    const Vec3 axis = c.X_WS.R.col(k);
    least = std::min(least, 0.5 * (support_extent(c, axis) + support_extent(c, -axis)));
  }
  return least;
}

}  // namespace

Detector::Detector(const SceneModel& model) : filter_(model), colliders_(make_colliders(model)) {
  sorted_.reserve(colliders_.size());
  std::size_t next = 0;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    first_.push_back(int(next));
    double bounding_radius = 0.0;
    for (std::size_t s = 0; s < model.bodies[b].shapes.size(); ++s, ++next) {
      const Collider& c = colliders_[next];
      if (c.body < 0) continue;
      if (c.type == ShapeType::plane) {
        unbounded_.push_back(int(next));
        bounding_radius = std::max(bounding_radius, 1e-3);
      } else {
        sorted_.push_back({c.X_WS.p, c.X_WS.p, int(next), c.moves});
        bounding_radius = std::max(bounding_radius, c.X_BS.p.norm() + c.bounding_radius);
      }
    }
    bounding_radii_.push_back(bounding_radius);
  }
  first_.push_back(int(next));
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    set_pose(int(b), Placement(model.bodies[b].X_WB), 0.0);
    double least = std::numeric_limits<double>::infinity();
    for (int i = first_[b]; i < first_[b + 1]; ++i) {
      const Collider& c = colliders_[std::size_t(i)];
      if (c.body >= 0) least = std::min(least, thinness_of(c));
    }
    thinness_.push_back(least);
  }
}

void Detector::set_pose(int body, const Placement& X_WB, double margin, const Vec3& shift,
                        const Vec3& turn) {
  for (int i = first_[std::size_t(body)]; i < first_[std::size_t(body) + 1]; ++i) {
    Collider& c = colliders_[std::size_t(i)];
    if (c.body < 0) continue;
    const Placement X_WS = X_WB * c.X_BS;
    if (c.is_convex())
      c.moved += (X_WS.p - c.X_WS.p).norm() + c.bounding_radius * (X_WS.R - c.X_WS.R).norm();
    c.X_WS = X_WS;
    c.margin = margin;
    c.turn = turn;
    c.shift = shift + turn.cross(c.X_WS.p - X_WB.p);
  }
}

void Detector::set_moves(int body, bool moves) {
  for (int i = first_[std::size_t(body)]; i < first_[std::size_t(body) + 1]; ++i)
    colliders_[std::size_t(i)].moves = moves;
}

void Detector::detect(std::vector<ContactPoint>& out, WorkerPool* pool) {
  out.clear();
  find_pairs();
  test_pairs(out, pool);
  for (Collider& c : colliders_) c.moved = 0.0;
}

void Detector::test_pairs(std::vector<ContactPoint>& out, WorkerPool* pool) {
  constexpr std::size_t kWorthWaking = 200, kParts = 16;  // more parts than threads, to balance
  const std::size_t count = pairs_.size();
  if (!pool || count < kWorthWaking) {
    for (std::size_t i = 0; i < count; ++i) test_pair(i, out);
    return;
  }
  parts_.resize(kParts);
  pool->run(kParts, [this, count](std::size_t i) {
    parts_[i].clear();
    for (std::size_t k = count * i / kParts; k < count * (i + 1) / kParts; ++k)
      test_pair(k, parts_[i]);
  });
  for (const auto& part : parts_) out.insert(out.end(), part.begin(), part.end());
}

// Along which the middles of the bounds vary most, as in Ericson, Real-time collision detection, 2005, section 7.5.2.
int Detector::widest_axis() const {
  Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
  for (const Bounds& b : sorted_) {
    const Vec3 middle = b.low + b.high;
    sum += middle;
    squares += middle.cwiseAbs2();
  }
  const double count = std::max(double(sorted_.size()), 1.0);
  int axis = 0;
  (squares - sum.cwiseAbs2() / count).maxCoeff(&axis);
  return axis;
}

// Insertion, because the order is nearly that of the last step; equal bounds fall back on the index, so that it is a
// function of the poses.
void Detector::sort_bounds(int axis) {
  const auto before = [axis](const Bounds& a, const Bounds& b) {
    return a.low[axis] != b.low[axis] ? a.low[axis] < b.low[axis] : a.collider < b.collider;
  };
  if (axis != axis_) std::sort(sorted_.begin(), sorted_.end(), before);
  axis_ = axis;
  for (std::size_t i = 1; i < sorted_.size(); ++i) {
    if (!before(sorted_[i], sorted_[i - 1])) continue;
    const Bounds moved = sorted_[i];
    std::size_t k = i;
    for (; k > 0 && before(moved, sorted_[k - 1]); --k) sorted_[k] = sorted_[k - 1];
    sorted_[k] = moved;
  }
}

// As wide as two bounds are on the average, of which none counts as wider than all middles are apart.
Detector::Strips Detector::cut_strips(int axis) {
  constexpr double kMost = 256.0;
  double low = std::numeric_limits<double>::infinity(), high = -low, extents = 0.0;
  for (const Bounds& b : sorted_) {
    const double middle = 0.5 * (b.low[axis] + b.high[axis]);
    low = std::min(low, middle);
    high = std::max(high, middle);
  }
  for (const Bounds& b : sorted_) extents += std::min(b.high[axis] - b.low[axis], high - low);
  Strips strips;
  const double count = std::min(0.5 * double(sorted_.size()) * (high - low) / extents, kMost);
  if (count > 1.0) strips = {low, count / (high - low), int(count)};
  open_.resize(std::max(open_.size(), std::size_t(strips.last) + 1));
  for (std::vector<int>& open : open_) open.clear();
  return strips;
}

void Detector::find_pairs() {
  pairs_.swap(last_pairs_);
  apart_.swap(last_apart_);
  pairs_.clear();
  for (Bounds& b : sorted_) {
    const Collider& c = colliders_[std::size_t(b.collider)];
    const Vec3 extent = c.half_extents();
    b = {c.X_WS.p - extent, c.X_WS.p + extent, b.collider, c.moves};
  }
  const int axis = widest_axis(), second = (axis + 1) % 3, third = (axis + 2) % 3;
  sort_bounds(axis);
  const Strips strips = cut_strips(second);
  for (int i = 0; i < int(sorted_.size()); ++i) {
    const Bounds& b = sorted_[std::size_t(i)];
    const int first = strips.of(b.low[second]), last = strips.of(b.high[second]);
    for (int strip = first; strip <= last; ++strip) {
      std::vector<int>& open = open_[std::size_t(strip)];
      std::size_t count = 0;
      for (const int k : open) {
        const Bounds& o = sorted_[std::size_t(k)];
        if (o.high[axis] < b.low[axis]) continue;
        open[count++] = k;
        if (!(b.moves || o.moves) || o.high[second] < b.low[second] ||
            b.high[second] < o.low[second] || o.high[third] < b.low[third] ||
            b.high[third] < o.low[third])
          continue;
        // Of the strips that both lie in the first has the pair.
        if (strip > first && strips.of(o.low[second]) < strip) continue;
        pairs_.emplace_back(std::min(b.collider, o.collider), std::max(b.collider, o.collider));
      }
      open.resize(count);
      open.push_back(i);
    }
  }
  for (int p : unbounded_) {
    const Collider& plane = colliders_[std::size_t(p)];
    const Vec3 n = plane.X_WS.R.col(2);
    for (const Bounds& b : sorted_) {
      if (!(b.moves || plane.moves)) continue;
      const Vec3 middle = 0.5 * (b.low + b.high), extent = 0.5 * (b.high - b.low);
      if (n.dot(middle - plane.X_WS.p) - n.cwiseAbs().dot(extent) > plane.margin) continue;
      pairs_.emplace_back(std::min(b.collider, p), std::max(b.collider, p));
    }
  }
  std::sort(pairs_.begin(), pairs_.end());
  apart_.assign(pairs_.size(), {});
  for (std::size_t i = 0, last = 0; i < pairs_.size(); ++i) {
    while (last < last_pairs_.size() && last_pairs_[last] < pairs_[i]) ++last;
    if (last < last_pairs_.size() && last_pairs_[last] == pairs_[i]) apart_[i] = last_apart_[last];
  }
}

void Detector::test_pair(std::size_t pair, std::vector<ContactPoint>& out) {
  const auto [ia, ib] = pairs_[pair];
  const Collider& a = colliders_[std::size_t(ia)];
  const Collider& b = colliders_[std::size_t(ib)];
  if (!filter_.collide(a.body, b.body)) return;
  const double margin = a.margin + b.margin;
  const std::size_t first = out.size();
  bool swapped = false;
  if (a.is_convex() && b.is_convex()) {
    convex_contacts(a, b, margin, apart_[pair], out);
  } else if (a.is_convex() || b.is_convex()) {
    // Planes and meshes come first in their functions.
    swapped = a.is_convex();
    const Collider& fixed_side = swapped ? b : a;
    const Collider& convex = swapped ? a : b;
    if (fixed_side.type == ShapeType::plane)
      plane_contacts(fixed_side, convex, margin, out);
    else
      concave_contacts(fixed_side, convex, margin, out);
  }
  for (std::size_t i = first; i < out.size(); ++i) {
    ContactPoint& c = out[i];
    c.collider_a = ia;
    c.collider_b = ib;
    if (swapped) c.normal = -c.normal;
  }
}

Vec3 Detector::surface_velocity(const ContactPoint& point) const {
  const Collider& a = colliders_[std::size_t(point.collider_a)];
  const Collider& b = colliders_[std::size_t(point.collider_b)];
  if (a.surface_velocity.isZero(0.0) && b.surface_velocity.isZero(0.0)) return Vec3::Zero();
  const Vec3 v = b.X_WS.R * b.surface_velocity - a.X_WS.R * a.surface_velocity;
  return v - v.dot(point.normal) * point.normal;
}

}  // namespace cogrsim::dynamics
