#include "expand/maze_drawing.h"

#include <algorithm>
#include <map>

#include "syntax/xml_scan.h"

namespace cogrsim::dsl {
namespace {

// Number of faults that are reported for one drawing; more would repeat the same one.
constexpr std::size_t kMaxFaults = 5;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_word(char c) { return is_letter(c) || c == '_' || (c >= '0' && c <= '9'); }

/// How a character is written in a message.
std::string shown(char c) {
  if (c == '\t') return "a tab";
  if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F)
    return "a character";
  return std::string("'") + c + "'";
}

/// r0c0: the name of every cell in addition to its own.
bool is_cell_number(std::string_view name) {
  std::size_t i = 1;
  const auto digits = [&] {
    const std::size_t begin = i;
    while (i < name.size() && name[i] >= '0' && name[i] <= '9') ++i;
    return i > begin;
  };
  if (name.empty() || name[0] != 'r' || !digits() || i >= name.size() || name[i] != 'c')
    return false;
  ++i;
  return digits() && i == name.size();
}

class DrawingReader {
 public:
  explicit DrawingReader(const std::vector<std::string_view>& lines) : lines_(lines) {}

  MazeDrawing read() {
    if (lines_.empty()) {
      fault("CG0320", {}, "the maze has no drawing", "draw its walls with the characters + - |");
      return std::move(out_);
    }
    if (!tabs() || !plain() || !first_line() || !outline()) return std::move(out_);
    const auto n = static_cast<std::size_t>(out_.rows), m = static_cast<std::size_t>(out_.columns);
    out_.vertical.assign(n * (m + 1), MazeDrawing::kOpen);
    out_.horizontal.assign((n + 1) * m, MazeDrawing::kOpen);
    for (int line = 0; line < static_cast<int>(lines_.size()); ++line) {
      if (enough()) break;
      if (line % 2 == 0)
        corners(line);
      else
        cells(line);
    }
    return std::move(out_);
  }

 private:
  void fault(const char* code, DrawnAt at, std::string message, std::string help = {}) {
    out_.faults.push_back({code, at, std::move(message), std::move(help)});
  }
  bool enough() const { return out_.faults.size() >= kMaxFaults; }

  std::string_view line(int index) const { return lines_[index]; }

  // A tab is as wide as an editor likes.
  bool tabs() {
    for (int i = 0; i < static_cast<int>(lines_.size()); ++i) {
      const std::size_t tab = line(i).find('\t');
      if (tab == std::string_view::npos) continue;
      fault("CG0322", {i, static_cast<int>(tab), 1}, "a tab in the drawing of a maze",
            "indent and draw with blanks: the width of a tab is not defined");
      return false;
    }
    return true;
  }

  // Columns are counted in bytes from here on.
  bool plain() {
    for (int i = 0; i < static_cast<int>(lines_.size()); ++i) {
      const auto foreign = std::find_if(line(i).begin(), line(i).end(), [](char c) {
        return static_cast<unsigned char>(c) >= 0x80;
      });
      if (foreign == line(i).end()) continue;
      const auto at = static_cast<std::size_t>(foreign - line(i).begin());
      const auto bytes = static_cast<std::size_t>(std::max(1, decode_utf8(line(i), at).length));
      const std::string_view character = line(i).substr(at, bytes);
      fault("CG0322", {i, static_cast<int>(at), 1},
            (character == "\u00A0" ? "a no-break space" : "'" + std::string(character) + "'") +
                " in the drawing of a maze",
            "walls are drawn with + - |, openings are blanks, and names are made of the letters a "
            "to z and A to Z, digits and _");
      return false;
    }
    return true;
  }

