// What the program has without the studio.
#include "command_line.h"
#include "missing_words.h"
#include "share.h"

namespace cogrsim::cli {

std::vector<AddWords> more_words() {
  return {[](CLI::App& app, int& status) {
            add_missing(app, status, {"studio", "bundle"});
          },
          share::add_share};
}

}  // namespace cogrsim::cli
