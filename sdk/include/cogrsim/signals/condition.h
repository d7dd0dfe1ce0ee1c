// Conditions: what is true or not of a frame, for tests, rules and measures.
//
//     abs(robot.chassis.roll) lt 10 deg
//     distance(robot, wall) lt 20 cm and not contacts(robot, wall) gt 0
//     inside(robot, goal) or time ge 15 s
//
// | text                    | holds when                                            |
// |-------------------------|-------------------------------------------------------|
// | a lt b, a < b           | less; le <=  gt >  ge >=  eq ==  ne != likewise        |
// | SIGNAL                  | a signal without a unit is not 0: inside(bot, goal)   |
// | not c                   | c does not hold                                       |
// | c and d, c or d         | both, either; `and` binds closer than `or`            |
// | ( c )                   | c does                                                |
//
// The words lt le gt ge eq ne need no escaping in XML; < is written &lt; there. Sides of a comparison
// are signals (cogrsim/signals/signal.h), with sums, products, numbers and units. Both must be of one
// dimension. A bare number is in the SI unit of the other side, but an angle needs its unit, as
// everywhere in a scene (0 needs none). `eq` and `ne` compare numbers exactly, as measured: good for
// counts, events and `inside`, seldom for lengths.
//
// A signal may have no value: a sensor that has not read yet, a body that is not there. What is
// said about such a value is neither true nor false but unknown, and so is its `not`. Of `a and b`
// and `a or b` the known side decides where it can (Kleene's three-valued logic): unknown and no is
// no, unknown or yes is yes. Only what is known to be true holds.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"
#include "cogrsim/signals/signal.h"

namespace cogrsim {

enum class Truth { no, yes, unknown };

/// Copies are cheap and share what they are made of; may be evaluated from several threads at once.
class COGRSIM_API Condition {
 public:
  struct Node;

  /// Unknown in every frame.
  Condition();
  explicit Condition(std::shared_ptr<const Node> node);

  /// Errors: the grammar; sides of different dimension; an angle without a unit; Signal::parse()'s.
  static Result<Condition> parse(const SignalScope& scope, const std::string& text);

  Truth evaluate(const Frame& frame) const;
  /// Whether it is known to be true.
  bool holds(const Frame& frame) const { return evaluate(frame) == Truth::yes; }

  /// With the model's names in full; parses to the same condition again.
  const std::string& text() const;
  /// What frames must contain for it.
  FrameContents needs() const;
  /// The signals it speaks of, in the order of the text, each once: what to print beside a verdict.
  const std::vector<Signal>& signals() const;

 private:
  std::shared_ptr<const Node> node_;
};

}  // namespace cogrsim
