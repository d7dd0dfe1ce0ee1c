#include "cogrsim/geometry/bounds.h"

#include <numeric>

namespace cogrsim::geometry {
namespace {

constexpr std::size_t kLeaf = 4;  // boxes in a leaf

}  // namespace

BoundsTree::BoundsTree(const std::vector<Bounds>& boxes) : order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  if (!boxes.empty()) add(boxes, 0, boxes.size());
}

std::size_t BoundsTree::add(const std::vector<Bounds>& boxes, std::size_t begin, std::size_t end) {
  const std::size_t index = nodes_.size();
  nodes_.emplace_back();
  Node node;
  for (std::size_t i = begin; i < end; ++i) node.bounds.add(boxes[order_[i]]);
  node.leaf = end - begin <= kLeaf;
  node.first = begin;
  node.count = end - begin;
  if (!node.leaf) {
    Eigen::Index axis = 0;
    (node.bounds.high - node.bounds.low).maxCoeff(&axis);
    const std::size_t middle = (begin + end) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::size_t a, std::size_t b) {
      return boxes[a].low[axis] + boxes[a].high[axis] < boxes[b].low[axis] + boxes[b].high[axis];
    });
    node.first = add(boxes, begin, middle);
    node.count = add(boxes, middle, end);
  }
  nodes_[index] = node;
  return index;
}

}  // namespace cogrsim::geometry
