// Trained policies.
#pragma once

#include "common.h"

namespace cogrsim::python {

void bind_policy(py::module_& m);

}  // namespace cogrsim::python
