// In which coordinates each articulated group is solved.
#pragma once

#include <string>

#include "grouping.h"

#include "cogrsim/core/parameter.h"
#include "cogrsim/core/result.h"

namespace cogrsim::bullet {

enum class Formulation { automatic, reduced, constraints };

/// "auto", "reduced", "constraints"; the tables allow no other.
Formulation formulation_of(const std::string& name);

/// True: reduced coordinates (ReducedGroup); false: bodies with constraints (ConstraintGroup).
///
/// The assembly of a joint, or the nearest one around it that says anything, decides; else
/// `of_world`, which asks for reduced coordinates only where they are to be had. Left to itself a
/// group is reduced where it is faster at the same quality: long chains that hang on something.
/// Errors: an assembly that asks for reduced coordinates and has what they cannot do, and
/// assemblies that ask for different formulations of one group; with the place.
Result<bool> choose_reduced(const SceneModel& model, const JointChain& group, Formulation of_world);

}  // namespace cogrsim::bullet
