// Mazes: a drawing becomes an assembly of walls, doors and named cells.
#include <algorithm>
#include <map>
#include <set>

#include "expand/expand_scene.h"
#include "expand/maze_drawing.h"
#include "expand/maze_plan.h"
#include "syntax/xml_scan.h"

namespace cogrsim::dsl {
namespace {

// Attributes that a wall box copies from the maze.
constexpr std::string_view kLooks[] = {
    "material",          "density",     "friction",         "rolling-friction",
    "spinning-friction", "restitution", "friction-combine", "restitution-combine",
    "stiffness",         "color",       "texture",          "texture-size"};

bool is_gap(char c) { return c == ' ' || c == '\t'; }

/// The drawing as it is in the file.
struct Lines {
  std::vector<std::string_view> texts;  ///< from the drawing's left edge on
  std::vector<std::string_view> whole;  ///< from the file's left edge on
  std::size_t left = 0;                 ///< bytes
  int file = -1, first = 0;             ///< line of the file

  SourceSpan span(const DrawnAt& at) const {
    SourceSpan span;
    span.file = file;
    span.line = first + at.line;
    const std::string_view line = at.line < static_cast<int>(whole.size()) ? whole[at.line] : "";
    span.column = 1;
    std::size_t i = 0;
    const std::size_t begin = left + static_cast<std::size_t>(at.begin);
    for (; i < std::min(begin, line.size()); ++span.column)
      i += static_cast<std::size_t>(std::max(1, decode_utf8(line, i).length));
    span.length = std::max(1, at.length);
    return span;
  }
};

Lines lines_of(const Node& node, const SourceFile& file) {
  Lines out;
  out.file = node.text_span.file;
  out.first = node.text_span.line;
  const std::string_view all = file.text;
  const auto begin = static_cast<std::size_t>(node.text.data() - all.data());
  const std::size_t end = begin + node.text.size();
  std::size_t at = file.line_starts[static_cast<std::size_t>(out.first) - 1];
  out.left = begin - at;
  while (at < end) {
    std::size_t stop = std::min(all.find_first_of("\r\n", at), end);
    std::string_view line = all.substr(at, stop - at);
    while (!line.empty() && is_gap(line.back())) line.remove_suffix(1);
    out.whole.push_back(line);
    out.texts.push_back(line.size() > out.left ? line.substr(out.left) : std::string_view());
    if (stop < end && all[stop] == '\r' && stop + 1 < all.size() && all[stop + 1] == '\n') ++stop;
    at = stop + 1;
  }
  return out;
}

// The text left of the drawing must be the same on every line, or its columns do not match.
void check_indent(const Lines& lines, std::vector<DrawingFault>& faults) {
  const std::string_view indent = lines.whole.front().substr(0, lines.left);
  const bool starts_inside = std::find_if_not(indent.begin(), indent.end(), is_gap) != indent.end();
  for (std::size_t i = starts_inside ? 0 : 1; i < lines.whole.size(); ++i) {
    const std::string_view before = lines.whole[i].substr(0, lines.left);
    const DrawnAt at{static_cast<int>(i), -static_cast<int>(lines.left), 1};
    if (starts_inside) {
      faults.push_back({"CG0321",
                        {0, 0, 1},
                        "the drawing begins in the line of its tag",
                        "begin it on a line of its own"});
      return;
    }
    const auto drawn = std::find_if_not(before.begin(), before.end(), is_gap);
    if (drawn != before.end()) {
      faults.push_back({"CG0321",
                        {at.line, at.begin + static_cast<int>(drawn - before.begin()), 1},
                        "this line of the maze begins left of its first one",
                        "indent all lines of the drawing alike"});
      return;
    }
    if (before == indent || before.size() < lines.left) continue;
    faults.push_back({"CG0322", at,
                      "this line of the maze is indented with other tabs than its first",
                      "indent with blanks: the width of a tab is not defined"});
    return;
  }
}

std::string vec(double x, double y, double z) {
  return number_text(x) + " " + number_text(y) + " " + number_text(z);
}

std::string listed(const std::vector<std::string>& words, std::size_t most) {
  std::string out;
  for (std::size_t i = 0; i < std::min(words.size(), most); ++i)
    out += (i == 0 ? "'" : ", '") + words[i] + "'";
  if (words.size() > most) out += ", …";
  return out;
}

}  // namespace

/// Turns the drawing of one maze into elements.
class MazeMaker {
 public:
  MazeMaker(Expander& expander, const Node& node, const Expander::InsertPoint& point,
            const std::string& key)
      : expander_(expander),
        context_(expander.context_),
        node_(node),
        point_(point),
        written_(expander.read_only(node, point, key)) {}

