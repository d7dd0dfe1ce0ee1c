// From the grid of a maze to boxes: walls merged into long ones, doors with space to slide.
#pragma once

#include <string>
#include <vector>

#include "expand/maze_drawing.h"

namespace cogrsim::dsl {

/// A rectangle on the floor, in the maze's frame [m].
struct FloorBox {
  double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  bool meets(const FloorBox& o) const { return x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1; }
};

struct MazeSizes {
  double cell = 1.0, thickness = 0.1, height = 0.3;  ///< of the walls [m]
  double door_thickness = 0.05;                      ///< [m] < thickness
};

/// A straight piece of wall, as long as it can be.
struct WallRun {
  FloorBox box;
  DrawnAt at;  ///< its first piece
};

enum class DoorDirection { side, up, down };

/// All pieces of one letter: they are one body and open together.
struct DoorRun {
  char letter = 'A';
  std::vector<FloorBox> panels;  ///< where they stand when closed
  std::vector<FloorBox> swept;   ///< all that they pass over
  bool along_x = true;           ///< of a door that slides: else along y
  double travel = 0.0;           ///< [m] < 0 towards -x or -y; of up and down: 0
  DrawnAt at;                    ///< its first piece
};

/// The boxes cover exactly the drawn walls with their corner posts: each straight run is one box, and
/// no two overlap. A post belongs to what runs through it, else to the run east and west; what ends
/// at a post that is another's stops at its face. So no flat face of a wall has a seam in it.
std::vector<WallRun> wall_runs(const MazeDrawing& drawing, const MazeSizes& sizes);

/// One entry per letter, sorted. A door slides into the walls beside it, all its panels in the same
/// direction, east or north if possible; faults (CG0326) if there is no such wall.
std::vector<DoorRun> door_runs(const MazeDrawing& drawing, const MazeSizes& sizes,
                               DoorDirection direction, std::vector<DrawingFault>& faults);

/// Cells that can be reached from one, doors counting as passable: rows x columns, 1: yes.
std::vector<char> reachable(const MazeDrawing& drawing, int row, int column);

}  // namespace cogrsim::dsl
