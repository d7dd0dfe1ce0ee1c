// The extra commands of a program with neither the studio nor sharing.
#include "common/command_line.h"
#include "common/missing_commands.h"

namespace cogrsim::cli {

std::vector<AddCommands> extra_commands() {
  return {[](CLI::App& app, int& status) {
    add_missing(app, status, {"studio", "bundle", "push", "pull", "list"});
  }};
}

}  // namespace cogrsim::cli
