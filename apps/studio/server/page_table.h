// What the build makes of the page: see ../embed.mjs.
#pragma once

#include "page.h"

namespace cogrsim::studio {

extern const PageFile kPageFiles[];  ///< sorted by path
extern const std::size_t kPageFileCount;

}  // namespace cogrsim::studio
