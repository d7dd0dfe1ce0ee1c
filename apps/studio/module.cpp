// What the program loads for the studio: it is a part that an installation may lack.
#include "bundle_options.h"
#include "cogrsim/core/export.h"
#include "common/command_line.h"
#include "studio_options.h"

extern "C" COGRSIM_API void cogrsim_add_studio(CLI::App& app, int& status) {
  cogrsim::studio::add_studio(app, status);
  cogrsim::studio::add_bundle(app, status);
}
extern "C" COGRSIM_API const char* cogrsim_studio_version() { return COGRSIM_VERSION; }
