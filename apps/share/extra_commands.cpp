// The extra commands of the program without the studio.
#include "common/command_line.h"
#include "common/missing_commands.h"
#include "share.h"

namespace cogrsim::cli {

std::vector<AddCommands> extra_commands() {
  return {[](CLI::App& app, int& status) {
            add_missing(app, status, {"studio", "bundle"});
          },
          share::add_share};
}

}  // namespace cogrsim::cli
