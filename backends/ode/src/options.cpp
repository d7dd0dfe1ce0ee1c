#include "options.h"

#include <algorithm>

#include "cogrsim/physics/backend_checks.h"

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

Result<Options> read_options(const SceneModel& model) {
  const auto all = physics_options(model, "ode", world_option_table());
  if (!all) return tl::unexpected(all.error());
  const auto text = [&](const char* name) { return std::get<std::string>(all->at(name)); };
  const auto number = [&](const char* name) { return std::get<double>(all->at(name)); };
  Options out;
  const bool jointed = std::any_of(
      model.joints.begin(), model.joints.end(),
      [](const Joint& joint) { return !joint.removed && joint.type != JointType::free; });
  out.quick = text("solver") == "quick" || (text("solver") == "auto" && !jointed);
  out.iterations = static_cast<int>(std::get<std::int64_t>(all->at("iterations")));
  out.sor = number("sor");
  out.erp = number("erp");
  out.cfm = number("cfm");
  out.contact_max_correcting_velocity = number("contact-max-correcting-velocity");
  out.contact_surface_layer = number("contact-surface-layer");
  out.pyramid = text("friction") == "pyramid";
  return out;
}

}  // namespace cogrsim::ode
