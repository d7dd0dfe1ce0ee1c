// The grammar of signals, for parsers of larger expressions.
#pragma once

#include <string>

#include "signals/terms.h"

namespace cogrsim {

inline constexpr std::size_t kLongestSignal = 4096;  ///< [byte]

/// Parses a signal with sums, products and numbers. Errors: as Signal::parse().
Result<SignalNode> parse_signal(const SignalScope& scope, const std::string& text);

}  // namespace cogrsim
