// The signals that elements of the model have, such as the factors of forces.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/units.h"
#include "cogrsim/signals/signal.h"
#include "core/index.h"

namespace cogrsim {

/// The signals of one list of the model, parsed once for each model of a run.
class ElementSignals {
 public:
  /// `text` is the member with the signal, "" for an element without one.
  template <class Element>
  void resolve(const SceneModelPtr& model, const std::vector<Element>& elements,
               std::string Element::*text, const ChannelLookup& channels) {
    if (model_ == model) return;
    model_ = model;
    signals_.assign(elements.size(), {});
    needs_ = {};
    any_ = false;
    const SignalScope scope{*model, channels, {}};
    for (std::size_t i = 0; i < elements.size(); ++i) {
      if ((elements[i].*text).empty() || elements[i].removed) continue;
      any_ = true;
      auto parsed = Signal::parse(scope, elements[i].*text);
      if (!parsed) continue;  // an element that it names was removed
      if (const auto unit = units::parse_unit(parsed->unit())) signals_[i].scale = unit->to_si(1.0);
      signals_[i].signal = std::move(*parsed);
      needs_ = needs_ | signals_[i].signal.needs();
    }
  }

  bool any() const { return any_; }
  /// Of all signals.
  const FrameContents& needs() const { return needs_; }
  /// The value of an element with a signal in SI units; NaN: none.
  double evaluate(std::size_t element, const Frame& frame) const {
    return signals_[element].scale * signals_[element].signal.evaluate(frame);
  }

 private:
  struct Scaled {
    Signal signal;
    double scale = 1.0;
  };

  SceneModelPtr model_;  // that `signals_` belong to
  std::vector<Scaled> signals_;
  FrameContents needs_;
  bool any_ = false;
};

}  // namespace cogrsim
