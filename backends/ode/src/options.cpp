#include "options.h"

#include <algorithm>

namespace cogrsim::ode {

const ParameterTable& world_option_table() {
  static const ParameterTable table = {
      parameter("solver", "auto",
                "step: dWorldStep, Dantzig's method, which costs the cube of what hangs together; "
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
      parameter("contact-slip", 0.0,
                "slip per friction force [m/(N s)] (dContactSlip1, dContactSlip2)")
          .range(0.0, 1e6),
      parameter("friction", "pyramid",
                "pyramid: bound by the load along each of two directions (dContactApprox1); box: "
                "the coefficient is the largest force [N] along each, whatever the load, as in ODE")
          .one_of({"pyramid", "box"}),
      parameter("max-contacts", 32, "most points of a pair of shapes").range(1, 1000),
      parameter("seed", 0, "where QuickStep's random order of rows begins (dRandSetSeed)")
          .range(0.0, 4294967295.0),
  };
  return table;
}

Result<Options> read_options(const SceneModel& model) {
  const auto found = model.physics.engine_options.find("ode");
  const auto all = complete_parameters(
      world_option_table(),
      found == model.physics.engine_options.end() ? Parameters{} : found->second);
  if (!all) {
    Error error = all.error();
    error.where = place_of(model, model.physics.origin);
    return tl::unexpected<Error>(error);
  }
  const auto text = [&](const char* name) { return std::get<std::string>(all->at(name)); };
  const auto number = [&](const char* name) { return std::get<double>(all->at(name)); };
  const auto whole = [&](const char* name) { return std::get<std::int64_t>(all->at(name)); };
  Options out;
  const std::string solver = text("solver");
  out.solver = solver == "step"    ? Solver::step
               : solver == "quick" ? Solver::quick
                                   : Solver::automatic;
  out.iterations = static_cast<int>(whole("iterations"));
  out.sor = number("sor");
  out.erp = number("erp");
  out.cfm = number("cfm");
  out.contact_max_correcting_velocity = number("contact-max-correcting-velocity");
  out.contact_surface_layer = number("contact-surface-layer");
  out.contact_slip = number("contact-slip");
  out.pyramid = text("friction") == "pyramid";
  out.max_contacts = static_cast<int>(whole("max-contacts"));
  out.seed = static_cast<unsigned long>(whole("seed"));
  return out;
}

bool is_quick(const Options& options, const SceneModel& model) {
  if (options.solver != Solver::automatic) return options.solver == Solver::quick;
  return std::none_of(model.joints.begin(), model.joints.end(), [](const Joint& joint) {
    return !joint.removed && joint.type != JointType::free;
  });
}

}  // namespace cogrsim::ode