  bool first_line() {
    const std::string_view first = line(0);
    if (first[0] != '+') {
      fault("CG0323", {0, 0, 1},
            "a maze begins with the corner '+' of its outer wall, found " + shown(first[0]),
            "the first line looks like +--+--+--+");
      return false;
    }
    const std::size_t second = first.find('+', 1);
    if (second == std::string_view::npos || second < 2) {
      fault("CG0323", {0, 0, static_cast<int>(first.size())},
            second == std::string_view::npos
                ? "the first line of the maze has only one corner '+'"
                : "the corners '+' of a maze need at least one character between them",
            "the first line looks like +--+--+--+");
      return false;
    }
    out_.pitch = static_cast<int>(second);
    const int length = static_cast<int>(first.size());
    for (int at = 0; at < length; at += out_.pitch)
      if (first[at] != '+') {
        fault("CG0323", {0, at, 1},
              "expected a corner '+' here, " + std::to_string(out_.pitch) +
                  " characters after the last one, found " + shown(first[at]),
              "all cells of a maze are equally wide");
        return false;
      }
    if (length % out_.pitch != 1) {
      fault("CG0323", {0, length - 1, 1},
            "the first line of the maze does not end with a corner '+'",
            "all cells of a maze are equally wide");
      return false;
    }
    out_.columns = (length - 1) / out_.pitch;
    return true;
  }

  // All lines as long as the first, and an odd number of them.
  bool outline() {
    const int count = static_cast<int>(lines_.size());
    if (count / 2 > MazeDrawing::kMaxCells / out_.columns) {
      fault("CG0324", {0, 0, static_cast<int>(line(0).size())},
            "the maze has " + std::to_string(count / 2) + " rows of " +
                std::to_string(out_.columns) + " cells, more than " +
                std::to_string(MazeDrawing::kMaxCells) + " together",
            "draw a smaller one, or build it from several");
      return false;
    }
    const std::size_t width = line(0).size();
    for (int i = 1; i < count; ++i) {
      if (line(i).size() == width) continue;
      const int length = static_cast<int>(line(i).size());
      fault("CG0321", {i, 0, std::max(1, length)},
            "this line of the maze is " + std::to_string(length) +
                " characters long, its first one " + std::to_string(width),
            "line them up: every cell is " + std::to_string(out_.pitch - 1) +
                " characters wide, and the outer wall has no gap");
      if (enough()) break;
    }
    if (!out_.faults.empty()) return false;
    if (count < 3 || count % 2 == 0) {
      const bool closed = line(count - 1)[0] == '+';
      fault("CG0321", {count - 1, 0, static_cast<int>(width)},
            count < 3 ? "the maze has no cells: its drawing ends after " + std::to_string(count) +
                            (count == 1 ? " line" : " lines")
            : closed ? "the maze has an even number of lines, " + std::to_string(count)
                     : "the maze ends with a line of cells",
            closed && count >= 3 ? "lines of corners and lines of cells take turns"
                                 : "close it with a last line of corners like the first");
      return false;
    }
    out_.rows = count / 2;
    return true;
  }

  // +--+  +BB+: walls that run east and west.
  void corners(int index) {
    const std::string_view text = line(index);
    const int row = out_.rows - index / 2;
    for (int column = 0; column <= out_.columns && !enough(); ++column) {
      const int corner = column * out_.pitch;
      const char c = text[corner];
      if (c != '+')
        fault(
            "CG0323", {index, corner, 1},
            "expected a corner '+' here, found " + (c == ' ' ? "a blank" : shown(c)),
            "corners are " + std::to_string(out_.pitch) + " characters apart in every second line");
      if (column == out_.columns) break;
      const std::string_view wall = text.substr(static_cast<std::size_t>(corner) + 1,
                                                static_cast<std::size_t>(out_.pitch) - 1);
      const DrawnAt at{index, corner + 1, out_.pitch - 1};
      const bool outer = row == 0 || row == out_.rows;
      out_.horizontal[row * out_.columns + column] = segment(wall, '-', at, outer);
    }
  }

