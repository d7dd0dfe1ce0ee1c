#include "obstacle_map.h"

#include <algorithm>
#include <cmath>

namespace grid_navigator {

namespace {

// Fraction of a cell. A beam that ends nearer than this to a border may have hit a wall: half its
// thickness, and the noise of range finder and heading.
constexpr double kBorder = 0.13;
// A beam this close to the centre of a cell would have hit an obstacle that fills most of the cell.
constexpr double kMiddle = 0.08;
// Distance beyond the centre that the beam must have passed.
constexpr double kBeyond = 0.3;

}  // namespace

ObstacleMap::ObstacleMap(const cogrsim::MazeModel& maze)
    : rows_(maze.rows), columns_(maze.columns), cell_(maze.cell) {
  forget();
}

void ObstacleMap::forget() {
  const auto cells = static_cast<std::size_t>(rows_ * columns_);
  evidence_.assign(cells, 0);
  blocked_.assign(cells, 0);
}

bool ObstacleMap::blocked(const Cell& cell) const { return blocked_[index(cell)] != 0; }

int ObstacleMap::count() const {
  return static_cast<int>(std::count(blocked_.begin(), blocked_.end(), 1));
}

void ObstacleMap::set_evidence(std::vector<int> evidence) {
  evidence_ = std::move(evidence);
  for (std::size_t i = 0; i < evidence_.size(); ++i) blocked_[i] = evidence_[i] >= kEnough;
}

void ObstacleMap::change(const Cell& cell, int by, std::vector<Cell>& changed) {
  const std::size_t i = index(cell);
  evidence_[i] = std::clamp(evidence_[i] + by, 0, kMost);
  const char now = evidence_[i] >= kEnough || (blocked_[i] != 0 && evidence_[i] > 0) ? 1 : 0;
  if (now != blocked_[i]) changed.push_back(cell);
  blocked_[i] = now;
}

std::vector<Cell> ObstacleMap::see(const Beam& beam, const Cell& own) {
  std::vector<Cell> changed;
  const double c = std::cos(beam.direction), s = std::sin(beam.direction);
  if (beam.hit) {
    const double x = (beam.x + beam.distance * c) / cell_;
    const double y = (beam.y + beam.distance * s) / cell_;
    const Cell cell{static_cast<int>(std::floor(y)), static_cast<int>(std::floor(x))};
    const double inside =
        std::min({x - cell.column, cell.column + 1 - x, y - cell.row, cell.row + 1 - y});
    const bool known =
        cell.row >= 0 && cell.row < rows_ && cell.column >= 0 && cell.column < columns_;
    if (known && inside > kBorder && cell != own) change(cell, 1, changed);
  }
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const Cell cell{row, column};
      if (evidence_[index(cell)] == 0) continue;
      const double dx = (column + 0.5) * cell_ - beam.x, dy = (row + 0.5) * cell_ - beam.y;
      const double along = c * dx + s * dy, aside = std::abs(s * dx - c * dy);
      if (along > 0 && aside < kMiddle * cell_ && beam.distance > along + kBeyond * cell_) {
        change(cell, -1, changed);
      }
    }
  }
  return changed;
}

}  // namespace grid_navigator
