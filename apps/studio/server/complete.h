// Completions at a position in a scene's text.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/dsl/edit.h"
#include "talk.h"

namespace cogrsim::studio {

/// Answer of the request `complete`: `offset` [code points] into `text`, which need not be
/// well-formed; `schema` as written by dsl::write_schema_json(); `elements` give the names there are.
/// At most 200 items. Errors: an offset beyond the text.
Answer complete_at(const std::string& text, std::int64_t offset, const Json& schema,
                   const std::vector<dsl::OutlineElement>& elements);

}  // namespace cogrsim::studio