  // False: reported, and nothing was made.
  bool make() {
    std::string name;
    const bool named = expander_.written_name(written_, point_, name);
    if (!sizes() || !draw() || !named) return false;
    std::vector<DoorRun> doors = door_runs(drawing_, sizes_, direction_, drawing_.faults);
    if (!report_faults() || !open_doors(doors)) return false;
    Node& assembly = expander_.made_node("assembly", node_.span);
    for (const std::string_view attribute : {"name", "xyz", "rpy", "quat", "frame"})
      Expander::hand_down(assembly, attribute, node_, attribute);
    Element* maze = expander_.add_made(assembly, point_, name);
    if (maze == nullptr) return true;
    inner_ = point_;
    inner_.into = maze;
    ++inner_.depth;
    plan(*maze);
    walls();
    for (const DoorRun& door : doors) build_door(door);
    name_cells();
    check_path();
    context_.mazes.push_back(std::move(plan_));
    return true;
  }

 private:
  bool sizes() {
    Reader r(context_, written_);
    const auto cell = r.number("cell"), thickness = r.number("thickness");
    const auto height = r.number("height"), door = r.number("door-thickness");
    const auto force = r.number("door-force"), speed = r.number("door-speed");
    const auto direction = r.text("door-direction");
    if (!cell.given() || thickness.failed() || height.failed() || door.failed() || force.failed() ||
        speed.failed() || direction.failed())
      return false;
    sizes_ = {*cell, *thickness, *height, door.given() ? *door : 0.6 * *thickness};
    if (force.given()) force_ = *force;
    speed_ = *speed;
    direction_ = *direction == "up"     ? DoorDirection::up
                 : *direction == "down" ? DoorDirection::down
                                        : DoorDirection::side;
    if (sizes_.thickness >= sizes_.cell) {
      context_.sink
          .report("CG0328", written_, r.has("thickness") ? "thickness" : "cell",
                  "walls " + number_text(sizes_.thickness) + " m thick fill cells of " +
                      number_text(sizes_.cell) + " m")
          .help("'cell' is from the middle of one wall to the middle of the next");
      return false;
    }
    if (sizes_.door_thickness >= sizes_.thickness) {
      context_.sink
          .report("CG0328", written_, "door-thickness",
                  "doors " + number_text(sizes_.door_thickness) +
                      " m thick do not fit into walls of " + number_text(sizes_.thickness) + " m")
          .help("doors slide into the walls: they must be thinner");
      return false;
    }
    return true;
  }

  bool draw() {
    if (node_.text.empty()) {
      drawing_ = read_maze({});
      return report_faults();
    }
    const SourceFile& file = context_.files.file(node_.text_span.file);
    lines_ = lines_of(node_, file);
    // What follows the drawing must be the end of the element.
    const std::string_view all = file.text;
    std::size_t after =
        static_cast<std::size_t>(node_.text.data() - all.data()) + node_.text.size();
    const std::size_t tag = all.find('<', after);
    if (all.substr(tag, 2) != "</") {
      drawing_.faults.push_back({"CG0322",
                                 {static_cast<int>(lines_.texts.size()) - 1, 0, 1},
                                 "the drawing of a maze is interrupted",
                                 "delete what interrupts it, comments too"});
      return report_faults();
    }
    check_indent(lines_, drawing_.faults);
    if (!report_faults()) return false;
    drawing_ = read_maze(lines_.texts);
    return report_faults() && names();
  }

