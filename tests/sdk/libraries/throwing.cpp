#include <stdexcept>

#include "cogrsim/plugin/descriptor.h"

extern "C" COGRSIM_API const char COGRSIM_ABI_SYMBOL[] = "";
extern "C" COGRSIM_API const cogrsim::PluginDescriptor* cogrsim_plugin() {
  throw std::runtime_error("no licence today");
}
