// The document's part of the protocol as JSON: operations in, tree and problems out.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/dsl/edit.h"
#include "talk.h"

namespace cogrsim::studio {

/// The `ops` of an `edit`. Errors say which operation lacks what.
Result<std::vector<dsl::EditOperation>> operations_from(const Json& ops);

Json tree_json(const std::vector<dsl::OutlineElement>& elements);

/// `path`: of the scene; files are named relative to its folder.
Json problems_json(const std::vector<Diagnostic>& diagnostics, const std::string& path);

/// A field that must be there. Errors name it and what was expected.
Result<std::string> text_field(const Json& fields, const char* name);
Result<std::int64_t> whole_field(const Json& fields, const char* name);
Result<std::vector<int>> ids_field(const Json& fields, const char* name);

}  // namespace cogrsim::studio
