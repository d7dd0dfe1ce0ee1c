// A program built without the studio says so when it is asked for.
#include <CLI/CLI.hpp>

#include "command_line.h"
#include "options.h"
#include "terminal.h"

namespace cogrsim::cli {
namespace {

void add_what_is_missing(CLI::App& app, int& status) {
  for (const char* name : {"studio", "bundle", "push", "pull", "list"}) {
    CLI::App& command = *app.add_subcommand(name, "Not in this program");
    command.group("");  // not listed
    command.prefix_command();
    command.callback([name, &status] {
      print_error(std::string("cogrsim was built without the studio, so there is no 'cogrsim ") +
                  name + "'\nhelp: build it with -DCOGRSIM_STUDIO=ON");
      status = kWrongUsage;
    });
  }
}

}  // namespace

std::vector<AddWords> more_words() { return {add_what_is_missing}; }

}  // namespace cogrsim::cli
