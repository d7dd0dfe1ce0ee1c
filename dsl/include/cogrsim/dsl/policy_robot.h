// The robot that a policy card names, as a scene.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/policy/card.h"

namespace cogrsim::dsl {

/// Compiles the scene of a card, or imports its URDF, MJCF or SDF into a scene in memory that refers to its
/// meshes where they are, with motors for the card's actions. `found` gets the findings of the import:
/// those of the source, CG1505 meshes must be written beside the scene, CG1508 (warning) what moves
/// otherwise. `files` gets what was read beside `card.robot`.
COGRSIM_API CompileResult compile_policy_robot(const PolicyCard& card, PluginCatalog& plugins,
                                               std::vector<Diagnostic>& found,
                                               std::vector<std::string>& files);

}  // namespace cogrsim::dsl
