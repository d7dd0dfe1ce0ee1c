#include "sightings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cogrsim/core/constants.h"

namespace box_carrier {

namespace {

using cogrsim::kPi;

/// Sightings within this distance belong to the same box [m].
constexpr double kSame = 0.10;
/// Number of points needed to determine the yaw of a box.
constexpr std::size_t kShape = 7;
/// A box is removed after this number of scans whose rays passed through it.
constexpr int kGone = 8;
/// A ray that passes this far beyond the centre of a box shows that the box is gone [m].
constexpr double kBehind = 0.03;
/// A neighbouring ray that ends nearer by this distance may hide a part of the cluster [m].
constexpr double kNearer = 0.05;
/// Largest distance between neighbouring points of one box, except on oblique faces [m].
constexpr double kGap = 0.07;
/// Margin to the walls for errors by noise and the motion of the robot [m].
constexpr double kWalls = 0.05;

PlanarPoint ray_end(const Scan& scan, std::size_t i) {
  const double direction = scan.sensor.heading + scan.bearings[i];
  return {scan.sensor.x + scan.ranges[i] * std::cos(direction),
          scan.sensor.y + scan.ranges[i] * std::sin(direction)};
}

PlanarPoint mean(const std::vector<PlanarPoint>& points) {
  PlanarPoint sum;
  for (const PlanarPoint& p : points) {
    sum.x += p.x;
    sum.y += p.y;
  }
  const double n = static_cast<double>(points.size());
  return {sum.x / n, sum.y / n};
}

/// Moves a point away from the sensor.
PlanarPoint beyond(const PlanarPoint& p, const PlanarPoint& eye, double by) {
  const double d = std::max(1e-6, distance(p, eye));
  return {p.x + by * (p.x - eye.x) / d, p.y + by * (p.y - eye.y) / d};
}

}  // namespace

bool Rectangle::contains(const PlanarPoint& p, double margin) const {
  return p.x >= west + margin && p.x <= east - margin && p.y >= south + margin &&
         p.y <= north - margin;
}

double distance(const PlanarPoint& a, const PlanarPoint& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

std::vector<Cluster> clusters_of(const Scan& scan, const Rectangle& arena, double margin,
                                 double gap) {
  std::vector<Cluster> out;
  const std::size_t n = scan.ranges.size();
  if (n < 2) return out;
  const double spacing = std::abs(scan.bearings[1] - scan.bearings[0]);
  // A missing ray, or one that ends nearer than its neighbour, may hide an object.
  const auto hides = [&](std::size_t which, double range) {
    return std::isnan(scan.ranges[which]) || scan.ranges[which] < range - kNearer;
  };
  bool open = false;
  std::optional<std::size_t> first_of_first;
  for (std::size_t i = 0; i < n; ++i) {
    const PlanarPoint end = ray_end(scan, i);
    if (!std::isfinite(scan.ranges[i]) || !arena.contains(end, margin)) {
      if (open) out.back().hidden |= hides(i, scan.ranges[i - 1]);
      open = false;
      continue;
    }
    const double reach = std::max(gap, 2.5 * spacing * scan.ranges[i]);
    if (!open || distance(out.back().points.back(), end) > reach) {
      if (open) out.back().hidden |= hides(i, scan.ranges[i - 1]);
      out.emplace_back();
      out.back().hidden = hides((i + n - 1) % n, scan.ranges[i]);
      if (out.size() == 1) first_of_first = i;
    }
    out.back().points.push_back(end);
    open = true;
  }
  // The last and the first ray are neighbours.
  const bool whole_turn = spacing * static_cast<double>(n) > 2 * kPi - 1.5 * spacing;
  if (whole_turn && open && out.size() > 1 && first_of_first == std::size_t{0} &&
      distance(out.back().points.back(), out.front().points.front()) <= gap) {
    auto& last = out.back().points;
    last.insert(last.end(), out.front().points.begin(), out.front().points.end());
    out.front().points = std::move(last);
    out.front().hidden = out.front().hidden || out.back().hidden;
    out.pop_back();
  }
  return out;
}

PlanarPoint tower_of(const Cluster& cluster, const PlanarPoint& eye, double radius) {
  return beyond(mean(cluster.points), eye, 2 * radius / kPi);
}

std::optional<Box> box_of(const Cluster& cluster, const PlanarPoint& eye, double side) {
  const auto& points = cluster.points;
  if (points.empty()) return std::nullopt;
  // Noise enlarges it by some millimetres; a larger object is not a box.
  if (distance(points.front(), points.back()) > 1.2 * std::sqrt(2.0) * side) return std::nullopt;

  Box box;
  if (points.size() < kShape) {
    box.centre = beyond(mean(points), eye, 0.5 * side);
    return box;
  }
  constexpr int kYaws = 45;
  double best = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kYaws; ++k) {
    const double yaw = 0.5 * kPi * k / kYaws;
    // u and v: coordinates along the two normals towards the sensor, so that the visible faces are
    // those with the largest coordinates.
    double ux = std::cos(yaw), uy = std::sin(yaw), vx = -uy, vy = ux;
    const PlanarPoint middle = mean(points);
    if (ux * (eye.x - middle.x) + uy * (eye.y - middle.y) < 0.0) ux = -ux, uy = -uy;
    if (vx * (eye.x - middle.x) + vy * (eye.y - middle.y) < 0.0) vx = -vx, vy = -vy;
    double high_u = -1e9, high_v = -1e9, low_u = 1e9, low_v = 1e9;
    for (const PlanarPoint& p : points) {
      const double u = ux * p.x + uy * p.y, v = vx * p.x + vy * p.y;
      high_u = std::max(high_u, u), low_u = std::min(low_u, u);
      high_v = std::max(high_v, v), low_v = std::min(low_v, v);
    }
    double error = 0.0;
    for (const PlanarPoint& p : points) {
      const double off = std::min(high_u - (ux * p.x + uy * p.y), high_v - (vx * p.x + vy * p.y));
      error += off * off;
    }
    // A box of this size has no larger extent along its normals.
    const double excess =
        std::max(0.0, high_u - low_u - side) + std::max(0.0, high_v - low_v - side);
    error += static_cast<double>(points.size()) * excess * excess;
    if (error >= best) continue;
    best = error;
    // Along the face of larger extent the centre is known; across, it is half a side behind the
    // face.
    double u = high_u - side / 2, v = high_v - side / 2;
    (high_u - low_u > high_v - low_v ? u : v) =
        high_u - low_u > high_v - low_v ? (high_u + low_u) / 2 : (high_v + low_v) / 2;
    box.centre = {ux * u + vx * v, uy * u + vy * v};
    box.yaw = yaw;
    box.shape_known = true;
  }
  return box;
}

bool BoxMemory::looked_through(const Scan& scan, const PlanarPoint& position) const {
  const double dx = position.x - scan.sensor.x, dy = position.y - scan.sensor.y;
  const double range = std::hypot(dx, dy);
  const double wanted = std::atan2(dy, dx) - scan.sensor.heading;
  double least = std::numeric_limits<double>::infinity();
  std::size_t ray = 0;
  for (std::size_t i = 0; i < scan.bearings.size(); ++i) {
    const double off = std::abs(cogrsim::wrapped_angle(scan.bearings[i] - wanted));
    if (off < least) least = off, ray = i;
  }
  const double spacing =
      scan.bearings.size() > 1 ? std::abs(scan.bearings[1] - scan.bearings[0]) : 0.1;
  return least <= spacing && scan.ranges[ray] > range + kBehind;
}

void BoxMemory::see(const Scan& scan, const Rectangle& arena,
                    const std::vector<PlanarPoint>& masked, double masked_radius) {
  const PlanarPoint eye = position_of(scan.sensor);
  std::vector<char> met(boxes_.size(), 0);
  for (const Cluster& cluster : clusters_of(scan, arena, kWalls, kGap)) {
    if (cluster.hidden || cluster.points.size() < 2) continue;
    const auto box = box_of(cluster, eye, side_);
    if (!box) continue;
    if (std::any_of(masked.begin(), masked.end(), [&](const PlanarPoint& m) {
          return distance(m, box->centre) < masked_radius;
        })) {
      continue;
    }
    const double range = distance(eye, box->centre);
    std::size_t nearest = boxes_.size();
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      const double d = distance(boxes_[i].box.centre, box->centre);
      if (d < kSame &&
          (nearest == boxes_.size() || d < distance(boxes_[nearest].box.centre, box->centre))) {
        nearest = i;
      }
    }
    if (nearest == boxes_.size()) {
      boxes_.push_back({*box, 1, 0, range});
      met.push_back(1);
      continue;
    }
    Known& known = boxes_[nearest];
    met[nearest] = 1;
    ++known.seen;
    known.missed = 0;
    known.nearest = std::min(known.nearest, range);
    const double trust = box->shape_known ? 0.4 : 0.1;
    known.box.centre.x += trust * (box->centre.x - known.box.centre.x);
    known.box.centre.y += trust * (box->centre.y - known.box.centre.y);
    if (box->shape_known) {
      known.box.yaw = box->yaw;
      known.box.shape_known = true;
    }
  }
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    if (!met[i] && looked_through(scan, boxes_[i].box.centre)) ++boxes_[i].missed;
  }
  boxes_.erase(std::remove_if(boxes_.begin(), boxes_.end(),
                              [](const Known& k) { return k.missed >= kGone; }),
               boxes_.end());
}

void BoxMemory::forget(const PlanarPoint& at, double radius) {
  boxes_.erase(std::remove_if(boxes_.begin(), boxes_.end(),
                              [&](const Known& k) { return distance(k.box.centre, at) < radius; }),
               boxes_.end());
}

}  // namespace box_carrier
