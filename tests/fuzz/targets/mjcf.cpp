#include "import_input.h"
#include "targets.h"

namespace cogrsim::fuzz {

void mjcf(std::string_view input) { check_import(input, "m.xml"); }

}  // namespace cogrsim::fuzz
