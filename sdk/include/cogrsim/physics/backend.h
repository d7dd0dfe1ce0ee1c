// A physics engine, as the rest of CogRSim knows it: a stateless factory of worlds.
#pragma once

#include <memory>

#include "cogrsim/physics/capabilities.h"
#include "cogrsim/physics/provenance.h"
#include "cogrsim/physics/world.h"

namespace cogrsim {

class Backend {
 public:
  virtual ~Backend() = default;

  /// "bullet", "cogrsim".
  virtual const char* name() const = 0;
  /// Of the engine, asked of its library when it runs: "3.24".
  virtual const char* engine_version() const = 0;
  /// Who computes what with these options (complete): engine, solver, formulation, integrator and
  /// all stages. The rest is filled in by provenance_of(). What CogRSim's code computes is never
  /// called the engine's.
  virtual Provenance provenance(const Parameters& options) const = 0;

  virtual const Capabilities& capabilities() const = 0;

  /// Keys of the engine's block `<NAME …/>` under `<physics>`, and of the one inside an assembly.
  virtual const ParameterTable& world_options() const = 0;
  virtual const ParameterTable& assembly_options() const {
    static const ParameterTable none;
    return none;
  }

  /// Builds the whole scene. The caller has run check_capabilities; what is unsupported may be
  /// refused here too. Options in the model were completed against the tables above, or are
  /// missing (then defaults hold). Errors name the element and its place.
  virtual Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const = 0;
};

}  // namespace cogrsim
