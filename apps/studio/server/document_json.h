// The document's part of the protocol as JSON: operations in, tree and problems out.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/dsl/edit.h"
#include "talk.h"

namespace cogrsim::studio {

/// The `ops` of an `edit`, which was checked: check_fields().
std::vector<dsl::EditOperation> operations_from(const Json& ops);

Json tree_json(const std::vector<dsl::OutlineElement>& elements);

/// `path`: of the scene; files are named relative to its folder.
Json problems_json(const std::vector<Diagnostic>& diagnostics, const std::string& path);

}  // namespace cogrsim::studio
