// Provenance of a result: the engine and its version, and for each stage of a step whether code of
// the engine or code of CogRSim computes it.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/core/result.h"
#include "cogrsim/physics/leave_out.h"

namespace cogrsim {

class Backend;
struct SceneModel;

/// The stages of a step, in the order in which an engine usually performs them.
enum class StepStage {
  broad_phase,     ///< candidate pairs of bodies
  narrow_phase,    ///< contact points, normals and penetration depths
  contact_memory,  ///< contact data that persists between steps
  contact_law,     ///< normal forces or impulses
  friction,
  restitution,
  joints,  ///< joint constraints
  limits,
  motors,  ///< motors, springs, dampers and dry friction of joints
  integrator
};
inline constexpr std::array kStepStages = {StepStage::broad_phase,    StepStage::narrow_phase,
                                           StepStage::contact_memory, StepStage::contact_law,
                                           StepStage::friction,       StepStage::restitution,
                                           StepStage::joints,         StepStage::limits,
                                           StepStage::motors,         StepStage::integrator};

/// "broad-phase", "contact-memory", ….
COGRSIM_API const char* to_string(StepStage stage);

/// The code that computes a stage.
enum class ComputedBy {
  unanswered,  ///< not declared by the backend
  engine,      ///< code of the engine named in Provenance::engine
  cogrsim,     ///< code of CogRSim or of the author of the backend
  none         ///< the engine has no such stage
};

/// "unanswered", "engine", "cogrsim", "none".
COGRSIM_API const char* to_string(ComputedBy by);

/// Declaration for one stage. `name` is the class or function that computes it, for example
/// "btDbvtBroadphase"; for ComputedBy::none it is the consequence for the results, for example
/// "impacts do not bounce".
struct StageOrigin {
  ComputedBy by = ComputedBy::unanswered;
  std::string name;
};

/// Provenance of the results of a run.
struct Provenance {
  std::string backend;          ///< Backend::name()
  std::string engine;           ///< full name of the engine: "Bullet Physics"
  std::string version;          ///< Backend::engine_version()
  std::string solver;           ///< "sequential impulse"
  std::string formulation;      ///< "maximal coordinates", "reduced coordinates"
  std::string integrator;       ///< "semi-implicit Euler"
  std::string cogrsim_version;  ///< of this library
  std::array<StageOrigin, kStepStages.size()> stages;
  Parameters options;  ///< all options of the world in use, including defaults
  /// Options of the assemblies that differ from the defaults, by name of the assembly.
  std::map<std::string, Parameters> assembly_options;
  std::vector<LeftOut> left_out;  ///< of the scene as it starts, see SimulationOptions::without

  StageOrigin& operator[](StepStage stage) { return stages[static_cast<std::size_t>(stage)]; }
  const StageOrigin& operator[](StepStage stage) const {
    return stages[static_cast<std::size_t>(stage)];
  }
  /// Declares that the engine computes a stage, by a class or function of its own.
  void by_engine(StepStage stage, std::string name) {
    (*this)[stage] = {ComputedBy::engine, std::move(name)};
  }
};

/// The provenance of a run of `model` on `backend`. Errors: the backend does not have an option of
/// the model, or those of check_provenance().
COGRSIM_API Result<Provenance> provenance_of(const Backend& backend, const SceneModel& model);

/// Checks that a provenance is complete. Errors, one per line: a stage is not declared or has no
/// name, or the engine, version, solver, formulation or integrator is not named.
COGRSIM_API Result<> check_provenance(const Provenance& provenance);

/// The text of an option value in a scene: "50", "0.2", "true", "dantzig", "1 2 3".
COGRSIM_API std::string option_text(const ParameterValue& value);

/// The version of an engine whose library has no function that says it: that of its headers, and the
/// name of the library's file that has the function at `address`: "0.16.2 (libode.so.8.0.2)".
COGRSIM_API std::string library_version(const std::string& headers, const void* address);

/// Summary in one line: "Bullet Physics 3.24, sequential impulse, maximal coordinates,
/// semi-implicit Euler".
COGRSIM_API std::string summary_text(const Provenance& provenance);

/// The provenance as a JSON object with the members of Provenance as keys. The options are a flat
/// object of texts.
COGRSIM_API std::string to_json_text(const Provenance& provenance);
/// Parses the output of to_json_text(). Errors: the text is not such an object.
COGRSIM_API Result<Provenance> parse_provenance(const std::string& json);

}  // namespace cogrsim
