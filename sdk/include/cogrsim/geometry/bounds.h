// Boxes along the axes around things, and a tree of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/export.h"
#include "cogrsim/core/types.h"

namespace cogrsim::geometry {

/// [m], in whatever frame its user says.
struct Bounds {
  Vec3 low = Vec3::Constant(kInfinity), high = Vec3::Constant(-kInfinity);  ///< as made: empty

  bool empty() const { return !(low.array() <= high.array()).all(); }
  Vec3 middle() const { return 0.5 * (low + high); }
  Vec3 half() const { return 0.5 * (high - low); }
  /// Number i of the 8: bit k of i chooses the high end of axis k.
  Vec3 corner(int i) const {
    return {(i & 1) != 0 ? high.x() : low.x(), (i & 2) != 0 ? high.y() : low.y(),
            (i & 4) != 0 ? high.z() : low.z()};
  }

  void add(const Vec3& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  void add(const Bounds& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  /// More than `gap` between the two along one of the axes.
  bool disjoint(const Bounds& other, double gap = 0.0) const {
    return (low.array() > other.high.array() + gap || high.array() < other.low.array() - gap).any();
  }
};

/// Around a box that is not empty, carried to the frame in which its own has the pose `X`.
inline Bounds carried(const Bounds& box, const Pose& X) {
  const Vec3 middle = X * box.middle();
  const Vec3 half = X.q.toRotationMatrix().cwiseAbs() * box.half();
  return {middle - half, middle + half};
}

/// A binary tree over boxes, halved at the median of the longest side. Once made it may be read by
/// several threads at once.
class COGRSIM_API BoundsTree {
 public:
  struct Node {
    Bounds bounds;
    std::size_t first = 0, count = 0;  ///< of a leaf: entries of order(); else its two children
    bool leaf = false;
  };

  BoundsTree() = default;
  explicit BoundsTree(const std::vector<Bounds>& boxes);

  /// The root comes first; none where there is no box.
  const std::vector<Node>& nodes() const { return nodes_; }
  /// The boxes' numbers as leaves hold them.
  const std::vector<std::size_t>& order() const { return order_; }

  /// Calls use(number of the box) for each box of a leaf whose bounds meet `where`, until it answers
  /// false.
  template <class Use>
  void visit(const Bounds& where, const Use& use) const {
    std::vector<std::size_t> open;
    if (!nodes_.empty()) open.push_back(0);
    while (!open.empty()) {
      const Node& node = nodes_[open.back()];
      open.pop_back();
      if (node.bounds.disjoint(where)) continue;
      if (!node.leaf) {
        open.push_back(node.count);
        open.push_back(node.first);
        continue;
      }
      for (std::size_t i = node.first; i < node.first + node.count; ++i)
        if (!use(order_[i])) return;
    }
  }

 private:
  std::size_t add(const std::vector<Bounds>& boxes, std::size_t begin, std::size_t end);

  std::vector<Node> nodes_;
  std::vector<std::size_t> order_;
};

}  // namespace cogrsim::geometry
