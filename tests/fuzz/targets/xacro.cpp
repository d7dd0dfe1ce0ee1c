#include "import_input.h"
#include "targets.h"

namespace cogrsim::fuzz {

void xacro(std::string_view input) { check_import(input, "m.urdf.xacro"); }

}  // namespace cogrsim::fuzz
