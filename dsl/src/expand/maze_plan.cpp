#include "expand/maze_plan.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace cogrsim::dsl {
namespace {

// Air between a closed door and the posts beside it: it must not rub, and nothing fits through.
constexpr double kDoorGap = 1e-3;  // [m]

/// The pieces of wall around a corner of the grid.
struct Corner {
  bool west = false, east = false, south = false, north = false;
  bool through_x() const { return west && east; }
  bool through_y() const { return south && north; }
};

/// A drawing with bounds: outside of it nothing is drawn.
struct Grid {
  const MazeDrawing& drawing;

  // The piece from corner (row, column) to the east, to the north.
  char east(int row, int column) const {
    if (column < 0 || column >= drawing.columns) return MazeDrawing::kOpen;
    return drawing.south(row, column);
  }
  char north(int row, int column) const {
    if (row < 0 || row >= drawing.rows) return MazeDrawing::kOpen;
    return drawing.west(row, column);
  }
  bool wall_east(int row, int column) const { return east(row, column) == MazeDrawing::kWall; }
  bool wall_north(int row, int column) const { return north(row, column) == MazeDrawing::kWall; }
  Corner corner(int row, int column) const {
    return {wall_east(row, column - 1), wall_east(row, column), wall_north(row - 1, column),
            wall_north(row, column)};
  }
};

}  // namespace

std::vector<WallRun> wall_runs(const MazeDrawing& drawing, const MazeSizes& sizes) {
  const Grid grid{drawing};
  const double cell = sizes.cell, half = 0.5 * sizes.thickness;
  std::vector<WallRun> out;
  for (int row = drawing.rows; row >= 0; --row)
    for (int column = 0; column < drawing.columns; ++column) {
      if (!grid.wall_east(row, column)) continue;
      const int first = column;
      while (grid.wall_east(row, column + 1)) ++column;
      const auto end = [&](int c) { return grid.corner(row, c).through_y() ? -half : half; };
      out.push_back({{first * cell - end(first), (column + 1) * cell + end(column + 1),
                      row * cell - half, row * cell + half},
                     drawing.at_south(row, first)});
    }
  for (int column = 0; column <= drawing.columns; ++column)
    for (int row = 0; row < drawing.rows; ++row) {
      if (!grid.wall_north(row, column)) continue;
      const int first = row;
      const auto goes_on = [&](int r) {
        return grid.wall_north(r, column) && !grid.corner(r, column).through_x();
      };
      while (goes_on(row + 1)) ++row;
      const auto end = [&](int r) {
        const Corner c = grid.corner(r, column);
        // A run along x that ends here has the post, unless this one goes through.
        const bool taken = c.through_x() || ((c.west || c.east) && !c.through_y());
        return taken ? -half : half;
      };
      out.push_back({{column * cell - half, column * cell + half, first * cell - end(first),
                      (row + 1) * cell + end(row + 1)},
                     drawing.at_west(row, column)});
    }
  return out;
}

namespace {

/// Neighbouring pieces of one letter in a line: one panel.
struct Panel {
  bool along_x = true;
  int row = 0, column = 0;  // its first corner
  int length = 0;           // [cells]
  DrawnAt at;
};

class Doors {
 public:
  Doors(const MazeDrawing& drawing, const MazeSizes& sizes, DoorDirection direction,
        std::vector<DrawingFault>& faults)
      : drawing_(drawing), grid_{drawing}, sizes_(sizes), direction_(direction), faults_(faults) {}

  std::vector<DoorRun> find() {
    collect();
    std::vector<DoorRun> out;
    for (const auto& [letter, panels] : panels_) {
      DoorRun door;
      door.letter = letter;
      door.at = panels.front().at;
      door.along_x = panels.front().along_x;
      if (direction_ == DoorDirection::side && !slide(letter, panels, door)) continue;
      for (const Panel& panel : panels) {
        door.panels.push_back(box(panel));
        FloorBox swept = door.panels.back();
        (panel.along_x ? (door.travel < 0 ? swept.x0 : swept.x1)
                       : (door.travel < 0 ? swept.y0 : swept.y1)) += door.travel;
        // Walls that it only just touches block it, too.
        door.swept.push_back({swept.x0 - 2 * kDoorGap, swept.x1 + 2 * kDoorGap,
                              swept.y0 - 2 * kDoorGap, swept.y1 + 2 * kDoorGap});
      }
      out.push_back(std::move(door));
    }
    return out;
  }

 private:
  static bool is_door(char c) { return c != MazeDrawing::kOpen && c != MazeDrawing::kWall; }

