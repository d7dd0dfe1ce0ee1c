// The plugin: a stateless factory of MuJoCo worlds.
#include "capabilities.h"
#include "options.h"
#include "world.h"

#include "cogrsim/physics/backend_plugin.h"

namespace cogrsim::mujoco {

class MujocoBackend final : public Backend {
 public:
  MujocoBackend() { install_handlers(); }
  const char* name() const override { return "mujoco"; }
  const char* engine_version() const override { return mj_versionString(); }
  Provenance provenance(const Parameters& options) const override {
    const auto text = [&](const char* key) { return std::get<std::string>(options.at(key)); };
    const std::string solver = text("solver"), integrator = text("integrator");
    Provenance out;
    out.engine = "MuJoCo";
    out.solver = solver == "PGS"      ? "projected Gauss-Seidel"
                 : solver == "CG"     ? "conjugate gradients"
                 : solver == "Newton" ? "Newton's method"
                                      : "Newton's method, conjugate gradients for heaps";
    out.solver += ", " + text("cone") + " cones";
    out.formulation = "generalized coordinates, soft constraints";
    out.integrator = integrator == "RK4"        ? "Runge-Kutta 4"
                     : integrator == "implicit" ? "implicit in velocity"
                                                : "semi-implicit Euler";
    const std::string solve = solver == "PGS"      ? "mj_solPGS"
                              : solver == "CG"     ? "mj_solCG"
                              : solver == "Newton" ? "mj_solNewton"
                                                   : "mj_solNewton or mj_solCG";
    const auto engine = [&](StepStage stage, const std::string& name) {
      out[stage] = {ComputedBy::engine, name};
    };
    engine(StepStage::broad_phase, "mj_collision: mj_broadphase");
    engine(StepStage::narrow_phase, "mj_collision: mjCOLLISIONFUNC");
    engine(StepStage::contact_memory, "mjData::qacc_warmstart");
    engine(StepStage::contact_law, "mj_makeConstraint, " + solve);
    engine(StepStage::friction, "mj_makeConstraint, " + solve);
    engine(StepStage::restitution, "solref of a damped spring");
    engine(StepStage::joints, "mjModel's joints, loops by mjEQ_CONNECT and mjEQ_WELD");
    engine(StepStage::limits, "mjCNSTR_LIMIT_JOINT, " + solve);
    engine(StepStage::motors, "mj_fwdActuation, mj_passive, mjCNSTR_FRICTION_DOF");
    engine(StepStage::integrator, integrator == "RK4"        ? "mj_RungeKutta"
                                  : integrator == "implicit" ? "mj_implicit"
                                                             : "mj_Euler");
    return out;
  }
  const Capabilities& capabilities() const override { return capabilities_; }
  const ParameterTable& world_options() const override { return world_option_table(); }
  const ParameterTable& assembly_options() const override {
    static const ParameterTable none;
    return none;
  }
  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const override {
    return MujocoWorld::create(model);
  }

 private:
  Capabilities capabilities_ = make_capabilities();
};

}  // namespace cogrsim::mujoco

COGRSIM_BACKEND(cogrsim::mujoco::MujocoBackend, "mujoco", version("0.1.0"),
                author("the CogRSim authors"),
                summary("MuJoCo 2.2 as it ships: generalized coordinates, soft constraints"))