  SourceSpan at(const DrawnAt& drawn) const {
    return node_.text.empty() ? node_.span : lines_.span(drawn);
  }

  // True: no faults.
  bool report_faults() {
    for (const DrawingFault& fault : drawing_.faults)
      context_.sink.report(fault.code, at(fault.at), point_.trail, fault.message).help(fault.help);
    return drawing_.faults.empty();
  }

  // Cells and doors share one scope.
  bool names() {
    std::map<std::string, SourceSpan> taken;
    bool good = true;
    const auto take = [&](const std::string& name, const DrawnAt& drawn, bool door) {
      const auto [it, is_new] = taken.emplace(name, at(drawn));
      if (is_new) return;
      good = false;
      context_.sink
          .report("CG0325", at(drawn), point_.trail,
                  door ? "door '" + name + "' has the name of a cell"
                       : "a second cell '" + name + "' in the maze")
          .note("the other one", it->second)
          .help(door ? "give one of them another letter" : "give it another name");
    };
    for (const MazeDrawing::Cell& cell : drawing_.cells) take(cell.name, cell.at, false);
    std::set<char> letters;
    const auto door = [&](char c, const DrawnAt& drawn) {
      if (c == MazeDrawing::kOpen || c == MazeDrawing::kWall || !letters.insert(c).second) return;
      take(std::string(1, c), drawn, true);
    };
    for (int row = drawing_.rows; row >= 0; --row) {
      for (int c = 0; c < drawing_.columns; ++c)
        door(drawing_.south(row, c), drawing_.at_south(row, c));
      for (int c = 0; row > 0 && c <= drawing_.columns; ++c)
        door(drawing_.west(row - 1, c), drawing_.at_west(row - 1, c));
    }
    return good;
  }

  bool open_doors(const std::vector<DoorRun>& doors) {
    Reader r(context_, written_);
    bool good = true;
    std::vector<std::string> letters;
    for (const DoorRun& door : doors) letters.emplace_back(1, door.letter);
    if (r.has("open")) {
      const auto words = r.words("open");
      if (!words.given()) return false;
      for (const Word& word : *words) {
        if (std::find(letters.begin(), letters.end(), word.text) != letters.end()) {
          open_.insert(word.text);
          continue;
        }
        good = false;
        context_.sink
            .report("CG0327", word.span, point_.trail, "the maze has no door '" + word.text + "'")
            .help(letters.empty() ? "doors are letters in the walls of its drawing"
                                  : "its doors are " + listed(letters, 12));
      }
    }
    if (!doors.empty()) return good;
    for (const Attribute& a : node_.attributes)
      if (a.name.substr(0, 5) == "door-")
        context_.sink
            .report("CG2021", a.name_span, point_.trail,
                    "'" + std::string(a.name) + "' has no effect: the maze has no door")
            .help("doors are letters in the walls of its drawing");
    return good;
  }

  void plan(const Element& maze) {
    plan_.element = &maze;
    MazeModel& m = plan_.plan;
    m.rows = drawing_.rows;
    m.columns = drawing_.columns;
    m.cell = sizes_.cell;
    m.thickness = sizes_.thickness;
    m.height = sizes_.height;
    m.origin = node_.span;
    const auto piece = [](char c) {
      return c == MazeDrawing::kOpen ? MazeModel::kOpen : MazeModel::kWall;
    };
    for (const char c : drawing_.vertical) m.vertical.push_back(piece(c));
    for (const char c : drawing_.horizontal) m.horizontal.push_back(piece(c));
    for (const MazeDrawing::Cell& cell : drawing_.cells)
      m.named_cells.push_back({cell.name, cell.row, cell.column});
  }

