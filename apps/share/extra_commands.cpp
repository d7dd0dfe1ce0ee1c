// The extra commands of the program: the studio's, where it is installed, and those of sharing.
#include "common/command_line.h"
#include "common/missing_commands.h"
#include "share.h"

namespace cogrsim::cli {

std::vector<AddCommands> extra_commands() { return {add_studio_part, share::add_share}; }

}  // namespace cogrsim::cli
