// What the program has with the studio built in.
#include "bundle_words.h"
#include "command_line.h"
#include "share.h"
#include "studio_words.h"

namespace cogrsim::cli {

std::vector<AddWords> more_words() {
  return {studio::add_studio, studio::add_bundle, share::add_share};
}

}  // namespace cogrsim::cli
