#include "common/missing_commands.h"

#include <CLI/CLI.hpp>

#include "common/options.h"
#include "common/terminal.h"

namespace cogrsim::cli {

void add_missing(CLI::App& app, int& status, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    CLI::App& command = *app.add_subcommand(name, "Not in this program");
    command.group("");  // not listed
    command.prefix_command();
    command.callback([name, &status] {
      print_error("cogrsim was built without the studio, so there is no 'cogrsim " + name +
                  "'\nhelp: build it with -DCOGRSIM_STUDIO=ON");
      status = kWrongUsage;
    });
  }
}

}  // namespace cogrsim::cli
