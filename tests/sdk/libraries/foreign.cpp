// Built for another ABI: its code must never run.
#include "cogrsim/plugin/descriptor.h"
#include "trap.h"

extern "C" COGRSIM_API const char cogrsim_abi_8_gcc99_cxx11[] = "";
extern "C" COGRSIM_API const cogrsim::PluginDescriptor* cogrsim_plugin() { return nullptr; }
