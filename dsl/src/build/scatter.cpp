// Scattered objects: free positions for them, once everything else has its pose.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "build/build_scene.h"

namespace cogrsim::dsl {
namespace {

constexpr int kRounds = 24;                        // drawings of one scatter
constexpr std::size_t kMostPositions = 4'000'000;  // tried by one scatter: a few seconds

// Four digits are enough for a message.
std::string centimetres(double metres) {
  char text[48];
  std::snprintf(text, sizeof text, "%.4g cm", metres * 100.0);
  return text;
}

}  // namespace

// "walls.free", "walls.S" or a region.
std::optional<Ground> Builder::named_ground(const Element& scatter) {
  const auto word = reader(scatter).word("in");
  if (!word.given()) return std::nullopt;
  const std::string& text = (*word).text;
  Ground out;
  out.name = text;
  const auto maze_of = [&](const Element& element) {
    return std::find_if(context_.mazes.begin(), context_.mazes.end(),
                        [&](const MazePlan& maze) { return maze.element == &element; });
  };
  const auto cell = [&](const MazeModel& maze, int row, int column) {
    out.rectangles.push_back(
        {column * maze.cell, (column + 1) * maze.cell, row * maze.cell, (row + 1) * maze.cell});
  };
  constexpr std::string_view kFree = ".free";
  if (text.size() > kFree.size() && text.substr(text.size() - kFree.size()) == kFree) {
    const Word of{text.substr(0, text.size() - kFree.size()), (*word).span};
    const Names::Found found = names_.peek(scatter, of.text);
    if (found.lost) return std::nullopt;
    const auto maze = found.element != nullptr ? maze_of(*found.element) : context_.mazes.end();
    if (maze != context_.mazes.end()) {
      out.X_WG = note(*maze->element).X_W;
      for (int row = 0; row < maze->plan.rows; ++row)
        for (int column = 0; column < maze->plan.columns; ++column)
          if (std::none_of(maze->plan.named_cells.begin(), maze->plan.named_cells.end(),
                           [&](const auto& p) { return p.row == row && p.column == column; }))
            cell(maze->plan, row, column);
      if (!out.rectangles.empty()) return out;
      sink()
          .report("CG1011", (*word).span, scatter.trail,
                  "every cell of maze '" + of.text + "' has a name: none is free")
          .help("delete names from its drawing, or name another region");
      return std::nullopt;
    }
  }
  const Element* element = names_.find(scatter, *word, Wanted::any);
  if (element == nullptr) return std::nullopt;
  if (note(*element).faulty) return std::nullopt;
  if (element->tag() == "frame" && element->parent != nullptr) {
    const auto maze = maze_of(*element->parent);
    int row = 0, column = 0;
    if (maze != context_.mazes.end()) {
      out.X_WG = note(*maze->element).X_W;
      const auto named = std::find_if(maze->plan.named_cells.begin(), maze->plan.named_cells.end(),
                                      [&](const auto& p) { return p.name == element->name; });
      if (named != maze->plan.named_cells.end()) {
        cell(maze->plan, named->row, named->column);
        return out;
      }
      if (std::sscanf(element->name.c_str(), "r%dc%d", &row, &column) == 2) {
        cell(maze->plan, row, column);
        return out;
      }
    }
  }
  const auto region = std::find_if(model_.regions.begin(), model_.regions.end(),
                                   [&](const RegionModel& r) { return r.name == element->path; });
  if (region == model_.regions.end()) {
    sink()
        .report("CG1011", (*word).span, scatter.trail,
                "'" + text + "' is " + kind_of(*element) + ", not a region or a maze cell")
        .note("it is defined here", element->span())
        .help("name a region, a cell of a maze, or its free cells: walls.free");
    return std::nullopt;
  }
  out.X_WG =
      region->body == kWorld ? region->X_BR : model_.bodies[region->body].X_WB * region->X_BR;
  if (region->type == RegionModel::Type::sphere) {
    out.radius = region->radius;
    return out;
  }
  const Vec3 half = 0.5 * region->size;
  out.X_WG.p = out.X_WG * Vec3(0, 0, -half.z());
  out.rectangles.push_back({-half.x(), half.x(), -half.y(), half.y()});
  return out;
}

std::optional<Ground> Builder::ground(const Element& scatter) {
  Reader r = reader(scatter);
  if (r.has("in") == r.has("area")) {
    if (r.has("in"))
      fault("CG0608", scatter, "area", "'in' and 'area' both set the region for the objects");
    else
      fault("CG0204", scatter, "<scatter> needs 'in' or 'area': the region for the objects")
          .help("write in=\"walls.free\", in=\"…\" with a region's name, or area=\"2 m 3 m\"");
    return std::nullopt;
  }
  if (r.has("in")) {
    for (const char* own : {"xyz", "rpy", "quat", "frame"})
      if (r.has(own)) {
        fault("CG0608", scatter, own,
              "'in' sets the region for the objects; '" + std::string(own) + "' belongs to 'area'")
            .help("delete one of them");
        return std::nullopt;
      }
    return named_ground(scatter);
  }
  const auto area = r.numbers("area");
  if (!area.given() || note(scatter).faulty) return std::nullopt;
  Ground out;
  out.name = "the area";
  out.X_WG = note(scatter).X_W;
  const double x = 0.5 * (*area)[0], y = 0.5 * (*area)[1];
  out.rectangles.push_back({-x, x, -y, y});
  return out;
}

void Builder::scatter_instances(const ScatterPlan& plan, const std::set<int>& absent) {
  const Element& scatter = *plan.element;
  const auto clearance = reader(scatter).number("clearance");
  const auto where = ground(scatter);
  if (clearance.failed() || !where) return;
  const Pose X_GW = where->X_WG.inverse();
  std::vector<Solid> obstacles;
  for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
    if (absent.count(static_cast<int>(b)) != 0) continue;
    for (const Shape& shape : model_.bodies[b].shapes)
      if (shape.collides)
        add_solids(model_, shape, X_GW * (model_.bodies[b].X_WB * shape.X_BS), obstacles);
  }
  // The iterations as they were built: relative to the pose of the scatter itself.
  const Pose X_EW = note(scatter).X_W.inverse();
  std::vector<Bundle> bundles;
  std::vector<std::vector<std::size_t>> bodies;
  double widest = 0.0;
  bool good = true;
  for (const ScatterGroup& group : plan.groups) {
    Bundle& bundle = bundles.emplace_back();
    std::vector<std::size_t>& own = bodies.emplace_back();
    const auto take = [&](const Element& element) {
      if (note(element).owner == &element)
        own.push_back(static_cast<std::size_t>(note(element).body));
    };
    for (const Element* member : group.members) {
      for (const char* placed : {"frame", "at"})
        if (member->find(placed) != nullptr) {
          good = false;
          fault("CG1012", *member, placed,
                "'" + std::string(placed) + "' sets a pose, but the scatter draws the pose")
              .help("move it out of the scatter, or delete '" + std::string(placed) + "'");
        }
      take(*member);
      for_each(*member, take);
    }
    for (const std::size_t b : own)
      for (const Shape& shape : model_.bodies[b].shapes)
        if (shape.collides)
          add_solids(model_, shape, X_EW * (model_.bodies[b].X_WB * shape.X_BS), bundle.solids);
    for (const Solid& solid : bundle.solids)
      for (const auto& p : solid.outline)
        widest = std::max({widest, std::abs(p.x()) + solid.radius, std::abs(p.y()) + solid.radius});
  }
  if (!good) return;
  // If space is tight, the first objects may block the last: then all are drawn again.
  std::vector<std::optional<Vec3>> best(bundles.size());
  std::size_t fitted = 0, budget = kMostPositions;
  for (int round = 0; round < kRounds && budget > 0; ++round) {
    Scatterer scatterer(*where, obstacles, *clearance, budget);
    std::vector<std::optional<Vec3>> positions;
    std::size_t count = 0;
    for (std::size_t i = 0; i < bundles.size(); ++i) {
      RandomStream random(context_.seed, scatter.path + "/" + std::to_string(i) +
                                             (round > 0 ? "/" + std::to_string(round) : ""));
      positions.push_back(scatterer.put(bundles[i], random));
      if (positions.back()) ++count;
    }
    if (round == 0 || count > fitted) {
      best = std::move(positions);
      fitted = count;
    }
    if (fitted == bundles.size()) break;
  }
  for (std::size_t i = 0; i < bundles.size(); ++i) {
    if (!best[i]) continue;
    Pose X_GP;
    X_GP.p = *best[i];
    const Pose X_WP = where->X_WG * X_GP;
    for (const Element* member : plan.groups[i].members) context_.drawn_poses[member] = X_WP;
    // For the scatters after this one.
    for (const std::size_t b : bodies[i])
      model_.bodies[b].X_WB = X_WP * (X_EW * model_.bodies[b].X_WB);
  }
  if (fitted == bundles.size()) return;
  report_shortage(scatter, where->name, fitted, bundles.size(), *clearance, widest);
}

