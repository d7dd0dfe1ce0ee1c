// What signals are made of.
#pragma once

#include <string>

#include "cogrsim/signals/signal.h"

namespace cogrsim {

struct Signal::Node {
  std::string text, unit, quantity;
  FrameContents needs;

  virtual ~Node() = default;
  virtual double value(const Frame& frame) const = 0;
  virtual std::uint64_t revision(const Frame& frame) const { return frame.step; }
};

}  // namespace cogrsim
