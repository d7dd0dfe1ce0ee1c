// Reads the exported symbols of a shared library without loading it.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/result.h"

namespace cogrsim {

/// Names of the defined dynamic symbols of an ELF file that begin with `prefix`. Works on stripped
/// libraries too. The file is not trusted: every offset is checked against its size.
/// Errors: not a readable regular file, not a shared library of this machine, damaged.
Result<std::vector<std::string>> exported_symbols(const std::string& path,
                                                  const std::string& prefix);

}  // namespace cogrsim
