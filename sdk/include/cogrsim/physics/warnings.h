// What an engine does otherwise than the scene says.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/export.h"
#include "cogrsim/model/scene_model.h"

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

/// A warning (CG2008) for each spring and drag of the scene that is too stiff for its step, with any
/// engine: they act on bodies from outside.
COGRSIM_API std::vector<Diagnostic> stiff_forces(const SceneModel& scene);

/// Warnings of an engine with an iterative solver about rotors that are heavy for the bodies they turn.
/// `ratios`: by joint and axis, a rotor's inertia over that of the bodies; the solver holds `most`.
COGRSIM_API std::vector<Diagnostic> rotor_warnings(const SceneModel& scene,
                                                   const std::string& backend,
                                                   const std::vector<std::vector<double>>& ratios,
                                                   double most);

}  // namespace cogrsim
