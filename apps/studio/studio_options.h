// The options of `cogrsim studio`.
#pragma once

namespace CLI {
class App;
}

namespace cogrsim::studio {

/// Errors of usage are CLI11's, as in all subcommands.
void add_studio(CLI::App& app, int& status);

}  // namespace cogrsim::studio
