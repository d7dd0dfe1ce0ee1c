// Sums, differences, products and quotients of signals.
#pragma once

#include <functional>
#include <string>

#include "signals/terms.h"

namespace cogrsim {

/// Parses `text` as
///
///     sum     = product { (" + " | " - ") product }
///     product = factor { ("*" | "/") factor }
///     factor  = "-" factor | number | "(" sum ")" | "abs(" sum ")" | signal
///
/// where `signal` reads what is none of that. Plus and minus between two terms stand between
/// blanks, since names may hold a minus. Units: those of a sum must be the same (a bare number takes
/// the other's), those of a product are written side by side. Errors: the grammar, units that do
/// not go together, more than 50 brackets inside each other, and `signal`'s own.
Result<SignalNode> parse_arithmetic(
    const std::string& text, const std::function<Result<SignalNode>(const std::string&)>& signal);

}  // namespace cogrsim
