// The plugin: what Bullet can do, who computes what, and its worlds.
#include <LinearMath/btAlignedAllocator.h>

#include <new>

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/backend_plugin.h"
#include "world.h"

namespace cogrsim::bullet {

namespace {

Capabilities make_capabilities() {
  Capabilities out;
  set_shape_features(out);
  set_joint_features(out);
  for (const char* feature : {"joint.", "loop.", "joint.limit.", "joint.damping.",
                              "joint.friction.", "joint.stiffness."}) {
    out.set(std::string(feature) + "screw", Support::unsupported,
            "Bullet has no screw: no constraint of its own couples turning and sliding");
  }
  for (const char* feature :
       {"joint.damping.ball", "joint.friction.ball", "joint.stiffness.ball"}) {
    out.set(feature, Support::unsupported, "btPoint2PointConstraint has neither motor nor spring");
  }
  out.set("joint.limit.ball", Support::unsupported,
          "Bullet limits swing and twist apart, not the whole angle of turning");
  for (const char* feature :
       {"body.static", "body.kinematic", "contact.stiffness", "runtime.add", "runtime.remove",
        "runtime.save", "runtime.set_state", "runtime.attach", "runtime.body_kind",
        "runtime.joint_axes", "report.contact_force", "report.joint_reaction",
        "report.joint_effort"}) {
    out.set(feature, Support::exact);
  }
  return out;
}

class BulletBackend final : public Backend {
 public:
  BulletBackend() {
    // Bullet does not look whether malloc gave it memory, and would write through a null pointer. It
    // keeps these for the whole process, so they must be functions that are never unloaded.
    btAlignedAllocSetCustom(static_cast<void* (*)(std::size_t)>(::operator new),
                            static_cast<void (*)(void*)>(::operator delete));
    Surfaces::install();
  }
  const char* name() const override { return "bullet"; }
  const char* engine_version() const override {
    static const std::string version =
        std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
    return version.c_str();
  }
  Provenance provenance(const Parameters& complete) const override;
  const Capabilities& capabilities() const override { return capabilities_; }
  const ParameterTable& world_options() const override { return world_option_table(); }
  const ParameterTable& assembly_options() const override { return assembly_option_table(); }
  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const override {
    return BulletWorld::create(model);
  }

 private:
  Capabilities capabilities_ = make_capabilities();
};

Provenance BulletBackend::provenance(const Parameters& complete) const {
  const Options options = options_from(complete);
  const bool reduced = options.reduced;
  const std::map<std::string, std::string> solvers = {
      {"sequential-impulse",
       reduced ? "btMultiBodyConstraintSolver" : "btSequentialImpulseConstraintSolver"},
      {"nncg", "btNNCGConstraintSolver"},
      {"dantzig", "btMLCPSolver, btDantzigSolver"},
      {"lemke", "btMLCPSolver, btLemkeSolver"},
      {"projected-gauss-seidel", "btMLCPSolver, btSolveProjectedGaussSeidel"}};
  const std::string solver = solvers.at(options.solver);
  Provenance out;
  out.engine = "Bullet Physics";
  out.solver = solver;
  out.formulation = reduced ? "reduced coordinates where btMultiBody can"
                            : "maximal coordinates but for assemblies that ask for reduced";
  out.integrator = "semi-implicit Euler";
  const auto by = [&](StepStage stage, const std::string& name) {
    out[stage] = {ComputedBy::engine, name};
  };
  by(StepStage::broad_phase, "btDbvtBroadphase");
  by(StepStage::narrow_phase, "btCollisionDispatcher, btDefaultCollisionConfiguration");
  by(StepStage::contact_memory, "btPersistentManifold");
  by(StepStage::contact_law, solver);
  by(StepStage::friction, solver + ", coefficient of a pair by gContactAddedCallback");
  by(StepStage::restitution, solver + "::restitutionCurve, coefficient by gContactAddedCallback");
  by(StepStage::joints, reduced ? "btMultiBody, btTypedConstraint" : "btTypedConstraint");
  by(StepStage::limits,
     reduced ? "btMultiBodyJointLimitConstraint, btTypedConstraint" : "btTypedConstraint");
  by(StepStage::motors,
     "motors of btTypedConstraint and btMultiBodyJointMotor; soft springs, dampers, servos and "
     "torque motors as applyTorque before the step");
  by(StepStage::integrator, reduced ? "btMultiBodyDynamicsWorld::stepSimulation(dt, 0)"
                                    : "btDiscreteDynamicsWorld::stepSimulation(dt, 0)");
  return out;
}

}  // namespace

}  // namespace cogrsim::bullet

using cogrsim::bullet::BulletBackend;
COGRSIM_BACKEND(BulletBackend, "bullet", version("0.2.0"), author("the CogRSim authors"),
                summary("Bullet 3.24 as it ships, in double precision"))
