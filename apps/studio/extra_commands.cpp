// What the program has with the studio built in.
#include "bundle_options.h"
#include "common/command_line.h"
#include "share.h"
#include "studio_options.h"

namespace cogrsim::cli {

std::vector<AddCommands> extra_commands() {
  return {studio::add_studio, studio::add_bundle, share::add_share};
}

}  // namespace cogrsim::cli
