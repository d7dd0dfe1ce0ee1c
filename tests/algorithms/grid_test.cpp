// Planners on grids, against Floyd's and Warshall's all-pairs distances of an independent adjacency
// matrix, and D* Lite against Dijkstra from scratch.
#include <cmath>
#include <limits>

#include "cogrsim/algorithms/grid_planner.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Matrix = std::vector<std::vector<double>>;

/// Random costs, independent of Grid: east[r][c] is between (r, c) and (r, c + 1), north alike.
struct Landscape {
  int rows, columns;
  Matrix cell, east, north;

  Landscape(int row_count, int column_count, RandomStream& random, double walls, bool plain = false)
      : rows(row_count), columns(column_count) {
    const auto costs = [&](double blocked, double highest) {
      Matrix out(static_cast<std::size_t>(rows),
                 std::vector<double>(static_cast<std::size_t>(columns)));
      for (auto& row : out) {
        for (double& cost : row) {
          const double drawn = random.uniform(0.5, highest);
          cost = random.uniform() < blocked ? kInfinity : (plain ? 1.0 : drawn);
        }
      }
      return out;
    };
    cell = costs(0.05, 3.0);
    east = costs(walls, 2.0);
    north = costs(walls, 2.0);
  }

  static double at(const Matrix& matrix, int row, int column) { return matrix[row][column]; }

  Grid grid(GridMoves moves) const {
    Grid out(rows, columns, moves);
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        REQUIRE(out.set_cost(Cell{r, c}, at(cell, r, c)));
        if (c + 1 < columns) REQUIRE(out.set_cost(GridEdge{{r, c}, Side::east}, at(east, r, c)));
        if (r + 1 < rows) REQUIRE(out.set_cost(GridEdge{{r, c}, Side::north}, at(north, r, c)));
      }
    }
    return out;
  }

  /// Between neighbours of any kind; an independent implementation of the definition in grid.h.
  double step(int r, int c, int up, int right, bool unit) const {
    const int r2 = r + up, c2 = c + right;
    if (r2 < 0 || r2 >= rows || c2 < 0 || c2 >= columns) return kInfinity;
    const double mean = (at(cell, r, c) + at(cell, r2, c2)) / 2.0;
    double edge, length = 1.0;
    if (up != 0 && right != 0) {
      const int low = std::min(r, r2), left = std::min(c, c2);
      edge = std::max(std::max(at(east, low, left), at(east, low + 1, left)),
                      std::max(at(north, low, left), at(north, low, left + 1)));
      if (std::isinf(at(cell, r, c2)) || std::isinf(at(cell, r2, c))) return kInfinity;
      length = std::sqrt(2.0);
    } else if (up != 0) {
      edge = at(north, std::min(r, r2), c);
    } else {
      edge = at(east, r, std::min(c, c2));
    }
    const double cost = length * edge * mean;
    return unit && std::isfinite(cost) ? 1.0 : cost;
  }

  Matrix all_distances(bool diagonal, bool unit) const {
    const auto size = static_cast<std::size_t>(rows * columns);
    Matrix d(size, std::vector<double>(size, kInfinity));
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const auto i = static_cast<std::size_t>(r * columns + c);
        d[i][i] = 0.0;
        for (int up = -1; up <= 1; ++up) {
          for (int right = -1; right <= 1; ++right) {
            if ((up == 0 && right == 0) || (!diagonal && up != 0 && right != 0)) continue;
            const double cost = step(r, c, up, right, unit);
            if (std::isfinite(cost)) d[i][(r + up) * columns + c + right] = cost;
          }
        }
      }
    }
    for (std::size_t k = 0; k < size; ++k) {
      for (std::size_t i = 0; i < size; ++i) {
        for (std::size_t j = 0; j < size; ++j) d[i][j] = std::min(d[i][j], d[i][k] + d[k][j]);
      }
    }
    return d;
  }
};

/// Every step of the path is possible, and they cost what the path says.
void check_path(const Grid& grid, const GridPath& path, const Cell& start, const Cell& goal) {
  REQUIRE_FALSE(path.cells.empty());
  CHECK(path.cells.front() == start);
  CHECK(path.cells.back() == goal);
  double sum = 0.0;
  for (std::size_t i = 1; i < path.cells.size(); ++i) {
    sum += grid.step_cost(path.cells[i - 1], path.cells[i]);
  }
  CHECK(sum == Approx(path.cost).epsilon(1e-12).margin(0.0));
}

const auto kPlanners = {"a_star", "dijkstra", "d_star_lite", "breadth_first"};

}  // namespace