  void collect() {
    for (int row = drawing_.rows; row >= 0; --row)
      for (int column = 0; column < drawing_.columns; ++column) {
        const char c = grid_.east(row, column);
        if (!is_door(c)) continue;
        const int first = column;
        while (grid_.east(row, column + 1) == c) ++column;
        panels_[c].push_back({true, row, first, column - first + 1, drawing_.at_south(row, first)});
      }
    for (int column = 0; column <= drawing_.columns; ++column)
      for (int row = 0; row < drawing_.rows; ++row) {
        const char c = grid_.north(row, column);
        if (!is_door(c)) continue;
        const int first = row;
        while (grid_.north(row + 1, column) == c) ++row;
        panels_[c].push_back(
            {false, first, column, row - first + 1, drawing_.at_west(row, column)});
      }
  }

  FloorBox box(const Panel& panel) const {
    const double begin = 0.5 * sizes_.thickness + kDoorGap;
    const double end = panel.length * sizes_.cell - begin, half = 0.5 * sizes_.door_thickness;
    const double x = panel.column * sizes_.cell, y = panel.row * sizes_.cell;
    if (panel.along_x) return {x + begin, x + end, y - half, y + half};
    return {x - half, x + half, y + begin, y + end};
  }

  // `cells` pieces of wall beside the panel that hide it.
  bool within_limits(const Panel& panel, int cells, bool ahead) const {
    for (int i = 0; i < cells; ++i) {
      const int step = ahead ? panel.length + i : -1 - i;
      const bool wall = panel.along_x ? grid_.wall_east(panel.row, panel.column + step)
                                      : grid_.wall_north(panel.row + step, panel.column);
      if (!wall) return false;
    }
    return true;
  }

  bool slide(char letter, const std::vector<Panel>& panels, DoorRun& door) const {
    const std::string name = "door '" + std::string(1, letter) + "'";
    const auto other = std::find_if(panels.begin(), panels.end(), [&](const Panel& p) {
      return p.along_x != panels.front().along_x;
    });
    if (other != panels.end()) {
      faults_.push_back(
          {"CG0326", other->at,
           name + " is drawn in walls of both directions and cannot slide in both",
           "give one of them another letter, or let it open upwards: door-direction=\"up\""});
      return false;
    }
    int cells = 0;
    for (const Panel& panel : panels) cells = std::max(cells, panel.length);
    const auto stuck = [&](bool ahead) {
      return std::find_if(panels.begin(), panels.end(),
                          [&](const Panel& p) { return !within_limits(p, cells, ahead); });
    };
    const bool ahead = stuck(true) == panels.end();
    if (!ahead && stuck(false) != panels.end()) {
      const std::string need =
          cells == 1 ? "a piece of wall" : std::to_string(cells) + " pieces of wall in a line";
      faults_.push_back(
          {"CG0326", stuck(true)->at,
           name + " has no wall beside it to slide into" +
               (panels.size() > 1 ? ", in the same direction for all its panels" : ""),
           "it needs " + need +
               (panels.front().along_x ? " to its east or west" : " to its north or south") +
               "; or let it open upwards: door-direction=\"up\""});
      return false;
    }
    // Its rear end stops inside the post.
    door.travel = (ahead ? 1 : -1) * (cells * sizes_.cell - sizes_.thickness);
    return true;
  }

  const MazeDrawing& drawing_;
  Grid grid_;
  const MazeSizes& sizes_;
  DoorDirection direction_;
  std::vector<DrawingFault>& faults_;
  std::map<char, std::vector<Panel>> panels_;
};

}  // namespace

std::vector<DoorRun> door_runs(const MazeDrawing& drawing, const MazeSizes& sizes,
                               DoorDirection direction, std::vector<DrawingFault>& faults) {
  return Doors(drawing, sizes, direction, faults).find();
}

std::vector<char> reachable(const MazeDrawing& drawing, int row, int column) {
  const auto index = [&](int r, int c) {
    return static_cast<std::size_t>(r * drawing.columns + c);
  };
  std::vector<char> seen(index(drawing.rows, 0), 0);
  std::vector<std::pair<int, int>> open{{row, column}};
  seen[index(row, column)] = 1;
  for (std::size_t i = 0; i < open.size(); ++i) {
    const auto [r, c] = open[i];
    const auto go = [&](char wall, int to_row, int to_column) {
      if (wall == MazeDrawing::kWall || to_row < 0 || to_row >= drawing.rows || to_column < 0 ||
          to_column >= drawing.columns || seen[index(to_row, to_column)] != 0)
        return;
      seen[index(to_row, to_column)] = 1;
      open.push_back({to_row, to_column});
    };
    go(drawing.west(r, c), r, c - 1);
    go(drawing.west(r, c + 1), r, c + 1);
    go(drawing.south(r, c), r - 1, c);
    go(drawing.south(r + 1, c), r + 1, c);
  }
  return seen;
}

}  // namespace cogrsim::dsl
