// The parts of the catalog of codes.
#pragma once

#include <vector>

#include "report/diagnostics.h"

namespace cogrsim::dsl {

/// CG01 XML, CG02 vocabulary, CG03 expansion, CG04 names, CG05 values and units.
std::vector<CodeInfo> language_codes();
/// CG06 frames and topology, CG07 physics, CG08 backends, CG09 plugins, CG10 placement, CG12
/// results, CG20 warnings.
std::vector<CodeInfo> scene_codes();
/// CG11 tests and measures.
std::vector<CodeInfo> test_codes();
/// CG13 regions, rules and templates.
std::vector<CodeInfo> event_codes();
/// Of these: mazes, doors and scattered objects.
std::vector<CodeInfo> maze_codes();
/// CG14 models in other formats.
std::vector<CodeInfo> import_codes();
std::vector<CodeInfo> policy_codes();

}  // namespace cogrsim::dsl
