// Mass properties of several elements combined.
#pragma once

#include <vector>

#include "cogrsim/dsl/edit.h"
#include "talk.h"

namespace cogrsim::studio {

/// Answer of the request `mass`: of the bodies in these elements, at the start of the run. Static bodies
/// are named and weigh nothing here. Errors: an id that is not there; no body in any of them.
Answer mass_of(const std::vector<int>& elements, const dsl::OutlinedScene& scene);

}  // namespace cogrsim::studio
