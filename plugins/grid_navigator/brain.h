// What chooses the next action: a planner that searches the map, or a learner that rehearses on it.
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

/// The two errands of a run, one after the other.
enum class Errand { trigger, goal };

/// What an action led to in the maze.
struct Outcome {
  Errand errand = Errand::trigger;
  Cell from, to;  ///< the same when it ended blocked
  Action action = Action::north;
  bool arrived = false;  ///< `to` is where the errand ends
};

class Brain {
 public:
  virtual ~Brain() = default;
  /// The map as it is known now for an errand: doors are closed on the first. Called at the start and
  /// whenever an obstacle turns out to be there or gone.
  virtual void set_map(Errand errand, const cogrsim::Grid& grid) = 0;
  /// What to do in a cell, `straight` being the action that needs no turn. Nothing: no way is known.
  virtual std::optional<Action> choose(Errand errand, const Cell& at,
                                       std::optional<Action> straight) = 0;
  /// After every action that was really done.
  virtual void learn(const Outcome& outcome) = 0;
  /// How good it is to be in a cell: minus the number of actions left as far as a planner knows, the
  /// expected reward of a learner. NaN: no way is known.
  virtual double value(Errand errand, const Cell& at) = 0;
  /// What it has learnt, for a snapshot; "" if it does not learn.
  virtual std::string memory() const { return ""; }
  virtual void remember(const std::string& memory) { static_cast<void>(memory); }
};

/// The ends of both errands.
struct Ends {
  Cell trigger, goal;
  const Cell& of(Errand errand) const { return errand == Errand::trigger ? trigger : goal; }
};

/// What the ways from a cell to `end` risk, by the cell they begin with; all are of equal, least
/// length.
///
/// An obstacle in cell c, met from its neighbour u, costs d_c(u) - d(u) further steps, where d counts
/// those to `end` and d_c does without c. A way risks the sum over its cells, and of the ways from u
/// one takes the least: R(u) = min over c of (d_c(u) - d(u)) + R(c).
std::vector<std::pair<Action, int>> risks(const cogrsim::Grid& grid, const Cell& at,
                                          const Cell& end);

/// Follows the planner's path. Of equally short ways it takes the one that risks least, of those the
/// one that goes straight on.
class PlannerBrain final : public Brain {
 public:
  /// A planner for each errand, which keeps what it found out, and another one for the values, whose
  /// starts are all over the maze.
  struct Planners {
    std::shared_ptr<cogrsim::GridPlanner> way, value;
  };
  PlannerBrain(Planners to_trigger, Planners to_goal, const Ends& ends);
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
  int episodes = 2000;  ///< on the map as it is at the start, per errand
  int again = 400;      ///< after every change of the map
  int longest = 200;    ///< actions of an episode
  double step = -1.0;   ///< reward of an action
  double bump = -3.0;   ///< of one that ends blocked
};

/// Learns the values of the four actions in every cell by rehearsing on the map (as Dyna does: Sutton
/// 1990), then does what is worth most, and goes on learning from what really happens.
class LearnerBrain final : public Brain {
 public:
  /// `chance`: uniform in [0, 1), for the cells where rehearsals begin.
  LearnerBrain(std::shared_ptr<cogrsim::Learner> learner, const Ends& ends,
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
    std::vector<int> reachable;  // cells from which the errand can be done
    bool rehearsed = false;
    std::vector<int> visits;  // of every cell, since the map last changed: tells a loop
  };
  Map& of(Errand errand) { return maps_[static_cast<std::size_t>(errand)]; }
  Map maps_[2];
};

}  // namespace grid_navigator
