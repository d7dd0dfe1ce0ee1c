// Folders of the user's, by the XDG Base Directory Specification.
#pragma once

#include <string>

namespace cogrsim::studio {

/// The folder that the environment's `variable` names, else `below` in the home folder. "": there is
/// none. Paths that are not absolute do not count.
std::string user_folder(const char* variable, const std::string& below = {});

/// For state that outlives a session: $XDG_STATE_HOME or ~/.local/state.
std::string user_state_folder();

}  // namespace cogrsim::studio
