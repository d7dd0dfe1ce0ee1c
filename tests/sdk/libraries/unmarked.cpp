// Any other shared library.
#include "cogrsim/core/export.h"
#include "trap.h"

extern "C" COGRSIM_API int answer() { return 42; }
