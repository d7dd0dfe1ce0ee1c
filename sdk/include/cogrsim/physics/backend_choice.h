// The name of a backend with options that override those of the scene:
// "bullet(solver=dantzig iterations=50)". This form is accepted wherever a backend is named: on the
// command line, in scene tests, in studies and in SimulationOptions.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// A parsed choice of a backend.
struct BackendChoice {
  std::string name;
  std::map<std::string, std::string> options;  ///< as written: "50", "1 mm"
};

/// Parses one choice. Errors: no name, an unbalanced bracket, an option without a value, or an
/// option that is given twice.
COGRSIM_API Result<BackendChoice> parse_backend_choice(const std::string& text);

/// Splits a list at commas and blanks outside of brackets: "bullet,bullet(iterations=50 erp=0.1)"
/// has two entries.
COGRSIM_API std::vector<std::string> split_backend_choices(const std::string& text);

/// Converts the options to values of the parameters in `table`, in SI units; a number may have a
/// unit. Errors: as complete_parameters().
COGRSIM_API Result<Parameters> option_values(const BackendChoice& choice,
                                             const ParameterTable& table);

}  // namespace cogrsim
