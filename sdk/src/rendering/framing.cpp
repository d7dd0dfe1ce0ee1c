#include "cogrsim/rendering/framing.h"

#include <algorithm>
#include <array>
#include <vector>

#include "cogrsim/rendering/standard_view.h"

namespace cogrsim {

namespace {

constexpr double kMostSpread = 10.0;  // of what moves, relative to the start
constexpr double kBand = 0.2;         // within this share of the box to its edge it goes along

bool moves(const Body& body) { return body.kind != BodyKind::static_body; }

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// How far an edge of the box goes along, outwards: what moves came `by` nearer to it or farther
/// out, and is `gap` inside of it now, in a box of this size [m].
double share(double by, double gap, double size) {
  if (by <= 0.0) return 0.0;
  const double band = kBand * size;
  if (gap >= band) return 0.0;
  const double x = std::clamp(1.0 - gap / band, 0.0, 1.0);
  return std::min(by, band - gap) * x * x * (3.0 - 2.0 * x);
}

}  // namespace

Framing::Framing(const Frame& start)
    : shown_(visible_bounds(start)),
      start_(shown_.middle()),
      limit_(kMostSpread * shown_.half().norm()) {
  const geometry::Bounds first = moving(start);
  if (!first.empty()) before_ = first;
}

geometry::Bounds Framing::moving(const Frame& frame) const {
  std::vector<geometry::Bounds> boxes;
  std::array<std::vector<double>, 3> places;
  for (int axis = 0; axis < 3; ++axis) places[axis].push_back(start_[axis]);
  for (std::size_t i = 0; i < frame.model->bodies.size(); ++i) {
    if (!moves(frame.model->bodies[i])) continue;
    const geometry::Bounds box = visible_bounds(frame, i);
    if (box.empty()) continue;
    boxes.push_back(box);
    for (int axis = 0; axis < 3; ++axis) places[axis].push_back(box.middle()[axis]);
  }
  geometry::Bounds all;
  for (const geometry::Bounds& box : boxes) all.add(box);
  if (boxes.size() < 2 || all.half().norm() <= limit_) return all;

  const Vec3 middle(median(places[0]), median(places[1]), median(places[2]));
  std::stable_sort(boxes.begin(), boxes.end(), [&](const auto& a, const auto& b) {
    return (a.middle() - middle).squaredNorm() < (b.middle() - middle).squaredNorm();
  });
  all = boxes.front();
  for (const geometry::Bounds& box : boxes) {
    geometry::Bounds with = all;
    with.add(box);
    if (with.half().norm() > limit_) break;
    all = with;
  }
  return all;
}

const geometry::Bounds& Framing::follow(const Frame& frame) {
  const geometry::Bounds now = moving(frame);
  if (now.empty()) return shown_;
  for (int axis = 0; axis < 3; ++axis) {
    double &low = shown_.low[axis], &high = shown_.high[axis];
    if (before_) {
      const double size = high - low;
      const double by = share(now.high[axis] - before_->high[axis], high - now.high[axis], size) -
                        share(before_->low[axis] - now.low[axis], now.low[axis] - low, size);
      low += by;
      high += by;
    }
    const double size = high - low;
    if (now.low[axis] < low) {
      low = now.low[axis];
      high = std::max(low + size, now.high[axis]);
    } else if (now.high[axis] > high) {
      high = now.high[axis];
      low = std::min(high - size, now.low[axis]);
    }
  }
  before_ = now;
  return shown_;
}

geometry::Bounds Framing::single(const Frame& frame) const {
  geometry::Bounds all = moving(frame);
  for (std::size_t i = 0; i < frame.model->bodies.size(); ++i) {
    if (moves(frame.model->bodies[i])) continue;
    geometry::Bounds with = all;
    with.add(visible_bounds(frame, i));
    if (all.empty() || with.half().norm() <= limit_) all = with;
  }
  return all.empty() ? shown_ : all;
}

}  // namespace cogrsim
