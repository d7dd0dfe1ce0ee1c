#include "solver/partition.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace cogrsim::dynamics {
namespace {

// A component of a manifold that yields.
int component_of(const Manifold& m) { return m.component[0] >= 0 ? m.component[0] : m.component[1]; }

}  // namespace

int Partition::find(int i) {
  while (root_[std::size_t(i)] != i) {
    root_[std::size_t(i)] = root_[std::size_t(root_[std::size_t(i)])];
    i = root_[std::size_t(i)];
  }
  return i;
}

template <class IslandOf>
void Partition::ByIsland::sort(std::size_t count, int islands, const IslandOf& island_of) {
  ends_.assign(std::size_t(islands), 0);
  for (std::size_t i = 0; i < count; ++i) ++ends_[island_of(i)];
  int sum = 0;  // now the beginnings, which the items move to the ends
  for (int& end : ends_) sum += std::exchange(end, sum);
  items_.resize(count);
  for (std::size_t i = 0; i < count; ++i) items_[std::size_t(ends_[island_of(i)]++)] = int(i);
}

void Partition::find(std::size_t components, const RowSet& joints,
                     const std::vector<Manifold>& all) {
  root_.resize(components);
  std::iota(root_.begin(), root_.end(), 0);
  for (const Manifold& m : all) {
    if (m.component[0] < 0 || m.component[1] < 0) continue;
    const int a = find(m.component[0]), b = find(m.component[1]);
    root_[std::size_t(std::max(a, b))] = std::min(a, b);
  }
  number_.assign(components, -1);
  count_ = 0;
  const auto count = [&](int component) {
    int& number = number_[std::size_t(find(component))];
    if (number < 0) number = count_++;
  };
  for (const Row& row : joints.rows) count(row.component[0]);
  for (const Manifold& m : all) count(component_of(m));
  const auto island_of = [&](int component) {
    return std::size_t(number_[std::size_t(find(component))]);
  };
  const auto of_row = [&](int row) { return island_of(joints.rows[std::size_t(row)].component[0]); };
  scalars.sort(joints.scalars.size(), count_,
               [&](std::size_t i) { return of_row(joints.scalars[i]); });
  balls.sort(joints.balls.size(), count_,
             [&](std::size_t i) { return of_row(joints.balls[i].first); });
  manifolds.sort(all.size(), count_, [&](std::size_t i) { return island_of(component_of(all[i])); });
}

}  // namespace cogrsim::dynamics
