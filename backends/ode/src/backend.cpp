// The plugin: a stateless factory of ODE worlds.
#include "capabilities.h"
#include "cogrsim/physics/backend_plugin.h"
#include "library.h"
#include "world.h"

namespace cogrsim::ode {

class OdeBackend final : public Backend {
 public:
  const char* name() const override { return "ode"; }
  const char* engine_version() const override { return library_version(); }
  Provenance provenance(const Parameters& options) const override {
    const std::string solver = std::get<std::string>(options.at("solver"));
    Provenance out;
    out.engine = "Open Dynamics Engine";
    const std::string step = "dWorldStep (Dantzig's LCP)";
    const std::string quick = "dWorldQuickStep (projected Gauss-Seidel with over-relaxation)";
    out.solver = solver == "step"    ? step
                 : solver == "quick" ? quick
                                     : step + " where there are joints, else " + quick;
    out.formulation = "maximal coordinates";
    out.integrator = "semi-implicit Euler";
    const auto engine = [&](StepStage stage, const char* name) {
      out[stage] = {ComputedBy::engine, name};
    };
    engine(StepStage::broad_phase, "dHashSpace");
    engine(StepStage::narrow_phase, "dCollide");
    out[StepStage::contact_memory] = {ComputedBy::nobody, "each step finds its contacts anew"};
    engine(StepStage::contact_law, "dJointCreateContact");
    engine(StepStage::friction, std::get<std::string>(options.at("friction")) == "pyramid"
                                    ? "dContactApprox1, a pyramid"
                                    : "dContactApprox0, a box");
    engine(StepStage::restitution, "dContactBounce");
    engine(StepStage::joints,
           "dJointHinge, Slider, Ball, Universal, Piston, Fixed; planar: AMotor and LMotor");
    engine(StepStage::limits, "dParamLoStop, dParamHiStop");
    engine(StepStage::motors, "dParamVel, dParamFMax, dParamCFM; torques by dBodyAddTorque");
    engine(StepStage::integrator, "dxStepBody");
    return out;
  }
  const Capabilities& capabilities() const override { return capabilities_; }
  const ParameterTable& world_options() const override { return world_option_table(); }
  const ParameterTable& assembly_options() const override {
    static const ParameterTable none;
    return none;
  }
  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const override {
    return OdeWorld::create(model);
  }

 private:
  Capabilities capabilities_ = make_capabilities();
};

}  // namespace cogrsim::ode

COGRSIM_BACKEND(cogrsim::ode::OdeBackend, "ode", version("0.2.0"), author("the CogRSim authors"),
                summary("the Open Dynamics Engine 0.16 as it is: contact joints, its joints, "
                        "dWorldStep or dWorldQuickStep"))
