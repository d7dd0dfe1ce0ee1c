// The templates of `cogrsim new`, as they lie in the folder templates.
#pragma once

#include <vector>

namespace cogrsim::cli {

struct TemplateFile {
  const char* kind;  ///< folder: "controller", …, or "common": into every project whose kind has no
                     ///< file of this name
  const char* name;  ///< within it, with the placeholders
  const char* text;
};

/// All of them, sorted by kind and name.
const std::vector<TemplateFile>& template_files();

}  // namespace cogrsim::cli