TEST_CASE("grid planners find the cheapest path between any two cells", "[algorithms][grid]") {
  const std::string name = GENERATE(values<std::string>({"a_star", "dijkstra", "d_star_lite"}));
  const auto moves = GENERATE(GridMoves::four, GridMoves::eight);
  RandomStream random(11, name);
  for (int round = 0; round < 12; ++round) {
    // Every other one has equal costs, where the heuristic is as high as it may be.
    const Landscape land(3 + round % 5, 9, random, 0.1 + 0.03 * round, round % 2 == 0);
    const Matrix distances = land.all_distances(moves == GridMoves::eight, false);
    auto planner = make<GridPlanner>(name);
    planner->set_grid(land.grid(moves));
    for (int pair = 0; pair < 40; ++pair) {
      const int from = draw(random, land.rows * land.columns);
      const int to = draw(random, land.rows * land.columns);
      const Cell start = planner->grid().cell(from), goal = planner->grid().cell(to);
      const double shortest = distances[from][to];
      const auto path = planner->plan(start, goal);
      const bool blocked =
          std::isinf(planner->grid().cost(start)) || std::isinf(planner->grid().cost(goal));
      REQUIRE(path.has_value() == (std::isfinite(shortest) && !blocked));
      if (!path) {
        CHECK(path.error().code == (blocked ? "" : kNoPath));
        continue;
      }
      // Sums of at most 63 costs in another order: rounding of 63 * 2^-53 at most.
      CHECK(path->cost == Approx(shortest).epsilon(1e-13).margin(0.0));
      check_path(planner->grid(), *path, start, goal);
    }
  }
}

TEST_CASE("breadth-first finds the fewest steps", "[algorithms][grid]") {
  const auto moves = GENERATE(GridMoves::four, GridMoves::eight);
  RandomStream random(12, "breadth");
  for (int round = 0; round < 10; ++round) {
    const Landscape land(7, 8, random, 0.2);
    const Matrix steps = land.all_distances(moves == GridMoves::eight, true);
    auto planner = make<GridPlanner>("breadth_first");
    planner->set_grid(land.grid(moves));
    for (int pair = 0; pair < 40; ++pair) {
      const int from = draw(random, 56), to = draw(random, 56);
      const Cell start = planner->grid().cell(from), goal = planner->grid().cell(to);
      const auto path = planner->plan(start, goal);
      const double fewest = steps[from][to];
      if (!path) {
        CHECK((std::isinf(fewest) || from == to));
        continue;
      }
      CHECK(static_cast<double>(path->cells.size()) - 1.0 == fewest);
      check_path(planner->grid(), *path, start, goal);
    }
  }
}

TEST_CASE("a heuristic saves work and a weight trades cost for it", "[algorithms][grid]") {
  const Grid open(40, 40);
  auto a_star = make<GridPlanner>("a_star"), dijkstra = make<GridPlanner>("dijkstra");
  a_star->set_grid(open);
  dijkstra->set_grid(open);
  const auto quick = a_star->plan({20, 5}, {20, 35}), even = dijkstra->plan({20, 5}, {20, 35});
  REQUIRE(quick);
  REQUIRE(even);
  CHECK(quick->cost == 30.0);
  CHECK(even->cost == 30.0);
  // Ties go to the cell furthest from the start, so on an open field A* walks straight there, one
  // cell per step; Dijkstra expands every cell nearer than 30.
  CHECK(quick->expanded == 30);
  CHECK(even->expanded > 1000);

  RandomStream random(13, "weight");
  for (int round = 0; round < 20; ++round) {
    const Landscape land(15, 15, random, 0.1);
    auto eager = make<GridPlanner>("a_star", {{"weight", 2.0}});
    eager->set_grid(land.grid(GridMoves::eight));
    a_star->set_grid(land.grid(GridMoves::eight));
    const auto cheap = a_star->plan({0, 0}, {14, 14}), soon = eager->plan({0, 0}, {14, 14});
    REQUIRE(cheap.has_value() == soon.has_value());
    if (cheap) CHECK(soon->cost <= 2.0 * cheap->cost);
  }
}

