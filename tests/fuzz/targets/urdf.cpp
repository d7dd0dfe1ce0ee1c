#include "import_input.h"
#include "targets.h"

namespace cogrsim::fuzz {

void urdf(std::string_view input) { check_import(input, "m.urdf"); }

}  // namespace cogrsim::fuzz
