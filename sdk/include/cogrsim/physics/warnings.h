// What an engine does otherwise than the scene says.
#pragma once

#include <string_view>
#include <vector>

#include "cogrsim/core/diagnostic.h"

namespace cogrsim {

/// Extension of a World, "cogrsim.warnings/1" (see World::extension): elements that the engine has,
/// and whose values it cannot hold, such as gains too stiff for the step. Simulation::create()
/// reports them beside those of check_capabilities(), before the run.
class WorldWarnings {
 public:
  static constexpr std::string_view kId = "cogrsim.warnings/1";
  virtual ~WorldWarnings() = default;
  /// One warning (CG2008) per element, with its source position; of the scene as it was when it was
  /// built or last changed.
  virtual std::vector<Diagnostic> warnings() const = 0;
};

}  // namespace cogrsim
