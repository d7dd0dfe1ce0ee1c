#include "import_input.h"
#include "targets.h"

namespace cogrsim::fuzz {

void sdf(std::string_view input) { check_import(input, "m.sdf"); }

}  // namespace cogrsim::fuzz
