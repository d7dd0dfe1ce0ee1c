// What the program has without the studio.
#include "command_line.h"
#include "share.h"

namespace cogrsim::cli {

std::vector<AddWords> more_words() { return {share::add_share}; }

}  // namespace cogrsim::cli
