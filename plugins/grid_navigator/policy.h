// Selection of the next action: by a planner that searches the map, or by a learner that rehearses
// on it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/algorithms/grid_planner.h"
#include "cogrsim/algorithms/learner.h"
#include "wheel_driver.h"

namespace grid_navigator {

/// The two errands of a run, in this order.
enum class Errand { trigger, goal };

/// Result of an action in the maze.
struct Outcome {
  Errand errand = Errand::trigger;
  Cell from, to;  ///< equal if the action ended blocked
  Action action = Action::north;
  bool arrived = false;  ///< `to` is the end of the errand
};

class Policy {
 public:
  virtual ~Policy() = default;
  /// Sets the current map for an errand; doors are closed on the first one. Called at the start and
  /// whenever an obstacle is detected or has disappeared.
  virtual void set_map(Errand errand, const cogrsim::Grid& grid) = 0;
  /// The next action in a cell; `straight` is the action that needs no turn. nullopt: no path is
  /// known.
  virtual std::optional<Action> choose(Errand errand, const Cell& at,
                                       std::optional<Action> straight) = 0;
  /// Called after every executed action.
  virtual void learn(const Outcome& outcome) = 0;
  /// Value of a cell: for a planner minus the number of remaining actions, for a learner the
  /// expected reward. NaN: no path is known.
  virtual double value(Errand errand, const Cell& at) = 0;
  /// The learnt values, for a snapshot; "" if it does not learn.
  virtual std::string memory() const { return ""; }
  virtual void remember(const std::string& memory) { static_cast<void>(memory); }
};

/// The target cells of the two errands.
struct Ends {
  Cell trigger, goal;
  const Cell& of(Errand errand) const { return errand == Errand::trigger ? trigger : goal; }
};

/// The risk of the shortest paths from a cell to `end`, by the first cell of the path.
///
/// An obstacle in cell c that is detected from its neighbour u costs d_c(u) - d(u) additional
/// steps, where d is the number of steps to `end` and d_c that without c. The risk of a path is the
/// sum over its cells, and the smallest risk from u is R(u) = min over c of (d_c(u) - d(u)) + R(c).
std::vector<std::pair<Action, int>> risks(const cogrsim::Grid& grid, const Cell& at,
                                          const Cell& end);

/// Follows the path of the planner. Of equally short paths it takes the one with the smallest risk,
/// and of those the one that goes straight ahead.
class PlannerPolicy final : public Policy {
 public:
  /// One planner for each errand, which retains its search, and another one for the values, whose
  /// start cells vary.
  struct Planners {
    std::shared_ptr<cogrsim::GridPlanner> path, value;
  };
  PlannerPolicy(Planners to_trigger, Planners to_goal, const Ends& ends);
  void set_map(Errand errand, const cogrsim::Grid& grid) override;
  std::optional<Action> choose(Errand errand, const Cell& at,
                               std::optional<Action> straight) override;
  void learn(const Outcome&) override {}
  double value(Errand errand, const Cell& at) override;

 private:
  Planners& of(Errand errand) { return planners_[static_cast<std::size_t>(errand)]; }
  Planners planners_[2];
  Ends ends_;
};

struct Rehearsal {
  int episodes = 2000;  ///< on the initial map, per errand
  int again = 400;      ///< after every change of the map
  int longest = 200;    ///< actions of an episode
  double step = -1.0;   ///< reward of an action
  double bump = -3.0;   ///< reward of an action that ends blocked
};

/// Learns the values of the four actions in every cell by rehearsal on the map (as in Dyna, Sutton
/// 1990), then selects the action with the highest value, and continues to learn from the executed
/// actions.
class LearnerPolicy final : public Policy {
 public:
  /// `chance`: uniform in [0, 1), for the start cells of the rehearsals.
  LearnerPolicy(std::shared_ptr<cogrsim::Learner> learner, const Ends& ends,
                const Rehearsal& rehearsal, std::function<double()> chance);
  void set_map(Errand errand, const cogrsim::Grid& grid) override;
  std::optional<Action> choose(Errand errand, const Cell& at,
                               std::optional<Action> straight) override;
  void learn(const Outcome& outcome) override;
  double value(Errand errand, const Cell& at) override;
  std::string memory() const override { return learner_->memory(); }
  void remember(const std::string& memory) override;

 private:
  std::int64_t state(Errand errand, const Cell& at);
  void rehearse(Errand errand, int episodes);
  int decide(Errand errand, const Cell& at, bool exploring);
  void experience(const Outcome& outcome, int next_action);

  std::shared_ptr<cogrsim::Learner> learner_;
  Ends ends_;
  Rehearsal rehearsal_;
  std::function<double()> chance_;
  struct Map {
    cogrsim::Grid grid;
    std::vector<int> reachable;  // cells from which the target can be reached
    bool rehearsed = false;
    std::vector<int> visits;  // of every cell since the last change of the map, to detect a loop
  };
  Map& of(Errand errand) { return maps_[static_cast<std::size_t>(errand)]; }
  Map maps_[2];
};

}  // namespace grid_navigator
