// What the program has with neither the studio nor sharing.
#include "command_line.h"
#include "missing_words.h"

namespace cogrsim::cli {

std::vector<AddWords> more_words() {
  return {[](CLI::App& app, int& status) {
    add_missing(app, status, {"studio", "bundle", "push", "pull", "list"});
  }};
}

}  // namespace cogrsim::cli
