#include "cogrsim/plugin/descriptor.h"
#include "trap.h"

static const int entry = 1;
COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::sensor, "good", &entry, version("1.2.0"),
                      author("A. Tester"), summary("does nothing"),
                      parameter("gain", 1.0, "1", "factor"))
