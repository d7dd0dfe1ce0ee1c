// The user's browser.
#pragma once

#include <string>

namespace cogrsim::studio {

/// Opens `address` with xdg-open where there is a screen, on its own: whether that works is not waited
/// for.
void open_browser(const std::string& address);

}  // namespace cogrsim::studio
