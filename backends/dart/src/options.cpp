#include "options.h"

#include "cogrsim/physics/backend_checks.h"

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

Result<Options> read_options(const SceneModel& model) {
  const auto all = physics_options(model, "dart", world_option_table());
  if (!all) return tl::unexpected(all.error());
  const auto number = [&](const char* name) { return std::get<double>(all->at(name)); };
  const auto count = [&](const char* name) { return std::get<std::int64_t>(all->at(name)); };
  Options out;
  out.pgs = std::get<std::string>(all->at("lcp-solver")) == "pgs";
  out.max_iteration = static_cast<int>(count("max-iteration"));
  out.delta_x_threshold = number("delta-x-threshold");
  out.relative_delta_x_tolerance = number("relative-delta-x-tolerance");
  out.epsilon_for_division = number("epsilon-for-division");
  out.max_num_contacts = static_cast<std::size_t>(count("max-num-contacts"));
  return out;
}

}  // namespace cogrsim::dart_engine
