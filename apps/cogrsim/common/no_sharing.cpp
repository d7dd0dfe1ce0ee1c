// The extra commands of a program without sharing.
#include "common/command_line.h"
#include "common/missing_commands.h"

namespace cogrsim::cli {

std::vector<AddCommands> extra_commands() {
  return {add_studio_part, [](CLI::App& app, int& status) {
            add_missing(
                app, status, {"push", "pull", "list"},
                "cogrsim was built without sharing\nhelp: build it with its folder apps/share");
          }};
}

}  // namespace cogrsim::cli
