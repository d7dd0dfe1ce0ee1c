#include "cogrsim/plugin/descriptor.h"
#include "trap.h"

extern "C" int cogrsim_test_missing_function();
static const int entry = cogrsim_test_missing_function();
COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::sensor, "unresolved", &entry, version("1.0.0"))
