// cogrsim import: a robot or world of another format as a scene, with a report of what was lost.
#pragma once

#include <string>

#include "cogrsim/dsl/import_model.h"
#include "common/json_text.h"

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds the subcommand; `status` receives the exit status when it runs.
void add_import(CLI::App& app, int& status);

/// Every element of the source with what became of it, and the counts.
Json fidelity_json(const dsl::ImportResult& result, const std::string& source);
/// The same as a page that needs nothing from elsewhere.
std::string fidelity_html(const dsl::ImportResult& result, const std::string& source);

}  // namespace cogrsim::cli
