// A scene in MuJoCo's language.
#pragma once

#include <string>

#include "program.h"

namespace cogrsim::mujoco {

/// Writes the model, and into `program` what is decided by it: which joints make trees, which body
/// has a geom. Everything is named by its kind and index. Errors: what MuJoCo cannot have.
Result<std::string> write_mjcf(Program& program);

}  // namespace cogrsim::mujoco
