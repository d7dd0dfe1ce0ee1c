// What the targets of imported models share.
#pragma once

#include <string>
#include <string_view>

namespace cogrsim::fuzz {

/// Imports `input` as the file `name`, beside files that it can include. `semantics`: an SRDF for it.
/// There is a scene that compiles, or an error.
void check_import(std::string_view input, const std::string& name,
                  const std::string& semantics = {});

}  // namespace cogrsim::fuzz
