// Map of the cells of the maze that contain obstacles according to the range finders.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"
#include "wheel_driver.h"

namespace grid_navigator {

/// One reading of a range finder in the maze frame.
struct Beam {
  double x = 0.0, y = 0.0;  ///< origin [m]
  double direction = 0.0;   ///< [rad]
  double distance = 0.0;    ///< free distance [m]
  bool hit = false;         ///< an obstacle is at the end; false: the end of the range
};

/// Every cell has a count of evidence from 0 to kMost. A beam that ends well inside a cell
/// increments it, because walls and doors are only near the borders. A beam through the centre of a
/// cell decrements it. A cell is blocked from kEnough on until the count is 0 again.
class ObstacleMap {
 public:
  static constexpr int kEnough = 2, kMost = 4;

  ObstacleMap() = default;
  /// Copies the dimensions of the maze, which need not outlive the call.
  explicit ObstacleMap(const cogrsim::MazeModel& maze);

  /// Processes a beam and returns the cells that became blocked or free. `own` is the cell of the
  /// robot,
/// which has no obstacle.
  std::vector<Cell> see(const Beam& beam, const Cell& own);
  bool blocked(const Cell& cell) const;
  /// Marks all cells as free.
  void forget();
  /// The blocked cells.
  int count() const;

  std::vector<int> evidence() const { return evidence_; }
  /// Restores the output of evidence(). Precondition: the number of entries is the same.
  void set_evidence(std::vector<int> evidence);

 private:
  std::size_t index(const Cell& cell) const {
    return static_cast<std::size_t>(cell.row * columns_ + cell.column);
  }
  void change(const Cell& cell, int by, std::vector<Cell>& changed);

  int rows_ = 0, columns_ = 0;
  double cell_ = 1.0;          // [m]
  std::vector<int> evidence_;  // (rows x columns)
  std::vector<char> blocked_;  // (rows x columns)
};

}  // namespace grid_navigator
