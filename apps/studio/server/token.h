// Secrets that let a browser in.
#pragma once

#include <string>
#include <string_view>

#include "cogrsim/core/result.h"

namespace cogrsim::studio {

/// 128 bits of the system's randomness as 32 hexadecimal digits. Errors: the system has none to give.
Result<std::string> new_token();

/// Whether `given` is `secret`, in a time that does not depend on where they differ (it may depend
/// on the lengths: that of a token is no secret).
bool same_token(std::string_view given, std::string_view secret);

}  // namespace cogrsim::studio