TEST_CASE("D* Lite stays optimal while the grid changes and expands less", "[algorithms][grid]") {
  const auto moves = GENERATE(GridMoves::four, GridMoves::eight);
  const int size = 24;
  auto d_star = make<GridPlanner>("d_star_lite"), dijkstra = make<GridPlanner>("dijkstra");
  const Grid open(size, size, moves);
  d_star->set_grid(open);
  dijkstra->set_grid(open);
  RandomStream random(14, "changes");
  std::size_t repaired = 0, searched = 0;
  Cell here{0, 0};
  Cell goal{size - 1, size - 1};
  std::vector<Cell> ahead;
  int unreachable = 0;
  for (int round = 0; round < 400; ++round) {
    for (int change = 0; change < 3; ++change) {
      Cell cell{draw(random, size - 1), draw(random, size - 1)};
      if (!ahead.empty() && random.uniform() < 0.5) {  // where it matters
        const Cell near = ahead[draw(random, static_cast<int>(ahead.size()))];
        cell = {std::min(near.row, size - 2), std::min(near.column, size - 2)};
      }
      // Cells never block, so that start and goal stay possible; some get cheaper than all others.
      if (random.uniform() < 0.3) {
        const double cost = random.uniform(0.5, 4.0);
        REQUIRE(d_star->set_cost(cell, cost));
        REQUIRE(dijkstra->set_cost(cell, cost));
      } else {
        const auto side = random.uniform() < 0.5 ? Side::north : Side::east;
        const double cost = random.uniform() < 0.6 ? kBlocked : random.uniform(1.0, 3.0);
        REQUIRE(d_star->set_cost(GridEdge{cell, side}, cost));
        REQUIRE(dijkstra->set_cost(GridEdge{cell, side}, cost));
      }
    }
    const auto lite = d_star->plan(here, goal), whole = dijkstra->plan(here, goal);
    REQUIRE(lite.has_value() == whole.has_value());
    if (!lite) {
      CHECK(lite.error().code == kNoPath);
      ++unreachable;
      REQUIRE(d_star->set_cost(GridEdge{{0, 0}, Side::north}, 1.0));
      REQUIRE(dijkstra->set_cost(GridEdge{{0, 0}, Side::north}, 1.0));
      here = {draw(random, size), draw(random, size)};
      continue;
    }
    CHECK(lite->cost == Approx(whole->cost).epsilon(1e-12).margin(0.0));
    check_path(d_star->grid(), *lite, here, goal);
    ahead = lite->cells;
    repaired += lite->expanded;
    searched += whole->expanded;
    // Walk, and begin somewhere else upon arrival.
    here = lite->cells.size() > 1 ? lite->cells[1] : Cell{draw(random, size), draw(random, size)};
    if (round % 100 == 99) goal = {draw(random, size), draw(random, size)};
  }
  INFO("expanded " << repaired << " instead of " << searched << ", no path " << unreachable
                   << " times");
  CHECK(repaired < searched / 2);
  CHECK(searched > 10000);
}

TEST_CASE("D* Lite takes account of a corner that closes", "[algorithms][grid]") {
  // The diagonal from start to goal passes the upper end of the edge north of r0c0, which belongs to
  // neither of the two.
  auto planner = make<GridPlanner>("d_star_lite");
  planner->set_grid(Grid(3, 3, GridMoves::eight));
  REQUIRE(planner->set_cost(Cell{1, 1}, 10.0));
  CHECK(planner->plan({0, 1}, {1, 0})->cost == Approx(std::sqrt(2.0)));
  REQUIRE(planner->set_cost(GridEdge{{0, 0}, Side::north}, kBlocked));
  // Around the dear cell in the middle, by three diagonals.
  CHECK(planner->plan({0, 1}, {1, 0})->cost == Approx(3.0 * std::sqrt(2.0)));
}

TEST_CASE("D* Lite repairs a closed path and a new short cut", "[algorithms][grid]") {
  // Two rooms with two gaps; the near one closes, then a nearer one opens.
  auto planner = make<GridPlanner>("d_star_lite");
  planner->set_grid(Grid(9, 9));
  for (int row = 0; row < 9; ++row) {
    if (row != 4 && row != 8) REQUIRE(planner->set_cost(GridEdge{{row, 4}, Side::east}, kBlocked));
  }
  CHECK(planner->plan({4, 0}, {4, 8})->cost == 8.0);
  REQUIRE(planner->set_cost(GridEdge{{4, 4}, Side::east}, kBlocked));
  CHECK(planner->plan({4, 0}, {4, 8})->cost == 16.0);
  REQUIRE(
      planner->set_cost(GridEdge{{3, 5}, Side::west}, 1.0));  // the same edge from its other side
  CHECK(planner->plan({4, 0}, {4, 8})->cost == 10.0);
  const auto again = planner->plan({4, 0}, {4, 8});
  REQUIRE(again);
  CHECK(again->expanded == 0);  // nothing has changed
}

