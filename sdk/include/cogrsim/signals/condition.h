// Conditions: logical expressions about a frame, for tests, rules and measures.
//
//     abs(robot.chassis.roll) lt 10 deg
//     distance(robot, wall) lt 20 cm and not contacts(robot, wall) gt 0
//     inside(robot, goal) or time ge 15 s
//
// | text                    | true if                                               |
// |-------------------------|-------------------------------------------------------|
// | a lt b, a < b           | a is less; also le <=, gt >, ge >=, eq ==, ne !=      |
// | SIGNAL                  | a signal without a unit is not 0: inside(bot, goal)   |
// | not c                   | c is false                                            |
// | c and d, c or d         | both are true, at least one is true                   |
// | ( c )                   | c is true                                             |
//
// `and` has a higher precedence than `or`. The operators lt le gt ge eq ne need no escaping in XML,
// where < is written &lt;. The operands of a comparison are signals (cogrsim/signals/signal.h) with
// sums, products, numbers and units. Both must have the same dimension. A number without a unit is
// in the SI unit of the other operand, except that an angle needs a unit, as everywhere in a scene
// (0 needs none). `eq` and `ne` compare numbers exactly, which suits counts, events and `inside`,
// but seldom lengths.
//
// A signal may have no value, for example that of a sensor without a reading or of a body that does
// not exist. A comparison with such a value is neither true nor false but unknown, and so is its
// `not`. `and` and `or` follow Kleene's three-valued logic: unknown and false is false, unknown or
// true is true. A condition holds only if it is known to be true.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"
#include "cogrsim/signals/signal.h"

namespace cogrsim {

/// Value of a condition: false, true or unknown.
enum class Truth { no, yes, unknown };

/// A parsed condition. Copies are cheap and share their data. Several threads may evaluate a
/// condition at the same time.
class COGRSIM_API Condition {
 public:
  struct Node;

  /// A condition that is unknown in every frame.
  Condition();
  explicit Condition(std::shared_ptr<const Node> node);

  /// Parses a condition. Errors: the grammar, operands of different dimensions, an angle without a
  /// unit, or those of Signal::parse().
  static Result<Condition> parse(const SignalScope& scope, const std::string& text);

  Truth evaluate(const Frame& frame) const;
  /// Whether the condition is known to be true.
  bool holds(const Frame& frame) const { return evaluate(frame) == Truth::yes; }

  /// The condition with the full names of the model; parse() gives the same condition again.
  const std::string& text() const;
  /// The frame contents that evaluate() needs.
  FrameContents needs() const;
  /// The signals of the condition, in the order of the text, each once; for messages about a
  /// result.
  const std::vector<Signal>& signals() const;

 private:
  std::shared_ptr<const Node> node_;
};

}  // namespace cogrsim
