#include "options.h"

namespace cogrsim::bullet {

const ParameterTable& world_option_table() {
  static const ParameterTable table = {
      parameter(
          "solver", "sequential-impulse",
          "btSequentialImpulseConstraintSolver, btNNCGConstraintSolver (diverges with bounded "
          "motors), or btMLCPSolver with btDantzigSolver, btLemkeSolver (none for friction) or "
          "btSolveProjectedGaussSeidel")
          .one_of({"sequential-impulse", "nncg", "dantzig", "lemke", "projected-gauss-seidel"}),
      parameter("iterations", 10, "sweeps of the solver (m_numIterations)").range(1, 10000),
      parameter("erp", 0.2, "part of a joint's error that a step takes back (m_erp)").range(0, 1),
      parameter("erp2", 0.2, "part of an overlap that a step takes back (m_erp2)").range(0, 1),
      parameter("cfm", 0.0, "softness of contacts and joints (m_globalCfm)").range(0, 1e3),
      parameter("split-impulse", true,
                "overlap beyond the threshold is taken back without momentum (m_splitImpulse)"),
      parameter("split-impulse-penetration-threshold", -0.04, "m",
                "contact distance below which impulses are split")
          .range(-1e3, 1e3),
      parameter("warm-starting", true, "begin with the impulses of the step before"),
      parameter("warm-starting-factor", 0.85, "part of them (m_warmstartingFactor)").range(0, 1),
      parameter("friction-directions", 1,
                "1: along the slip, 2: also across it (SOLVER_USE_2_FRICTION_DIRECTIONS)")
          .range(1, 2),
      parameter("margin", 0.0, "m",
                "collision margin of boxes, cylinders and hulls; 0: a tenth of the smallest half "
                "extent, 4 cm at most (setSafeMargin)")
          .range(0, 10),
      parameter("plane-convex-multipoint-iterations", 4,
                "contact points between a plane and another shape that are looked for at once "
                "(setPlaneConvexMultipointIterations)")
          .range(0, 16),
  };
  return table;
}

}  // namespace cogrsim::bullet