  // |S |T1|: walls that run north and south, and what is between them.
  void cells(int index) {
    const std::string_view text = line(index);
    const int row = out_.rows - 1 - index / 2;
    for (int column = 0; column <= out_.columns && !enough(); ++column) {
      const int begin = column * out_.pitch;
      out_.vertical[row * (out_.columns + 1) + column] =
          segment(text.substr(static_cast<std::size_t>(begin), 1), '|', {index, begin, 1},
                  column == 0 || column == out_.columns);
      if (column == out_.columns) break;
      std::string_view inside = text.substr(static_cast<std::size_t>(begin) + 1,
                                            static_cast<std::size_t>(out_.pitch) - 1);
      const std::size_t first = inside.find_first_not_of(' ');
      if (first == std::string_view::npos) continue;
      inside = inside.substr(first, inside.find_last_not_of(' ') - first + 1);
      cell(inside, row, column,
           {index, begin + 1 + static_cast<int>(first), static_cast<int>(inside.size())});
    }
  }

  char segment(std::string_view text, char wall, DrawnAt at, bool outer) {
    char letter = 0;
    bool blank = false, drawn = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const char c = text[i];
      const DrawnAt here{at.line, at.begin + static_cast<int>(i), 1};
      if (c == wall) {
        drawn = true;
      } else if (c == ' ') {
        blank = true;
      } else if (is_letter(c) && (letter == 0 || letter == c)) {
        letter = c;
      } else {
        fault("CG0322", here,
              is_letter(c) ? "two doors, '" + std::string(1, letter) + "' and '" +
                                 std::string(1, c) + "', in one piece of wall"
                           : shown(c) + " in a wall of the maze",
              "a wall is " + std::string(text.size(), wall) + ", an opening blank, and a door is " +
                  std::string(text.size(), letter != 0 ? letter : 'A'));
        return MazeDrawing::kWall;
      }
    }
    if (blank && (drawn || letter != 0)) {
      fault("CG0322", at, "a piece of wall that is drawn incompletely",
            "a wall is " + std::string(text.size(), wall) + ", an opening blank, and a door is " +
                std::string(text.size(), letter != 0 ? letter : 'A'));
      return MazeDrawing::kWall;
    }
    if (blank && outer) {
      fault("CG0323", at, "a gap in the outer wall of the maze",
            "close it, or make it a door, which may be open: a letter here, and open=\"…\"");
      return MazeDrawing::kWall;
    }
    return letter != 0 ? letter : drawn ? MazeDrawing::kWall : MazeDrawing::kOpen;
  }

  void cell(std::string_view name, int row, int column, DrawnAt at) {
    const auto bad = std::find_if_not(name.begin(), name.end(), is_word);
    if (bad != name.end()) {
      const DrawnAt here{at.line, at.begin + static_cast<int>(bad - name.begin()), 1};
      if (*bad == ' ')
        fault("CG0322", at, "two names in one cell of the maze", "a cell has one name, or none");
      else
        fault("CG0322", here, shown(*bad) + " in a cell of the maze",
              "a cell holds its name, made of letters, digits and _, or nothing; walls are in line "
              "with the corners");
      return;
    }
    if (name[0] >= '0' && name[0] <= '9') {
      fault("CG0322", at, "a cell's name cannot begin with a digit: '" + std::string(name) + "'",
            "put a letter before it: T" + std::string(name));
      return;
    }
    if (name == "free" || is_cell_number(name)) {
      fault("CG0325", at,
            "'" + std::string(name) + "' is a reserved name: " +
                (name == "free" ? "the cells without a name" : "a cell by row and column"),
            "choose another name");
      return;
    }
    out_.cells.push_back({std::string(name), row, column, at});
  }

  const std::vector<std::string_view>& lines_;
  MazeDrawing out_;
};

}  // namespace

DrawnAt MazeDrawing::at_west(int row, int column) const {
  return {2 * (rows - 1 - row) + 1, column * pitch, 1};
}

DrawnAt MazeDrawing::at_south(int row, int column) const {
  return {2 * (rows - row), column * pitch + 1, pitch - 1};
}

MazeDrawing read_maze(const std::vector<std::string_view>& lines) {
  return DrawingReader(lines).read();
}

}  // namespace cogrsim::dsl
