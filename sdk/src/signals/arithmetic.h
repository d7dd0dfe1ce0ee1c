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
///     factor  = "-" factor | number | "(" sum ")" | function "(" sum ")" | signal
///     function = "abs" | "sin" | "cos" | "exp"
///
/// where `signal` parses all other text. Plus and minus between two terms need blanks on both
/// sides, because names may contain a minus. The terms of a sum must have the same unit (a number
/// without a unit has that of the other term); the units of a product are concatenated; sin and cos take an
/// angle or a number without unit, exp a number without unit. Errors: the
/// grammar, different units, more than 50 nested brackets, and those of `signal`.
Result<SignalNode> parse_arithmetic(
    const std::string& text, const std::function<Result<SignalNode>(const std::string&)>& signal);

}  // namespace cogrsim
