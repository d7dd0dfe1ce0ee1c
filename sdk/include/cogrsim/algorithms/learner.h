// The interface of learners with a table of action values, such as "q_learning" and "sarsa".
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// One transition: `action` in `state` gave `reward` and led to `next_state`.
struct Experience {
  std::int64_t state = 0;
  int action = 0;
  double reward = 0.0;
  std::int64_t next_state = 0;
  /// The episode has ended: `next_state` has no value, and `next_action` is ignored.
  bool done = false;
  /// The next action in `next_state`. SARSA needs it, Q-learning ignores it.
  int next_action = -1;
};

/// Action values of one visited state.
struct LearnerRow {
  std::int64_t state = 0;
  std::uint64_t visits = 0;    ///< number of transitions from this state
  std::vector<double> values;  ///< by action
};

/// Learns the action values Q(s, a), the expected sum of discounted rewards, from transitions. The
/// controller defines the meaning of the numbers of states and actions.
///
///     int a = *learner->choose(s, 4, true);
///     … execute the action, observe the next state …
///     learner->learn({s, a, reward, s2, done});
///
/// A learner with a parameter `table` stores its table in a file between runs. The path is relative
/// to the folder of the scene. The file is read when the learner is created, if it exists, and
/// written at the end of episodes (parameter `save_every`) and by save(""). Writing is atomic; if
/// two runs write the same file, the last one overwrites the other. The results of a run that
/// starts with a table depend on the table and not only on the seed.
class Learner {
 public:
  static constexpr const char* kFamily = "learner";
  virtual ~Learner() = default;

  /// Chooses an action in `state` from 0 to actions - 1: the action with the highest value, or, if
  /// `exploring`, sometimes another one by the rule of the learner and its seeded random stream.
  /// Among equal values it draws one if exploring and takes the first otherwise. Errors: actions <
  /// 1, or a number of actions that differs from earlier calls for this state.
  virtual Result<int> choose(std::int64_t state, int actions, bool exploring) = 0;

  /// Updates the action values. Errors: the state does not have the action; the state (for SARSA
  /// also the next state) is not in the table and was not used in choose(); the reward is not
  /// finite; the table could not be written.
  virtual Result<> learn(const Experience& experience) = 0;

  /// Value of the best action, max over a of Q(s, a); the initial value for an unvisited state.
  virtual double value(std::int64_t state) const = 0;
  /// Q(s, a); the initial value for an unvisited state or action.
  virtual double value(std::int64_t state, int action) const = 0;

  /// All visited states in ascending order.
  virtual std::vector<LearnerRow> table() const = 0;
  virtual std::uint64_t episodes() const = 0;  ///< number of completed episodes

  /// The complete table as text. save() writes it, and save() of a controller may contain it.
  virtual std::string memory() const = 0;
  /// Replaces the table by the output of memory(). `where` names the text in errors. Errors, with
  /// the line, after which the table is unchanged: the text is damaged, of another version, or of
  /// another learner.
  virtual Result<> remember(const std::string& memory, const std::string& where) = 0;

  /// Writes the table to a file; "": to that of the parameter `table`. Errors: the file cannot be
  /// written, or there is no file name.
  virtual Result<> save(const std::string& path) const = 0;
  /// Reads the table from a file. Errors: the file cannot be read, or those of remember().
  virtual Result<> load(const std::string& path) = 0;
};

}  // namespace cogrsim
