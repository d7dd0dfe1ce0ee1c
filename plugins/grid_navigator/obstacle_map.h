// Which cells of the maze the robot takes to hold an obstacle, by what its range finders say.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"
#include "wheel_driver.h"

namespace grid_navigator {

/// One reading in the maze's frame.
struct Beam {
  double x = 0.0, y = 0.0;  ///< where it starts [m]
  double direction = 0.0;   ///< [rad]
  double distance = 0.0;    ///< free so far [m]
  bool hit = false;         ///< something is there; else it only saw that far
};

/// Every cell has a count of evidence, 0 to kMost. A beam that ends well inside of a cell adds one
/// to it: walls and doors are near the borders only. A beam that goes through the middle of a cell
/// takes one away. A cell is held for blocked from kEnough on, until it is empty again.
class ObstacleMap {
 public:
  static constexpr int kEnough = 2, kMost = 4;

  ObstacleMap() = default;
  /// Keeps the plan's measures. Precondition: maze outlives the call only.
  explicit ObstacleMap(const cogrsim::MazeModel& maze);

  /// Cells that changed, free to blocked or back. `own`: where the robot is; no obstacle is there.
  std::vector<Cell> see(const Beam& beam, const Cell& own);
  bool blocked(const Cell& cell) const;
  /// Everything is held for free again.
  void forget();
  /// Cells held for blocked.
  int count() const;

  std::vector<int> evidence() const { return evidence_; }
  /// Precondition: as many as evidence() gave.
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
