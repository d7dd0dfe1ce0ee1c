// Pages made from the table of the command line, so that each option is written down once.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// docs/guide/command-line.md.
std::string reference_page(const CLI::App& table);
/// cogrsim(1), in roff.
std::string man_page(const CLI::App& table);
/// A script to be sourced by bash.
std::string bash_completion(const CLI::App& table);

}  // namespace cogrsim::cli
