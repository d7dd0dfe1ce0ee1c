// Subcommands of parts that a program was built without.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Subcommands that are not listed, and report that they belong to a part that was not built.
void add_missing(CLI::App& app, int& status, const std::vector<std::string>& names);

}  // namespace cogrsim::cli