void Builder::report_shortage(const Element& scatter, const std::string& ground, std::size_t fitted,
                              std::size_t wanted, double clearance, double widest) {
  fault("CG1010", scatter, "count",
        (fitted == 0 ? std::string("none") : "only " + std::to_string(fitted)) + " of " +
            std::to_string(wanted) + " fit into " +
            (ground == "the area" ? ground : "'" + ground + "'") +
            (clearance > 0 ? " with a clearance of " + centimetres(clearance) : ""))
      .help((fitted > 0 ? "ask for at most " + std::to_string(fitted) + ", or " : std::string()) +
            "make the objects smaller (they extend " + centimetres(widest) + " to the side)" +
            (clearance > 0 ? ", lower the clearance," : "") + " or use a larger region");
}

bool Builder::scatter() {
  if (context_.scatters.empty() || !context_.drawn_poses.empty()) return false;
  std::set<int> absent;
  const auto each_body = [&](const ScatterPlan& plan, auto&& use) {
    for_each(*plan.element, [&](const Element& element) {
      if (note(element).owner == &element) use(note(element).body);
    });
  };
  for (const ScatterPlan& plan : context_.scatters)
    each_body(plan, [&](int body) { absent.insert(body); });
  bool any = false;
  for (const ScatterPlan& plan : context_.scatters) {
    scatter_instances(plan, absent);
    each_body(plan, [&](int body) { absent.erase(body); });
    any = any || !plan.groups.empty();
  }
  return any;
}

}  // namespace cogrsim::dsl
