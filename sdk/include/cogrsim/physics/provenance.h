// Who computed a result: which engine in which version, and stage by stage whether the engine's own
// code or CogRSim's does the work.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>

#include "cogrsim/core/export.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

class Backend;
struct SceneModel;

/// The parts of a step, in the order in which an engine usually goes through them.
enum class StepStage {
  broad_phase,     ///< which bodies are near each other
  narrow_phase,    ///< contact points, normals, depths
  contact_memory,  ///< what is kept of contacts from step to step
  contact_law,     ///< normal forces or impulses
  friction,
  restitution,
  joints,  ///< what holds bodies together
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

enum class ComputedBy {
  unanswered,
  engine,   ///< code of the engine named in Provenance::engine
  cogrsim,  ///< code of CogRSim or of the backend's author
  nobody    ///< the engine has no such stage
};

/// "unanswered", "engine", "cogrsim", "nobody".
COGRSIM_API const char* to_string(ComputedBy by);

/// One stage's answer. `name`: the class or function that does it, "btDbvtBroadphase"; for nobody,
/// what that means for a result, "impacts do not bounce".
struct StageOrigin {
  ComputedBy by = ComputedBy::unanswered;
  std::string name;
};

struct Provenance {
  std::string backend;          ///< Backend::name()
  std::string engine;           ///< its full name: "Bullet Physics"
  std::string version;          ///< Backend::engine_version()
  std::string solver;           ///< "sequential impulse"
  std::string formulation;      ///< "maximal coordinates", "reduced coordinates"
  std::string integrator;       ///< "semi-implicit Euler"
  std::string cogrsim_version;  ///< of this library
  std::array<StageOrigin, kStepStages.size()> stages;
  Parameters options;  ///< every option of the world in force, defaults included
  /// By assembly name, of those whose options are not all defaults.
  std::map<std::string, Parameters> assembly_options;

  StageOrigin& operator[](StepStage stage) { return stages[static_cast<std::size_t>(stage)]; }
  const StageOrigin& operator[](StepStage stage) const {
    return stages[static_cast<std::size_t>(stage)];
  }
};

/// Who computes what when `backend` runs `model`. Errors: an option that the backend does not take,
/// or what check_provenance() finds.
COGRSIM_API Result<Provenance> provenance_of(const Backend& backend, const SceneModel& model);

/// Errors: a stage without an answer or a name, an engine, version, solver, formulation or
/// integrator that is not named; all of them, joined by newlines.
COGRSIM_API Result<> check_provenance(const Provenance& provenance);

/// The option as a scene would write it: "50", "0.2", "true", "dantzig", "1 2 3".
COGRSIM_API std::string option_text(const ParameterValue& value);

/// In one line: "Bullet Physics 3.24, sequential impulse, maximal coordinates, semi-implicit Euler".
COGRSIM_API std::string summary_text(const Provenance& provenance);

/// As a JSON object with the keys of Provenance; options are a flat object of texts.
COGRSIM_API std::string to_json_text(const Provenance& provenance);
/// Errors: not such an object.
COGRSIM_API Result<Provenance> parse_provenance(const std::string& json);

}  // namespace cogrsim
