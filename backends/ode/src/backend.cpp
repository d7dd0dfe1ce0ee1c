// The plugin: a stateless factory of ODE worlds.
#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/backend_plugin.h"
#include "cogrsim/physics/hosted_backend.h"
#include "engine.h"

namespace cogrsim::ode {

namespace {

/// Why a pair is not exact; null: it is.
const char* pair_note(ShapeType a, ShapeType b) {
  const auto is = [&](ShapeType x, ShapeType y) {
    return (a == x && b == y) || (a == y && b == x);
  };
  const auto any = [&](ShapeType x) { return a == x || b == x; };
  using T = ShapeType;
  if (any(T::mesh) || any(T::heightmap)) {
    return "ODE tests triangles one by one: solid from their outer side only, with bumps at the "
           "seams";
  }
  if (is(T::plane, T::cylinder)) {
    return "a cylinder on its side bears on two ends of a line that share its load at will: wheels "
           "roll on one rim, 3 % off on an arc and 9 % turning on the spot";
  }
  if (any(T::plane) || (any(T::sphere) && !any(T::convex_mesh))) return nullptr;
  if (is(T::box, T::cylinder)) {
    return "ODE clips the cylinder's end as an octagon around it: it bears 8 % farther out at "
           "eight points";
  }
  if (any(T::convex_mesh)) {
    return "libccd, with which Debian builds ODE, finds one point a step: faces lean by up to 0.07 "
           "rad, and what is struck flat turns (10 to 24 % of the speed)";
  }
  if (any(T::cylinder) || is(T::box, T::capsule)) {
    return "one point unless two ends or two sides lie flat on each other: what hits along a line "
           "turns (11 to 20 % of the speed)";
  }
  return nullptr;
}

Capabilities make_capabilities() {
  Capabilities out;
  set_shape_features(out);
  set_pair_notes(out, pair_note);
  set_joint_features(out);
  const auto set = [&](JointType joint, std::initializer_list<const char*> parts, Support support,
                       const char* note) { set_joint_parts(out, joint, parts, support, note); };
  const Support lacks = Support::unsupported, differs = Support::approximate;
  lack_joint(out, JointType::screw, "ODE has no screw");
  lack_joint(out, JointType::gimbal, "three hinges with light bodies between them do the same");
  set(JointType::ball, {"joint.limit.", "joint.stiffness."}, lacks,
      "ODE's ball joint has no stops");
  set(JointType::ball, {"joint.friction."}, lacks, "three motors would bound each axis by itself");
  set(JointType::planar, {"joint.limit."}, lacks, "ODE's LMotor has no stops");
  set(JointType::planar, {"joint.", "loop."}, differs,
      "two angles stopped (AMotor) and no speed along the normal (LMotor), whose position drifts");
  set(JointType::planar, {"joint.damping.", "joint.friction."}, differs,
      "ODE's LMotor acts half-way between the centres of mass");
  for (const JointType type : {JointType::hinge, JointType::slider, JointType::cylindrical,
                               JointType::universal, JointType::planar}) {
    set(type, {"joint.stiffness."}, differs,
        "an explicit torque: unstable beyond a stiffness of 4 times the inertia over the step "
        "squared");
    set(type, {"joint.rotor-inertia."}, differs,
        "a motor towards the speed at the start of the step, as soft as the inertia; with "
        "solver=quick 20 sweeps hold rotors of 10 times the inertia of the bodies they turn");
    if (type == JointType::planar) continue;
    set(type, {"joint.limit."}, differs,
        "ODE's stops act once they are passed and give back erp (0.2) of the speed");
  }
  set_world_features(out);
  out.set("joint.coupling", differs,
          "an effort found before each step and constant over it, which all its joints feel");
  out.set("joint.coupling-effort", Support::exact);
  out.set("contact.stiffness", differs, "a spring and damper for each point of contact");
  out.set("contact.surface-velocity", differs, "friction is a pyramid along and across it");
  out.set("contact.rolling-friction", differs, "bounded about each of two axes by itself");
  out.set("contact.spinning-friction", differs, "bounded by the load as it is without friction");
  out.set("runtime.attach", differs, "the joint removes the forbidden velocities in the next step");
  out.set("runtime.body_kind", differs, "connected bodies are stopped in the next step");
  out.set("report.contact_force", differs,
          "as QuickStep's 20 sweeps leave them: up to 62 % off in single steps of a stack of 10");
  return out;
}

}  // namespace

class OdeBackend final : public HostedBackend<EngineWorld<Engine>> {
 public:
  OdeBackend()
      : HostedBackend(
            Engine::kName,
            library_version(COGRSIM_ODE_VERSION, reinterpret_cast<const void*>(&dWorldStep)),
            make_capabilities(), Engine::options()) {}
  Provenance provenance(const Parameters& options) const override {
    const std::string& solver = value_of<std::string>(options, "solver");
    Provenance out;
    out.engine = "Open Dynamics Engine";
    const std::string step = "dWorldStep (Dantzig's LCP)";
    const std::string quick = "dWorldQuickStep (projected Gauss-Seidel with over-relaxation)";
    out.solver = solver == "step"    ? step
                 : solver == "quick" ? quick
                                     : step + " where there are joints, else " + quick;
    out.formulation = "maximal coordinates";
    out.integrator = "semi-implicit Euler";
    out.by_engine(StepStage::broad_phase, "dHashSpace");
    out.by_engine(StepStage::narrow_phase, "dCollide");
    out[StepStage::contact_memory] = {ComputedBy::none,
                                      "no memory: each step finds its contacts again"};
    out.by_engine(StepStage::contact_law, "dJointCreateContact");
    out.by_engine(StepStage::friction, value_of<std::string>(options, "friction") == "pyramid"
                                           ? "dContactApprox1, a pyramid"
                                           : "dContactApprox0, a box");
    out.by_engine(StepStage::restitution, "dContactBounce");
    out.by_engine(StepStage::joints,
                  "hinge, slider, ball, universal, piston, fixed; planar: AMotor and LMotor");
    out.by_engine(StepStage::limits, "dParamLoStop, dParamHiStop");
    out.by_engine(StepStage::motors,
                  "dParamVel, dParamFMax, dParamCFM; torques and springs by dBodyAddTorque");
    out.by_engine(StepStage::integrator, "dxStepBody");
    return out;
  }
};

}  // namespace cogrsim::ode

COGRSIM_BACKEND(cogrsim::ode::OdeBackend, "ode", version("0.2.0"), author("the CogRSim authors"),
                summary("the Open Dynamics Engine 0.16 as it is: contact joints, its joints, "
                        "dWorldStep or dWorldQuickStep"))
