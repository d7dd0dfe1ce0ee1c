// The plugin: a stateless factory of MuJoCo worlds.
#include "options.h"
#include "world.h"

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/backend_plugin.h"
#include "cogrsim/physics/hosted_backend.h"

namespace cogrsim::mujoco {

namespace {

Capabilities make_capabilities() {
  Capabilities out;
  set_shape_features(out);
  const char* const soft =
      "soft contact: rests in penetration, slides slowly under friction that should hold, bounces "
      "approximately; one point where flat sides of cylinders and meshes meet anything but planes "
      "(multiccd: several)";
  set_pair_notes(out, [&](ShapeType, ShapeType) { return soft; });
  for (const ShapeType other : kShapeTypes)
    if (!is_surface(other))
      out.set(pair_feature(ShapeType::mesh, other), Support::unsupported,
              "MuJoCo has meshes as their convex hulls only; use convex meshes");
  out.set("shape.convex-mesh", Support::approximate, "MuJoCo stores its corners as floats");
  out.set("shape.heightmap", Support::approximate, "MuJoCo stores its heights as floats");
  set_joint_features(out);
  for (const JointType type : kJointTypes) {
    const std::string name = to_string(type);
    if (type != JointType::free) {
      out.set("loop." + name, Support::unsupported,
              "MuJoCo closes loops by points and welds: let a hinge, ball or fixed joint of the "
              "loop be the last one in the file");
    }
    if (type == JointType::fixed || type == JointType::free) continue;
    out.set("joint.rotor-inertia." + name, Support::exact);
    out.set("joint.limit." + name, Support::approximate, "a soft stop, see solreflimit");
    out.set("joint.friction." + name, Support::approximate,
            std::string("slides slowly under loads that it should hold, see solreffriction") +
                (type == JointType::ball ? "; on each of three axes by itself" : ""));
    out.set("joint.stiffness." + name, Support::approximate,
            "an explicit spring: unstable where stiffness times step squared exceeds four times "
            "the inertia");
  }
  out.set("joint.screw", Support::approximate,
          "its travel is tied to its angle by a soft constraint, see solrefequality");
  out.set("joint.coupling", Support::approximate,
          "a soft constraint, see solrefequality; its effort is not reported");
  for (const char* loop : {"loop.hinge", "loop.ball", "loop.fixed"})
    out.set(loop, Support::approximate, "held by a soft constraint, see solrefequality");
  out.set_all({"motor.velocity", "motor.position"}, Support::approximate,
              "an explicit actuator with the gain that stops the axis in a step: lags by load over "
              "gain");
  out.set("contact.stiffness", Support::unsupported,
          "MuJoCo's contacts yield by acceleration, not by force: see solref and solimp");
  out.set("contact.surface-velocity", Support::unsupported,
          "MuJoCo has no velocity of surfaces; use a kinematic body");
  out.set_all({"contact.rolling-friction", "contact.spinning-friction"}, Support::approximate,
              "one pyramid with sliding; slides slowly, as friction does");
  set_world_features(out);
  out.set(
      "runtime.attach", Support::approximate,
      "by a plain hinge, ball or fixed joint: a soft constraint, see solrefequality, that stops "
      "what it forbids in some hundredths of a second");
  out.set("runtime.body_kind", Support::approximate,
          "bodies jointed to one that is made static keep their joint speeds, not their momentum");
  out.set("report.joint_reaction", Support::approximate,
          "of joints in trees only; zero for those that close loops or attach bodies");
  return out;
}

}  // namespace

class MujocoBackend final : public HostedBackend<MujocoWorld> {
 public:
  MujocoBackend()
      : HostedBackend("mujoco", mj_versionString(), make_capabilities(), world_option_table()) {
    install_handlers();
  }
  Provenance provenance(const Parameters& options) const override {
    const auto text = [&](const char* key) { return value_of<std::string>(options, key); };
    const std::string solver = text("solver"), integrator = text("integrator");
    const std::string solve = "mj_sol" + solver;
    Provenance out;
    out.engine = "MuJoCo";
    out.solver = (solver == "Newton" ? "Newton's method, "
                  : solver == "PGS"  ? "projected Gauss-Seidel, "
                                     : "conjugate gradients, ") +
                 text("cone") + " cones";
    out.formulation = "generalized coordinates, soft constraints";
    out.integrator = integrator == "RK4"        ? "Runge-Kutta 4"
                     : integrator == "implicit" ? "implicit in velocity"
                                                : "semi-implicit Euler";
    out.by_engine(StepStage::broad_phase, "mj_collision: mj_broadphase");
    out.by_engine(StepStage::narrow_phase, "mj_collision: mjCOLLISIONFUNC");
    out.by_engine(StepStage::contact_memory, "mjData::qacc_warmstart");
    out.by_engine(StepStage::contact_law, "mj_makeConstraint, " + solve);
    out.by_engine(StepStage::friction,
                  "mj_makeConstraint (damping of bounces by CogRSim), " + solve);
    out.by_engine(StepStage::restitution, "solref of a damped spring");
    out.by_engine(StepStage::joints, "mjModel's joints, loops by mjEQ_CONNECT and mjEQ_WELD");
    out.by_engine(StepStage::limits, "mjCNSTR_LIMIT_JOINT, " + solve);
    out.by_engine(StepStage::motors,
                  "mj_fwdActuation, mj_passive (stiff gains by CogRSim), mjCNSTR_FRICTION_DOF");
    out.by_engine(StepStage::integrator,
                  integrator == "RK4" ? "mj_RungeKutta" : "mj_" + integrator);
    return out;
  }
  const ParameterTable& element_options(std::string_view element) const override {
    return element_option_table(element);
  }
};

}  // namespace cogrsim::mujoco

COGRSIM_BACKEND(cogrsim::mujoco::MujocoBackend, "mujoco", version("0.1.0"),
                author("the CogRSim authors"),
                summary("MuJoCo as it ships: generalized coordinates, soft constraints"))
