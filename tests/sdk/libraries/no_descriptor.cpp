#include "cogrsim/plugin/descriptor.h"
#include "trap.h"

extern "C" COGRSIM_API const char COGRSIM_ABI_SYMBOL[] = "";
