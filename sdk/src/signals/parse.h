// The grammar of signals, for whoever has them as parts of something larger.
#pragma once

#include <string>

#include "signals/terms.h"

namespace cogrsim {

inline constexpr std::size_t kLongestSignal = 4096;  ///< [byte]

/// A signal with sums, products and numbers. Errors: as Signal::parse().
Result<SignalNode> parse_signal(const SignalScope& scope, const std::string& text);

}  // namespace cogrsim
