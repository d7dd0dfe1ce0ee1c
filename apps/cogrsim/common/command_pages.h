// Pages made from the table of the command line, so that each option is written down once.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}

namespace cogrsim::cli {

/// docs/guide/command-line.md.
std::string reference_page(const CLI::App& table);
/// cogrsim(1), in roff.
std::string man_page(const CLI::App& table);
/// cogrsim-COMMAND(1).
std::string command_man_page(const CLI::App& command);

/// The commands that people call.
std::vector<const CLI::App*> commands_of(const CLI::App& table);
/// Options of a command, or its positional arguments, without --help.
std::vector<const CLI::Option*> options_of(const CLI::App& command, bool positional);
/// What an option takes, as its help says: "FILE|-"; empty: nothing.
std::string type_of(const CLI::Option& option);
/// The values it may have, if they are few.
std::vector<std::string> choices_of(const CLI::Option& option);
/// "-b", "--backend".
std::vector<std::string> names_of(const CLI::Option& option);
std::string description_of(const CLI::Option& option);

}  // namespace cogrsim::cli