  void look(Node& box, std::string_view but = {}) const {
    for (const std::string_view attribute : kLooks)
      if (attribute != but) Expander::hand_down(box, attribute, node_, attribute);
  }

  void walls() {
    int count = 0;
    for (const WallRun& run : wall_runs(drawing_, sizes_)) {
      Node& box = expander_.made_node("box", at(run.at));
      const FloorBox& b = run.box;
      expander_.give(box, "size", vec(b.x1 - b.x0, b.y1 - b.y0, sizes_.height));
      expander_.give(box, "xyz",
                     vec(0.5 * (b.x0 + b.x1), 0.5 * (b.y0 + b.y1), 0.5 * sizes_.height));
      expander_.give(box, "static", "true");
      look(box);
      const Element* wall = expander_.add_made(box, inner_, "wall_" + std::to_string(++count));
      if (wall == nullptr) return;
      walls_.push_back({wall, b});
    }
  }

  void build_door(const DoorRun& run) {
    const FloorBox& first = run.panels.front();
    const double x = 0.5 * (first.x0 + first.x1), y = 0.5 * (first.y0 + first.y1);
    const SourceSpan span = at(run.at);
    const std::string name(1, run.letter);
    Node& assembly = expander_.made_node("assembly", span);
    expander_.give(assembly, "xyz", vec(x, y, 0));
    Element* door = expander_.add_made(assembly, inner_, name);
    if (door == nullptr) return;
    Expander::InsertPoint inside = inner_;
    inside.into = door;
    ++inside.depth;
    Element* leaf = expander_.add_made(expander_.made_node("body", span), inside, "leaf");
    if (leaf == nullptr) return;
    Expander::InsertPoint panels = inside;
    panels.into = leaf;
    // Clear of the floor, and of the top of the wall so that pictures do not flicker.
    const double gap = std::min(2e-3, 0.05 * sizes_.height);
    int count = 0;
    for (const FloorBox& b : run.panels) {
      Node& box = expander_.made_node("box", span);
      expander_.give(box, "size", vec(b.x1 - b.x0, b.y1 - b.y0, sizes_.height - 2 * gap));
      expander_.give(box, "xyz",
                     vec(0.5 * (b.x0 + b.x1) - x, 0.5 * (b.y0 + b.y1) - y, 0.5 * sizes_.height));
      // Attributes of doors override those of all walls.
      const bool own_color = node_.find("door-color") != nullptr;
      if (node_.find("door-material") != nullptr) {
        Expander::hand_down(box, "material", node_, "door-material");
      } else {
        for (const std::string_view attribute : kLooks)
          if (!(own_color && (attribute == "color" || attribute.substr(0, 7) == "texture")))
            Expander::hand_down(box, attribute, node_, attribute);
      }
      Expander::hand_down(box, "color", node_, "door-color");
      expander_.add_made(box, panels, "panel_" + std::to_string(++count));
    }
    DoorDrive drive;
    drive.door = door;
    drive.leaf = leaf;
    drive.at = span;
    const bool vertical = direction_ != DoorDirection::side;
    const bool back = run.travel < 0;
    drive.axis = direction_ == DoorDirection::up     ? "0 0 1"
                 : direction_ == DoorDirection::down ? "0 0 -1"
                 : run.along_x                       ? (back ? "-1 0 0" : "1 0 0")
                                                     : (back ? "0 -1 0" : "0 1 0");
    drive.travel = vertical ? sizes_.height : std::abs(run.travel);
    drive.force = force_;
    drive.speed = speed_;
    drive.open = open_.count(name) != 0;
    const int index = expander_.door_drive(node_, inside, drive);
    if (index < 0) return;
    DoorPlan& door_plan = context_.doors[index];
    door_plan.passes_ground = direction_ == DoorDirection::down;
    const auto met = [&](const FloorBox& box) {
      return std::any_of(run.swept.begin(), run.swept.end(),
                         [&](const FloorBox& swept) { return swept.meets(box); });
    };
    for (const auto& [wall, box] : walls_)
      if (met(box)) door_plan.passes.push_back(wall);
    for (const auto& [other, swept] : leaves_)
      if (std::any_of(swept.begin(), swept.end(), met)) door_plan.passes.push_back(other);
    leaves_.push_back({leaf, run.swept});
    const int local = static_cast<int>(plan_.doors.size());
    plan_.doors.push_back(index);
    for (std::size_t i = 0; i < drawing_.vertical.size(); ++i)
      if (drawing_.vertical[i] == run.letter) plan_.plan.vertical[i] = local;
    for (std::size_t i = 0; i < drawing_.horizontal.size(); ++i)
      if (drawing_.horizontal[i] == run.letter) plan_.plan.horizontal[i] = local;
  }

