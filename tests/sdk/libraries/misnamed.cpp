#include "cogrsim/plugin/descriptor.h"

static const int entry = 1;
COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::sensor, "somebody_else", &entry, version("1.0.0"))
