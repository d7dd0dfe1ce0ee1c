// The plugin: a stateless factory of ODE worlds.
#include "capabilities.h"
#include "world.h"

#include "cogrsim/physics/backend_plugin.h"

namespace cogrsim::ode {

class OdeBackend final : public Backend {
 public:
  const char* name() const override { return "ode"; }
  const char* engine_version() const override { return COGRSIM_ODE_VERSION; }
  Provenance provenance(const Parameters&) const override {
    Provenance out;
    out.engine = "Open Dynamics Engine";
    out.solver = "ODE's Dantzig LCP on rows of CogRSim";
    out.formulation = "maximal coordinates";
    out.integrator = "cogrsim: midpoint";
    for (const StepStage stage : kStepStages) out[stage] = {ComputedBy::cogrsim, "cogrsim::ode"};
    out[StepStage::broad_phase] = {ComputedBy::engine, "dSpaceCollide2"};
    out[StepStage::narrow_phase] = {ComputedBy::engine, "dCollide, points moved by CogRSim"};
    out[StepStage::contact_law] = {ComputedBy::engine, "dxSolveLCP"};
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

COGRSIM_BACKEND(cogrsim::ode::OdeBackend, "ode", version("0.1.0"), author("the CogRSim authors"),
                summary("ODE 0.16: rigid bodies with conditions on velocities, solved exactly"))
