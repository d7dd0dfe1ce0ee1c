// Subcommands of parts that a program may lack.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Subcommands that are not listed, and report why they are missing: a message, "\nhelp: …".
void add_missing(CLI::App& app, int& status, const std::vector<std::string>& names,
                 const std::string& why);

/// The studio's subcommands, of the module that is installed beside the plugins, or missing ones.
void add_studio_part(CLI::App& app, int& status);

}  // namespace cogrsim::cli
