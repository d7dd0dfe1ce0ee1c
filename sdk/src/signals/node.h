// Nodes of the expression tree of a signal.
#pragma once

#include <optional>
#include <string>

#include "cogrsim/core/units.h"
#include "cogrsim/signals/signal.h"

namespace cogrsim {

struct Signal::Node {
  std::string text, unit, quantity;
  FrameContents needs;

  virtual ~Node() = default;
  virtual double value(const Frame& frame) const = 0;
  virtual std::uint64_t revision(const Frame& frame) const { return frame.step; }
  /// nullopt: unknown (a channel of a plugin with its own unit).
  virtual std::optional<units::Dimension> dimension() const {
    if (unit == "1") return units::dim::kNone;
    const auto known = units::parse_unit(unit);
    return known ? std::optional(known->dimension) : std::nullopt;
  }
  /// Consists only of numbers.
  virtual bool constant() const { return false; }
  /// Consists only of numbers without units; takes the unit of the other operand.
  virtual bool bare() const { return false; }
};

}  // namespace cogrsim
