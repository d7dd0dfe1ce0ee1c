// The plugin: a stateless factory of ODE worlds.
#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/backend_plugin.h"
#include "library.h"
#include "world.h"

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
  const auto set = [&](const std::string& joint, std::initializer_list<const char*> parts,
                       Support support, const char* note) {
    for (const std::string part : parts) out.set(part + joint, support, note);
  };
  const Support lacks = Support::unsupported, differs = Support::approximate;
  set("screw",
      {"joint.", "loop.", "joint.limit.", "joint.damping.", "joint.friction.", "joint.stiffness."},
      lacks, "ODE has no screw");
  set("gimbal",
      {"joint.", "loop.", "joint.limit.", "joint.damping.", "joint.friction.", "joint.stiffness."},
      lacks, "three hinges with light bodies between them do the same");
  set("ball", {"joint.limit.", "joint.stiffness."}, lacks, "ODE's ball joint has no stops");
  set("ball", {"joint.friction."}, lacks, "three motors would bound each axis by itself");
  set("planar", {"joint.limit."}, lacks, "ODE's LMotor has no stops");
  set("planar", {"joint.", "loop."}, differs,
      "two angles stopped (AMotor) and no speed along the normal (LMotor), whose position drifts");
  set("planar", {"joint.damping.", "joint.friction."}, differs,
      "ODE's LMotor acts half-way between the centres of mass");
  for (const JointType type : {JointType::hinge, JointType::slider, JointType::cylindrical,
                               JointType::universal, JointType::planar}) {
    set(to_string(type), {"joint.stiffness."}, differs,
        "an explicit torque: unstable beyond a stiffness of 4 times the inertia over the step "
        "squared");
    set(to_string(type), {"joint.rotor-inertia."}, differs,
        "a motor towards the speed at the start of the step, as soft as the inertia; with "
        "solver=quick 20 sweeps hold rotors of 10 times the inertia of the bodies they turn");
    if (type == JointType::planar) continue;
    set(to_string(type), {"joint.limit."}, differs,
        "ODE's stops act once they are passed and give back erp (0.2) of the speed");
  }
  out.set_all({"body.static", "body.kinematic", "body.gravity-scale", "body.force", "runtime.add",
               "runtime.remove", "runtime.save", "runtime.set_state", "runtime.joint_axes",
               "report.joint_reaction", "report.joint_effort"},
              Support::exact);
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
    out[StepStage::contact_memory] = {ComputedBy::none,
                                      "no memory: each step finds its contacts again"};
    engine(StepStage::contact_law, "dJointCreateContact");
    engine(StepStage::friction, std::get<std::string>(options.at("friction")) == "pyramid"
                                    ? "dContactApprox1, a pyramid"
                                    : "dContactApprox0, a box");
    engine(StepStage::restitution, "dContactBounce");
    engine(StepStage::joints,
           "hinge, slider, ball, universal, piston, fixed; planar: AMotor and LMotor");
    engine(StepStage::limits, "dParamLoStop, dParamHiStop");
    engine(StepStage::motors,
           "dParamVel, dParamFMax, dParamCFM; torques and springs by dBodyAddTorque");
    engine(StepStage::integrator, "dxStepBody");
    return out;
  }
  const Capabilities& capabilities() const override { return capabilities_; }
  const ParameterTable& world_options() const override { return world_option_table(); }
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
