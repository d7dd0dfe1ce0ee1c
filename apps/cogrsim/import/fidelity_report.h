// What became of every element of an import or export, on the terminal, as JSON and as a page.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/output_file.h"
#include "cogrsim/dsl/import_model.h"
#include "common/json_text.h"

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// The head of a report.
struct ConversionTitle {
  std::string text;    ///< "Import of robot.urdf"
  std::string source;  ///< the file that was read
  std::string format;  ///< of the other program's file: "URDF"; empty: unknown
  bool done = false;   ///< a result was made
};

/// Adds --report and --strict.
void add_report_options(CLI::App& command, std::string& report, bool& strict);
/// Throws UsageError if a report's name ends neither in .json nor in .html.
void check_report_name(const std::string& file);
OutputKind report_kind(const std::string& file);

/// Prints what is not exact to stderr, the first 20 of each kind.
void print_fidelity(const dsl::FidelityReport& report);
Json fidelity_json(const ConversionTitle& title, const dsl::FidelityReport& report,
                   const std::vector<Diagnostic>& diagnostics);
/// A page that needs no other file.
std::string fidelity_html(const ConversionTitle& title, const dsl::FidelityReport& report,
                          const std::vector<Diagnostic>& diagnostics);
/// Writes the report, if `file` is not empty.
Result<> write_fidelity(const std::string& file, const ConversionTitle& title,
                        const dsl::FidelityReport& report,
                        const std::vector<Diagnostic>& diagnostics);

}  // namespace cogrsim::cli
