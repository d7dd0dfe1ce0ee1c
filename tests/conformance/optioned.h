// The backend under test with one of its world options set in every scene.
#pragma once

#include <memory>
#include <string>

#include "cogrsim/core/result.h"
#include "cogrsim/physics/backend.h"

namespace conformance {

/// `text`: "solver=dantzig", a text option of `backend`. Errors: no '=', no such option.
cogrsim::Result<std::shared_ptr<const cogrsim::Backend>> with_option(
    std::shared_ptr<const cogrsim::Backend> backend, const std::string& text);

}  // namespace conformance
