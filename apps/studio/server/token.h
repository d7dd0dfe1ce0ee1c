// Secrets that let a browser in.
#pragma once

#include <string>
#include <string_view>

#include "cogrsim/core/result.h"

namespace cogrsim::studio {

/// 128 bits of the system's randomness as 32 hexadecimal digits. Errors: the system has none to give.
Result<std::string> new_token();

/// Whether `given` is `secret`, in a time that tells nothing about where they differ (it may tell
/// whether the lengths do: that of a token is no secret).
bool same_token(std::string_view given, std::string_view secret);

}  // namespace cogrsim::studio
