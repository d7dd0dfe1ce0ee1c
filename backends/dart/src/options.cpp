#include "options.h"

namespace cogrsim::dart_engine {

const ParameterTable& world_option_table() {
  static const ParameterTable table = {
      parameter(
          "lcp-solver", "dantzig",
          "dantzig: DantzigBoxedLcpSolver, by pivoting, and PgsBoxedLcpSolver where that finds "
          "nothing, as DART does; pgs: PgsBoxedLcpSolver, by sweeps")
          .one_of({"dantzig", "pgs"}),
      parameter("max-iteration", 30, "sweeps of PgsBoxedLcpSolver (mMaxIteration)")
          .range(1, 100000),
      parameter("delta-x-threshold", 1e-6, "of its sweeps, the change of an impulse that ends them")
          .range(0.0, 1.0),
      parameter("relative-delta-x-tolerance", 1e-3, "likewise, relative to the impulse")
          .range(0.0, 1.0),
      parameter("epsilon-for-division", 1e-9, "diagonal below which it leaves a row alone")
          .range(0.0, 1.0),
      parameter("max-num-contacts", 10000,
                "contact points of a step; what is beyond DART drops in silence, of 1000 on by its "
                "own default (CollisionOption::maxNumContacts)")
          .range(2, 1000000),
  };
  return table;
}

}  // namespace cogrsim::dart_engine
