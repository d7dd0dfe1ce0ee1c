// The plugin: what Bullet can do, who computes what, and its worlds.
#include <LinearMath/btAlignedAllocator.h>

#include <new>

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/backend_plugin.h"
#include "cogrsim/physics/hosted_backend.h"
#include "engine.h"

namespace cogrsim::bullet {

namespace {

/// Why a pair is not exact; null: it is.
const char* pair_note(ShapeType a, ShapeType b) {
  const auto any = [&](ShapeType x) { return a == x || b == x; };
  if (any(ShapeType::mesh) || any(ShapeType::heightmap)) {
    return "Bullet tests triangles one by one and hits their seams: a sliding box loses 6 % of "
           "its way";
  }
  if (any(ShapeType::box) && (any(ShapeType::cylinder) || any(ShapeType::convex_mesh))) {
    return "Bullet gathers the points of two faces over several steps: what hits flat starts to "
           "turn, its speed is 6 % (cylinder) or 1 % (hull) off";
  }
  return nullptr;
}

Capabilities make_capabilities() {
  Capabilities out;
  set_shape_features(out);
  set_pair_notes(out, pair_note);
  set_joint_features(out);
  for (const JointType type : kJointTypes) {
    const std::string name = to_string(type);
    if (type == JointType::free || type == JointType::screw || type == JointType::gimbal) continue;
    out.set(
        "joint." + name, Support::approximate,
        "held by sweeps of impulses: the joints of a chain of 30 gape by 0.6 mm, 9 mm where 1 kg "
        "holds 1000 (solver=\"dantzig\": below 0.1 mm)");
    out.set("loop." + name, Support::approximate,
            "held by sweeps of impulses: a four-bar closes to 0.13 mm and its driven crank lags by "
            "0.024 rad (solver=\"dantzig\": 0.09 mm, 0.006 rad)");
    if (type == JointType::fixed) continue;
    out.set("joint.limit." + name, Support::approximate,
            "stops but a hinge's throw back with erp (0.2) of the speed");
    if (type == JointType::ball) continue;
    out.set("joint.rotor-inertia." + name, Support::approximate,
            "a motor towards the speed at the start of the step, as soft as the inertia; "
            "500 sweeps hold rotors of 1000 times the inertia of the bodies they turn");
  }
  out.set("joint.coupling", Support::approximate,
          "an effort found before each step and constant over it, which all its joints feel");
  out.set("joint.coupling-effort", Support::exact);
  lack_joint(out, JointType::screw,
             "Bullet has no screw: no constraint of its own couples turning and sliding");
  lack_joint(out, JointType::gimbal, "three hinges with light bodies between them do the same");
  out.set_all({"joint.friction.ball", "joint.stiffness.ball"}, Support::unsupported,
              "Bullet's motors and springs bound and measure each of three angles by itself");
  out.set("joint.limit.ball", Support::unsupported,
          "Bullet limits swing and twist separately, not the whole angle of turning");
  set_world_features(out);
  out.set("contact.stiffness", Support::approximate,
          "a spring for each contact point, its sag 5 % off");
  out.set("contact.surface-velocity", Support::approximate,
          "by contactMotion, with two directions of friction in the whole scene");
  out.set_all({"contact.rolling-friction", "contact.spinning-friction"}, Support::approximate,
              "bounded about each axis by itself, and by an impulse of 1 N s a step; not with the "
              "solvers dantzig, lemke and projected-gauss-seidel");
  out.set("runtime.attach", Support::approximate,
          "the joint acts from the next step on, and keeps momentum to 4e-5 kg m^2/s in 0.5 s");
  out.set("runtime.body_kind", Support::approximate,
          "what is attached to the body is affected from the next step on");
  out.set("runtime.joint_axes", Support::approximate,
          "a stop that is moved 0.1 rad behind its joint throws it back at 6 rad/s");
  return out;
}

class BulletBackend final : public HostedBackend<EngineWorld<Engine>> {
 public:
  BulletBackend()
      : HostedBackend(
            Engine::kName,
            std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100),
            make_capabilities(), Engine::options()) {
    // Bullet does not look whether malloc gave it memory, and would write through a null pointer. It
    // keeps these for the whole process, so they must be functions that are never unloaded.
    btAlignedAllocSetCustom(static_cast<void* (*)(std::size_t)>(::operator new),
                            static_cast<void (*)(void*)>(::operator delete));
    Surfaces::install();
  }
  Provenance provenance(const Parameters& complete) const override;
};

Provenance BulletBackend::provenance(const Parameters& complete) const {
  const std::map<std::string, std::string> solvers = {
      {"sequential-impulse", "btSequentialImpulseConstraintSolver"},
      {"nncg", "btNNCGConstraintSolver"},
      {"dantzig", "btMLCPSolver, btDantzigSolver"},
      {"lemke", "btMLCPSolver, btLemkeSolver"},
      {"projected-gauss-seidel", "btMLCPSolver, btSolveProjectedGaussSeidel"}};
  const std::string& solver = solvers.at(value_of<std::string>(complete, "solver"));
  Provenance out;
  out.engine = "Bullet Physics";
  out.solver = solver;
  out.formulation = "maximal coordinates";
  out.integrator = "semi-implicit Euler";
  out.by_engine(StepStage::broad_phase, "btDbvtBroadphase");
  out.by_engine(StepStage::narrow_phase, "btCollisionDispatcher, btDefaultCollisionConfiguration");
  out.by_engine(StepStage::contact_memory, "btPersistentManifold");
  out.by_engine(StepStage::contact_law, solver);
  out.by_engine(StepStage::friction, solver + ", coefficient of a pair by gContactAddedCallback");
  out.by_engine(StepStage::restitution,
                solver + "::restitutionCurve, coefficient by gContactAddedCallback");
  out.by_engine(StepStage::joints, "btTypedConstraint");
  out.by_engine(StepStage::limits, "btTypedConstraint");
  out.by_engine(
      StepStage::motors,
      "motors of btTypedConstraint; soft springs, dampers, servos and torque motors as applyTorque "
      "before the step");
  out.by_engine(StepStage::integrator, "btDiscreteDynamicsWorld::stepSimulation(dt, 0)");
  return out;
}

}  // namespace

}  // namespace cogrsim::bullet

using cogrsim::bullet::BulletBackend;
COGRSIM_BACKEND(BulletBackend, "bullet", version("0.2.0"), author("the CogRSim authors"),
                summary("Bullet 3.24 as it ships, in double precision"))
