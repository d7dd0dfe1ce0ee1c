// What signals are made of.
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
  /// nullopt: not known (a plugin's channel in a unit of its own).
  virtual std::optional<units::Dimension> dimension() const {
    if (unit == "1") return units::dim::kNone;
    const auto known = units::parse_unit(unit);
    return known ? std::optional(known->dimension) : std::nullopt;
  }
  /// Made of numbers alone.
  virtual bool constant() const { return false; }
  /// Made of numbers without a unit alone: takes the unit of what it stands beside.
  virtual bool bare() const { return false; }
};

}  // namespace cogrsim
