// Names an engine with options that overrule the scene's: "bullet(solver=dantzig iterations=50)".
// Wherever a backend is named (command line, scene tests, studies, SimulationOptions), this may
// stand.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

struct BackendChoice {
  std::string name;
  std::map<std::string, std::string> options;  ///< as written: "50", "1 mm"
};

/// Errors: no name, an unbalanced bracket, an option without a value or given twice.
COGRSIM_API Result<BackendChoice> parse_backend_choice(const std::string& text);

/// Splits at commas and blanks outside of brackets: "bullet,bullet(iterations=50 erp=0.1)" are two.
COGRSIM_API std::vector<std::string> split_backend_choices(const std::string& text);

/// The options as values of `table`, in SI units; a number may carry a unit. Errors: as
/// complete_parameters().
COGRSIM_API Result<Parameters> option_values(const BackendChoice& choice,
                                             const ParameterTable& table);

}  // namespace cogrsim
