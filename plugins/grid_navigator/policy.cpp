#include "policy.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

namespace grid_navigator {

namespace {

using cogrsim::Grid;

/// Makes the grid of the planner equal to `grid` by setting only the differences, so that an
/// incremental planner retains its search.
void follow(cogrsim::GridPlanner& planner, const Grid& grid) {
  if (planner.grid().rows() != grid.rows() || planner.grid().columns() != grid.columns()) {
    planner.set_grid(grid);
    return;
  }
  const auto demand = [](const cogrsim::Result<>& done) {
    if (!done) throw std::runtime_error(done.error().message);
  };
  for (int i = 0; i < grid.size(); ++i) {
    const Cell cell = grid.cell(i);
    if (planner.grid().cost(cell) != grid.cost(cell)) {
      demand(planner.set_cost(cell, grid.cost(cell)));
    }
    for (const Action side : kActions) {
      const cogrsim::GridEdge edge{cell, side};
      if (planner.grid().cost(edge) != grid.cost(edge)) {
        demand(planner.set_cost(edge, grid.cost(edge)));
      }
    }
  }
}

std::optional<Action> action_between(const Cell& from, const Cell& to) {
  for (const Action action : kActions) {
    if (neighbour(from, action) == to) return action;
  }
  return std::nullopt;
}

bool passable(const Grid& grid, const Cell& from, Action action) {
  const Cell to = neighbour(from, action);
  return grid.contains(to) && grid.step_cost(from, to) < cogrsim::kBlocked;
}

/// Number of steps from every cell to `end`, by index; -1: no path. `without`: a cell assumed
/// blocked.
std::vector<int> steps_to(const Grid& grid, const Cell& end, int without) {
  std::vector<int> steps(static_cast<std::size_t>(grid.size()), -1);
  std::vector<int> line{grid.index(end)};
  steps[line.front()] = 0;
  std::vector<Grid::Step> next;
  for (std::size_t i = 0; i < line.size(); ++i) {
    grid.steps(line[i], next);
    for (const Grid::Step& step : next) {
      int& there = steps[step.to];
      if (there >= 0 || step.to == without) continue;
      there = steps[line[i]] + 1;
      line.push_back(step.to);
    }
  }
  return steps;
}

}  // namespace

std::vector<std::pair<Action, int>> risks(const Grid& grid, const Cell& at, const Cell& end) {
  // Cost of a cell without which there is no path: more than any detour in a maze of this size.
  const int no_path = grid.size();
  const std::vector<int> steps = steps_to(grid, end, -1);
  const auto to_go = [&](int cell) { return steps[cell]; };
  std::vector<int> near;  // cells on shortest paths, the nearest to the end first
  for (int i = 0; i < grid.size(); ++i) {
    if (to_go(i) >= 0 && to_go(i) <= to_go(grid.index(at))) near.push_back(i);
  }
  std::stable_sort(near.begin(), near.end(), [&](int a, int b) { return to_go(a) < to_go(b); });
  std::vector<std::vector<int>> around(static_cast<std::size_t>(grid.size()));
  std::vector<int> risk(static_cast<std::size_t>(grid.size()), 0);
  const auto risk_by = [&](int from, int over) {
    if (over == grid.index(end)) return 0;
    auto& detour = around[over];
    if (detour.empty()) detour = steps_to(grid, end, over);
    const int then = detour[from];
    return (then < 0 ? no_path : then - to_go(from)) + risk[over];
  };
  std::vector<std::pair<Action, int>> out;
  std::vector<Grid::Step> next;
  for (const int cell : near) {
    if (to_go(cell) == 0) continue;
    grid.steps(cell, next);
    int least = std::numeric_limits<int>::max();
    for (const Grid::Step& step : next) {
      if (to_go(step.to) != to_go(cell) - 1) continue;
      const int by = risk_by(cell, step.to);
      least = std::min(least, by);
      if (grid.cell(cell) != at) continue;
      if (const auto action = action_between(at, grid.cell(step.to))) out.push_back({*action, by});
    }
    risk[cell] = least;
  }
  return out;
}

PlannerPolicy::PlannerPolicy(Planners to_trigger, Planners to_goal, const Ends& ends)
    : planners_{std::move(to_trigger), std::move(to_goal)}, ends_(ends) {}

void PlannerPolicy::set_map(Errand errand, const Grid& grid) {
  follow(*of(errand).path, grid);
  follow(*of(errand).value, grid);
}

std::optional<Action> PlannerPolicy::choose(Errand errand, const Cell& at,
                                            std::optional<Action> straight) {
  cogrsim::GridPlanner& planner = *of(errand).path;
  const Cell& end = ends_.of(errand);
  const auto path = planner.plan(at, end);
  if (!path || path->cells.size() < 2) return std::nullopt;
  // The planner gives one of the shortest paths; of those, the one with the smallest risk is taken,
  // preferably straight ahead.
  std::optional<Action> best = action_between(at, path->cells[1]);
  int least = std::numeric_limits<int>::max();
  for (const auto& [action, risk] : risks(planner.grid(), at, end)) {
    if (risk > least || (risk == least && action != straight)) continue;
    least = risk;
    best = action;
  }
  return best;
}

double PlannerPolicy::value(Errand errand, const Cell& at) {
  const auto path = of(errand).value->plan(at, ends_.of(errand));
  return path ? -path->cost : std::numeric_limits<double>::quiet_NaN();
}

LearnerPolicy::LearnerPolicy(std::shared_ptr<cogrsim::Learner> learner, const Ends& ends,
                             const Rehearsal& rehearsal, std::function<double()> chance)
    : learner_(std::move(learner)),
      ends_(ends),
      rehearsal_(rehearsal),
      chance_(std::move(chance)) {}

std::int64_t LearnerPolicy::state(Errand errand, const Cell& at) {
  // The states of an errand depend on its target cell: values for one goal are useless for another,
  // and runs with other goals may use the same stored table.
  const Grid& grid = of(errand).grid;
  const std::int64_t size = grid.size(), end = grid.index(ends_.of(errand));
  return ((errand == Errand::goal ? size : 0) + end) * size + grid.index(at);
}

void LearnerPolicy::set_map(Errand errand, const Grid& grid) {
  Map& map = of(errand);
  map.grid = grid;
  map.visits.assign(static_cast<std::size_t>(grid.size()), 0);
  map.reachable = grid.reachable(ends_.of(errand));
  rehearse(errand, map.rehearsed ? rehearsal_.again : rehearsal_.episodes);
  map.rehearsed = true;
}

int LearnerPolicy::decide(Errand errand, const Cell& at, bool exploring) {
  const auto action = learner_->choose(state(errand, at), 4, exploring);
  if (!action) throw std::runtime_error(action.error().message);
  return *action;
}

void LearnerPolicy::experience(const Outcome& outcome, int next_action) {
  cogrsim::Experience e;
  e.state = state(outcome.errand, outcome.from);
  e.action = static_cast<int>(outcome.action);
  e.reward = outcome.from == outcome.to ? rehearsal_.bump : rehearsal_.step;
  e.next_state = state(outcome.errand, outcome.to);
  e.done = outcome.arrived;
  e.next_action = next_action;
  if (auto learnt = learner_->learn(e); !learnt) throw std::runtime_error(learnt.error().message);
}

void LearnerPolicy::rehearse(Errand errand, int episodes) {
  const Map& map = of(errand);
  if (map.reachable.size() < 2) return;
  const Cell& end = ends_.of(errand);
  for (int i = 0; i < episodes; ++i) {
    const auto pick =
        static_cast<std::size_t>(chance_() * static_cast<double>(map.reachable.size()));
    Cell at = map.grid.cell(map.reachable[std::min(pick, map.reachable.size() - 1)]);
    if (at == end) continue;
    int action = decide(errand, at, true);
    for (int step = 0; step < rehearsal_.longest; ++step) {
      Outcome outcome{errand, at, at, static_cast<Action>(action), false};
      if (passable(map.grid, at, outcome.action)) outcome.to = neighbour(at, outcome.action);
      outcome.arrived = outcome.to == end;
      const int next = outcome.arrived ? -1 : decide(errand, outcome.to, true);
      experience(outcome, next);
      if (outcome.arrived) break;
      at = outcome.to;
      action = next;
    }
  }
}

std::optional<Action> LearnerPolicy::choose(Errand errand, const Cell& at, std::optional<Action>) {
  Map& map = of(errand);
  const int index = map.grid.index(at);
  if (std::find(map.reachable.begin(), map.reachable.end(), index) == map.reachable.end()) {
    return std::nullopt;
  }
  // A learner that visits the same cell repeatedly has learnt too little, so it rehearses again.
  int& visits = map.visits[index];
  if (++visits % 3 == 0) rehearse(errand, rehearsal_.again);
  return static_cast<Action>(decide(errand, at, false));
}

void LearnerPolicy::learn(const Outcome& outcome) {
  experience(outcome, outcome.arrived ? -1 : decide(outcome.errand, outcome.to, false));
}

double LearnerPolicy::value(Errand errand, const Cell& at) {
  return at == ends_.of(errand) ? 0.0 : learner_->value(state(errand, at));
}

void LearnerPolicy::remember(const std::string& memory) {
  if (auto done = learner_->remember(memory, "the snapshot"); !done) {
    throw std::runtime_error(done.error().message);
  }
}

}  // namespace grid_navigator
