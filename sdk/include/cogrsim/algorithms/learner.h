// Learners with a table of action values: "q_learning", "sarsa", and yours.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// One step of experience: in `state` it did `action`, got `reward` and found itself in
/// `next_state`.
struct Experience {
  std::int64_t state = 0;
  int action = 0;
  double reward = 0.0;
  std::int64_t next_state = 0;
  /// The episode is over: `next_state` has no value and `next_action` is not looked at.
  bool done = false;
  /// What will be done in `next_state`. SARSA needs it; Q-learning does not look at it.
  int next_action = -1;
};

/// Values of the actions of one state that was met.
struct LearnerRow {
  std::int64_t state = 0;
  std::uint64_t visits = 0;    ///< experiences that began here
  std::vector<double> values;  ///< by action
};

/// Learns from experience which action is worth what: Q(s, a), the expected sum of discounted
/// rewards. States and actions are numbers that mean what the controller decides.
///
///     int a = *learner->choose(s, 4, true);
///     … do it, look where one is …
///     learner->learn({s, a, reward, s2, done});
///
/// A learner with a parameter `table` keeps its table between runs. The file lies relative to the
/// scene's folder. It is read when the learner is made, if it is there, and written whenever an
/// episode ends (parameter `save_every`) and by save(""). It is written beside its place and then
/// moved there, so that it is never seen half-written; of two runs that write the same file the
/// later wins. A run that begins with a table is no longer a function of its seed alone.
class Learner {
 public:
  static constexpr const char* kFamily = "learner";
  virtual ~Learner() = default;

  /// What to do in `state`, one of 0 … actions - 1: the best known action, or, when exploring, now
  /// and then another one, by the learner's own rule and its seeded stream. Equally good ones are
  /// drawn by lot when exploring; otherwise the first is taken.
  /// Errors: actions < 1; other than this state had before.
  virtual Result<int> choose(std::int64_t state, int actions, bool exploring) = 0;

  /// Errors: an action the state does not have; a state never asked about in choose() and not in the
  /// table (SARSA: also the next state); a reward that is not finite; the table could not be written.
  virtual Result<> learn(const Experience& experience) = 0;

  /// Value of the best action, max over a of Q(s, a); the initial value for a state never met.
  virtual double value(std::int64_t state) const = 0;
  /// Q(s, a); the initial value for what was never met.
  virtual double value(std::int64_t state, int action) const = 0;

  /// All states met, by rising number.
  virtual std::vector<LearnerRow> table() const = 0;
  virtual std::uint64_t episodes() const = 0;  ///< experiences with `done` so far

  /// All it has learnt, as text: what save() writes, and what a controller's own save() may hold.
  virtual std::string memory() const = 0;
  /// Replaces what it has learnt. `where` names the text in errors. Errors, with the line: damaged,
  /// of another version or of another learner; then nothing is changed.
  virtual Result<> remember(const std::string& memory, const std::string& where) = 0;

  /// To a file, or to that of the parameter `table` for "". Errors: cannot be written; no name.
  virtual Result<> save(const std::string& path) const = 0;
  /// Errors: cannot be read; as of remember().
  virtual Result<> load(const std::string& path) = 0;
};

}  // namespace cogrsim