  void name_cells() {
    const auto add = [&](const std::string& name, int row, int column, const SourceSpan& span) {
      Node& frame = expander_.made_node("frame", span);
      const Vec3 centre = plan_.plan.centre(row, column);
      expander_.give(frame, "xyz", vec(centre.x(), centre.y(), 0));
      return expander_.add_made(frame, inner_, name) != nullptr;
    };
    for (const MazeDrawing::Cell& cell : drawing_.cells)
      if (!add(cell.name, cell.row, cell.column, at(cell.at))) return;
    for (int row = 0; row < drawing_.rows; ++row)
      for (int column = 0; column < drawing_.columns; ++column) {
        DrawnAt drawn = drawing_.at_west(row, column);
        ++drawn.begin;
        drawn.length = drawing_.pitch - 1;
        const std::string name = "r" + std::to_string(row) + "c" + std::to_string(column);
        if (!add(name, row, column, at(drawn))) return;
      }
  }

  // A maze whose goal is unreachable is usually a drawing mistake.
  void check_path() {
    const auto find = [&](const char* name) {
      return std::find_if(drawing_.cells.begin(), drawing_.cells.end(),
                          [&](const MazeDrawing::Cell& c) { return c.name == name; });
    };
    const auto from = find("S"), to = find("G");
    if (from == drawing_.cells.end() || to == drawing_.cells.end()) return;
    const std::vector<char> seen = reachable(drawing_, from->row, from->column);
    const auto reached = [&](const MazeDrawing::Cell& c) {
      return seen[c.row * drawing_.columns + c.column] != 0;
    };
    if (reached(*to)) return;
    std::vector<std::string> names;
    for (const MazeDrawing::Cell& c : drawing_.cells)
      if (&c != &*from && reached(c)) names.push_back(c.name);
    const auto count = std::count(seen.begin(), seen.end(), 1);
    context_.sink
        .report(
            "CG2020", at(to->at), point_.trail,
            "no path leads from 'S' to 'G', even with all doors open: " + std::to_string(count) +
                " of " + std::to_string(seen.size()) + " cells can be reached from 'S', " +
                (names.empty() ? "none of them with a name" : "among them " + listed(names, 12)))
        .note("'S' is here", at(from->at))
        .help("open a wall between them, or draw a door into it: a letter");
  }

  Expander& expander_;
  CompileContext& context_;
  const Node& node_;
  const Expander::InsertPoint& point_;
  Element& written_;
  Expander::InsertPoint inner_;
  MazeSizes sizes_;
  std::optional<double> force_;
  double speed_ = 0;
  DoorDirection direction_ = DoorDirection::side;
  MazeDrawing drawing_;
  Lines lines_;
  std::set<std::string> open_;
  MazePlan plan_;
  std::vector<std::pair<const Element*, FloorBox>> walls_;
  std::vector<std::pair<const Element*, std::vector<FloorBox>>> leaves_;
};

void Expander::maze(const Node& node, const InsertPoint& point, const std::string& key) {
  if (!MazeMaker(*this, node, point, key).make()) mark_failed(node, point);
}

}  // namespace cogrsim::dsl
