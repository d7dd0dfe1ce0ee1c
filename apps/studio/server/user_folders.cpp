#include "user_folders.h"

#include <cstdlib>

namespace cogrsim::studio {
namespace {

std::string absolute(const char* variable) {
  const char* const value = std::getenv(variable);
  return value != nullptr && value[0] == '/' ? value : "";
}

}  // namespace

std::string user_folder(const char* variable, const std::string& below) {
  if (std::string folder = absolute(variable); !folder.empty() || below.empty()) return folder;
  const std::string home = absolute("HOME");
  return home.empty() ? "" : home + "/" + below;
}

std::string user_state_folder() { return user_folder("XDG_STATE_HOME", ".local/state"); }

}  // namespace cogrsim::studio