TEST_CASE("grid planners report their errors", "[algorithms][grid]") {
  for (const std::string name : kPlanners) {
    INFO(name);
    auto planner = make<GridPlanner>(name);
    CHECK(has(said(planner->plan({0, 0}, {0, 0})), "outside of the grid of 0 x 0"));
    planner->set_grid(Grid(4, 5));
    CHECK(has(said(planner->plan({-1, 0}, {0, 0})), "the start r-1c0 is outside"));
    CHECK(has(said(planner->plan({0, 0}, {4, 0})), "the goal r4c0 is outside"));
    CHECK(has(said(planner->set_cost(Cell{4, 0}, 1.0)), "outside of the grid of 4 x 5"));
    CHECK(has(said(planner->set_cost(Cell{0, 0}, 0.0)), "must be above 0"));
    CHECK(has(said(planner->set_cost(Cell{0, 0}, std::nan(""))), "must be above 0"));
    CHECK(has(said(planner->set_cost(GridEdge{{0, 0}, Side::south}, 1.0)), "outer edge"));
    CHECK(has(said(planner->set_cost(GridEdge{{9, 9}, Side::north}, 1.0)), "outside"));
    const auto stay = planner->plan({1, 1}, {1, 1});
    REQUIRE(stay);
    CHECK(stay->cells.size() == 1);
    CHECK(stay->cost == 0.0);
    // The corner cell is walled in.
    REQUIRE(planner->set_cost(GridEdge{{3, 4}, Side::south}, kBlocked));
    REQUIRE(planner->set_cost(GridEdge{{3, 4}, Side::west}, kBlocked));
    const auto none = planner->plan({0, 0}, {3, 4});
    REQUIRE_FALSE(none);
    CHECK(none.error().code == kNoPath);
    CHECK(has(none.error().message,
              "of 20 cells 19 can be reached from the start and 1 from the goal"));
    REQUIRE(planner->set_cost(Cell{2, 2}, kBlocked));
    CHECK(has(said(planner->plan({0, 0}, {2, 2})), "the goal r2c2 is a blocked cell"));
  }
}

TEST_CASE("no diagonal step cuts a corner", "[algorithms][grid]") {
  Grid grid(2, 2, GridMoves::eight);
  CHECK(grid.step_cost({0, 0}, {1, 1}) == Approx(std::sqrt(2.0)));
  REQUIRE(grid.set_cost(GridEdge{{1, 0}, Side::east}, kBlocked));  // one of the four edges
  CHECK(grid.step_cost({0, 0}, {1, 1}) == kBlocked);
  CHECK(grid.step_cost({1, 0}, {0, 1}) == kBlocked);
  REQUIRE(grid.set_cost(GridEdge{{1, 0}, Side::east}, 1.0));
  REQUIRE(grid.set_cost(Cell{0, 1}, kBlocked));
  CHECK(grid.step_cost({0, 0}, {1, 1}) == kBlocked);
}

TEST_CASE("a maze's plan becomes a grid", "[algorithms][grid]") {
  // +--+--+   r1: "S" to the west; a door 3 leads south from it; a wall between the two cells
  // |S |  |   of row 1.
  // +3 +  +
  // |    G|
  // +--+--+
  MazeModel maze;
  maze.name = "walls";
  maze.rows = maze.columns = 2;
  maze.cell = 0.5;
  maze.X_WM = Pose(Vec3(1.0, 2.0, 0.0), Quat(1, 0, 0, 0));
  const int o = MazeModel::kOpen, w = MazeModel::kWall;
  maze.vertical = {w, o, w, w, w, w};
  maze.horizontal = {w, w, 3, o, w, w};
  maze.named_cells = {{"S", 1, 0}, {"G", 0, 1}};
  const Cell start = *find_cell(maze, "S"), goal = *find_cell(maze, "G");
  CHECK(start == Cell{1, 0});
  CHECK(*find_cell(maze, "r1c1") == Cell{1, 1});
  CHECK(has(said(find_cell(maze, "T")), "maze 'walls' has no cell 'T'"));
  auto planner = make<GridPlanner>("a_star");
  planner->set_grid(grid_of(maze));
  CHECK_FALSE(planner->plan(start, goal));
  const auto door = edges_of_door(maze, 3);
  REQUIRE(door.size() == 1);
  CHECK(edges_of_door(maze, 4).empty());
  CHECK(edges_of_door(maze, MazeModel::kWall).empty());
  for (const GridEdge& edge : door) REQUIRE(planner->set_cost(edge, 1.0));
  CHECK(planner->plan(start, goal)->cost == 2.0);
  planner->set_grid(grid_of(maze, true));
  CHECK(planner->plan(start, goal)->cost == 2.0);
  CHECK(centre_of(maze, goal).isApprox(Vec3(1.75, 2.25, 0.0)));
  CHECK(*cell_at(maze, Vec3(1.75, 2.25, 5.0)) == goal);
  CHECK_FALSE(cell_at(maze, Vec3(0.9, 2.25, 0.0)));
  CHECK_FALSE(cell_at(maze, Vec3(std::nan(""), 2.25, 0.0)));
}
