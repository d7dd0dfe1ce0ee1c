// Reads the drawing of a maze: characters in, a grid of cells, walls and doors out. Knows nothing of
// sizes, elements or the scene.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cogrsim::dsl {

/// A piece of the drawing: a line of it, counted from 0, and bytes within that line.
struct DrawnAt {
  int line = 0;
  int begin = 0, length = 1;
};

struct DrawingFault {
  std::string code;
  DrawnAt at;
  std::string message, help;
};

/// Rows count from the south (the last line), columns from the west, as in MazeModel.
struct MazeDrawing {
  static constexpr char kOpen = ' ', kWall = '#';  ///< else the letter of a door
  /// More cells than any run could simulate; a larger drawing is refused at once.
  static constexpr int kMaxCells = 16384;

  struct Cell {
    std::string name;
    int row = 0, column = 0;
    DrawnAt at;
  };

  int rows = 0, columns = 0;
  int pitch = 0;                     ///< characters from one corner to the next
  std::vector<char> vertical;        ///< rows x (columns + 1): entry [row][c] is west of column c
  std::vector<char> horizontal;      ///< (rows + 1) x columns: entry [r][column] is south of row r
  std::vector<Cell> cells;           ///< those with a name, in reading order
  std::vector<DrawingFault> faults;  ///< not empty: the rest is not to be used

  char west(int row, int column) const { return vertical[row * (columns + 1) + column]; }
  char south(int row, int column) const { return horizontal[row * columns + column]; }
  /// Where a piece of wall is drawn.
  DrawnAt at_west(int row, int column) const;
  DrawnAt at_south(int row, int column) const;
};

/// `lines`: the drawing's lines from its first to its last, each from the column of the drawing's
/// first character on and without blanks at its end. Any text is answered, in time linear in it.
MazeDrawing read_maze(const std::vector<std::string_view>& lines);

}  // namespace cogrsim::dsl
