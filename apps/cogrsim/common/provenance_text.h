// The provenance of a result, as text.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/physics/provenance.h"
#include "common/terminal.h"

namespace cogrsim::cli {

/// Four or fewer lines under a run: the engine with its solver, formulation and integrator; the
/// stages that CogRSim computes where the engine computes others; the options in force; what was left out.
std::string provenance_lines(const Provenance& provenance);

/// One row for a quantity, one column for a run: engine, solver, …, all stages, options. The first
/// cell is the quantity; the head row is not in it.
std::vector<std::vector<std::string>> provenance_rows(const std::vector<Provenance>& runs);

/// "erp=0.2 iterations=50"; those of assemblies behind, "robot: formulation=reduced".
std::string options_text(const Provenance& provenance);

}  // namespace cogrsim::cli
