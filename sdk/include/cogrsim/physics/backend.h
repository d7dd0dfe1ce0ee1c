// The interface of a physics engine: a stateless factory of worlds.
#pragma once

#include <memory>
#include <string_view>

#include "cogrsim/physics/capabilities.h"
#include "cogrsim/physics/provenance.h"
#include "cogrsim/physics/world.h"

namespace cogrsim {

/// What may have options of an engine of its own, beside the world.
inline constexpr std::string_view kOptionElements[] = {"assembly", "material", "joint", "couple"};

/// A physics backend. All functions are thread-safe; worlds can be created and stepped in several
/// threads at once, each world in one thread at a time.
class Backend {
 public:
  virtual ~Backend() = default;

  /// Name of the backend in scenes and options: "bullet", "cogrsim".
  virtual const char* name() const = 0;
  /// Version of the engine, as its library reports it at run time: "3.24".
  virtual const char* engine_version() const = 0;
  /// Declares which code computes each stage of a step with these (completed) options: engine,
  /// solver, formulation, integrator and all stages. provenance_of() fills in the rest. A stage
  /// that is computed by code of CogRSim must not be attributed to the engine.
  virtual Provenance provenance(const Parameters& options) const = 0;

  /// The features of scenes that the backend supports.
  virtual const Capabilities& capabilities() const = 0;

  /// Engine-specific options: the attributes of `<NAME …/>` in `<physics>`, and in those elements
  /// of the scene that kOptionElements names.
  virtual const ParameterTable& world_options() const = 0;
  virtual const ParameterTable& element_options(std::string_view element) const {
    (void)element;
    static const ParameterTable none;
    return none;
  }

  /// Builds the whole scene. The caller has called check_capabilities(); the backend may also
  /// reject unsupported elements here. The options in the model have been completed with the tables
  /// above, or are missing, which means the defaults; those of materials, joints and couplings
  /// are checked, and what is not given there is that of the world. Errors name the element and its source
  /// location.
  virtual Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const = 0;
};

}  // namespace cogrsim
