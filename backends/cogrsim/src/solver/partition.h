// Which components rows couple: the islands.
#pragma once

#include <vector>

#include "solver/rows.h"

namespace cogrsim::dynamics {

/// Components that no row couples are solved independently, each with its own stopping test. Islands are numbered
/// by their first row: joints' come first.
class Partition {
 public:
  /// `joints`: has rows of joints only.
  void find(std::size_t components, const RowSet& joints, const std::vector<Manifold>& manifolds);

  std::size_t size() const { return std::size_t(count_); }
  /// The first component of a component's island, itself if no other is coupled with it.
  int first_of(int component) { return find(component); }
  bool has_rows(int component) { return number_[std::size_t(find(component))] >= 0; }

  /// Indices of things by island, in their order.
  class ByIsland {
   public:
    struct Range {
      const int *first, *last;
      const int* begin() const { return first; }
      const int* end() const { return last; }
    };
    Range of(std::size_t island) const {
      const int begin = island == 0 ? 0 : ends_[island - 1];
      return {items_.data() + begin, items_.data() + ends_[island]};
    }
    /// `island_of(i)`: of thing i of `count`.
    template <class IslandOf>
    void sort(std::size_t count, int islands, const IslandOf& island_of);

   private:
    std::vector<int> items_, ends_;
  };
  ByIsland scalars, balls, manifolds;  ///< indices in RowSet::scalars, RowSet::balls, the manifolds

 private:
  int find(int component);

  int count_ = 0;
  std::vector<int> root_, number_;  ///< by component
};

}  // namespace cogrsim::dynamics
