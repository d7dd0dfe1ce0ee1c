#include "options.h"

namespace cogrsim::ode {

const ParameterTable& world_option_table() {
  static const ParameterTable table = {
      parameter("solver", "auto",
                "step: dWorldStep, Dantzig's method, which costs the cube of a connected group of "
                "bodies; "
                "quick: dWorldQuickStep, sweeps; auto: step where the scene has joints, else quick")
          .one_of({"auto", "step", "quick"}),
      parameter("iterations", 20, "sweeps of QuickStep (dWorldSetQuickStepNumIterations)")
          .range(1, 10000),
      parameter("sor", 1.3, "over-relaxation of QuickStep (dWorldSetQuickStepW)").range(0.01, 2.0),
      parameter("erp", 0.2, "part of an error of joints and contacts that a step takes away")
          .range(0.0, 1.0),
      parameter("cfm", 1e-10, "constraint force mixing of joints and contacts").range(0.0, 1.0),
      parameter("contact-max-correcting-velocity", 0.0, "m/s",
                "fastest that contacts push bodies apart that overlap; 0: no bound, as in ODE")
          .range(0.0, 1e6),
      parameter("contact-surface-layer", 0.0, "m", "depth to which contacts let bodies sink in")
          .range(0.0, 1.0),
      parameter("friction", "pyramid",
                "pyramid: bound by the load along each of two directions (dContactApprox1); box: "
                "the coefficient is the largest force [N] along each, whatever the load, as in ODE")
          .one_of({"pyramid", "box"}),
  };
  return table;
}

}  // namespace cogrsim::ode
