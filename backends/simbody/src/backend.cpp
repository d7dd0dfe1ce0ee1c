// The plugin: a stateless factory of Simbody worlds.
#include <LinearMath/btAlignedAllocator.h>

#include <new>
#include <string>

#include "engine.h"

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/backend_plugin.h"
#include "cogrsim/physics/hosted_backend.h"

namespace cogrsim::simbody {

namespace {

Capabilities make_capabilities() {
  Capabilities out;
  set_shape_features(out);
  set_pair_notes(out, [](ShapeType, ShapeType) {
    return "compliant: 1 kg penetrates by 0.06 mm or less, bodies creep at up to 1 cm/s under "
           "friction that should hold (transition-velocity)";
  });
  set_joint_features(out);
  for (const JointType type : kJointTypes) {
    if (type == JointType::fixed || type == JointType::free) continue;
    const std::string name = to_string(type);
    out.set("joint.limit." + name, Support::approximate,
            "a stiff spring (MobilityLinearStop), passed by some mrad or 0.1 mm");
    out.set("joint.friction." + name, Support::approximate,
            "a drive towards rest with a bound, its effort constant over a step");
    out.set("joint.rotor-inertia." + name, Support::exact);
  }
  out.set("joint.coupling", Support::exact);
  out.set("joint.coupling-effort", Support::unsupported,
          "a constraint of Simbody's holds whatever it takes; another backend's couplings slip");
  out.set("joint.limit.ball", Support::unsupported,
          "Simbody has no stop for a ball joint; use a universal joint with limits");
  out.set("joint.stiffness.ball", Support::unsupported,
          "Simbody has no spring for a ball joint; use a universal joint");
  for (const MotorMode mode : kMotorModes)
    out.set(std::string("motor.") + to_string(mode), Support::approximate,
            "its effort is found at the start of a step and constant over it");
  out.set("motor.torque", Support::exact);
  set_world_features(out);
  out.set("contact.stiffness", Support::exact);
  out.set_all({"contact.rolling-friction", "contact.spinning-friction"}, Support::approximate,
              "turns at up to 0.01 rad/s under loads that it should hold (transition-velocity)");
  out.set("contact.surface-velocity", Support::approximate,
          "slips by up to 1 cm/s under loads that friction should carry (transition-velocity)");
  out.set(
      "runtime.save", Support::approximate,
      "exact, but for integrator=cpodes: without its history it errs otherwise, by 13 mm in 2 s");
  out.set("report.contact_force", Support::approximate,
          "mean by the trapezoidal rule over the integrator's own steps");
  out.set(
      "report.joint_effort", Support::approximate,
      "of springs, dampers and stops: mean by the trapezoidal rule over the integrator's steps");
  out.set("report.joint_reaction", Support::approximate,
          "at the end of the step, not the mean over it");
  return out;
}

std::string find_version() {
  int major = 0, minor = 0, build = 0;
  SimTK_version_simbody(&major, &minor, &build);
  return std::to_string(major) + "." + std::to_string(minor) +
         (build > 0 ? "." + std::to_string(build) : std::string());
}

class SimbodyBackend final : public HostedBackend<EngineWorld<Engine>> {
 public:
  SimbodyBackend()
      : HostedBackend(Engine::kName, find_version(), make_capabilities(), Engine::options()) {
    // Bullet's distance queries do not look whether malloc gave them memory. It keeps these for the
    // whole process, so they must be functions that are never unloaded.
    btAlignedAllocSetCustom(static_cast<void* (*)(std::size_t)>(::operator new),
                            static_cast<void (*)(void*)>(::operator delete));
  }
  Provenance provenance(const Parameters& parameters) const override {
    const Options options = options_from(parameters);
    Provenance out;
    out.engine = "Simbody";
    out.solver = "compliant contact; loops by Lagrange multipliers";
    out.formulation = "generalized coordinates";
    out.integrator = "SimTK::" + integrator_class(options.integrator);
    out.integrator += options.integrator == "semi-explicit-euler" || options.substeps > 0
                          ? ", fixed steps"
                          : ", accuracy " + option_text(ParameterValue(options.accuracy));
    const auto ours = ComputedBy::cogrsim;
    if (options.trackers) {
      out.by_engine(StepStage::broad_phase, "ContactTrackerSubsystem");
      out.by_engine(StepStage::narrow_phase, "ContactTracker::HalfSpaceSphere and the like");
      out.by_engine(StepStage::contact_memory, "ContactSnapshot");
      out.by_engine(StepStage::contact_law, "CompliantContactSubsystem");
      out.by_engine(StepStage::friction, "CompliantContactSubsystem");
      out.by_engine(StepStage::restitution, "dissipation of CompliantContactSubsystem");
    } else {
      out[StepStage::broad_phase] = {ours, "Detector"};
      out[StepStage::narrow_phase] = {ours, "Detector, with Bullet's btGjkPairDetector for hulls"};
      out[StepStage::contact_memory] = {ComputedBy::none,
                                        "points are found again in each evaluation"};
      out[StepStage::contact_law] = {ours, "Force::Custom, Hunt and Crossley's force"};
      out[StepStage::friction] = {ours, "Force::Custom, Hollars' friction"};
      out[StepStage::restitution] = {ours, "Force::Custom, Hunt and Crossley's dissipation"};
    }
    out.by_engine(StepStage::joints,
                  "MobilizedBody, loops cut by MultibodyGraphMaker and closed by "
                  "Constraint::Weld; rotors and couplings: rows of Constraint::Custom");
    out.by_engine(StepStage::limits, "Force::MobilityLinearStop");
    out[StepStage::motors] = {
        ours,
        "efforts found by Drives, applied by Force::MobilityDiscreteForce, stiff dampers' too; "
        "springs and dampers: Force::MobilityLinearSpring, MobilityLinearDamper"};
    out.by_engine(StepStage::integrator, out.integrator);
    return out;
  }
};

}  // namespace

}  // namespace cogrsim::simbody

using cogrsim::simbody::SimbodyBackend;
COGRSIM_BACKEND(SimbodyBackend, "simbody", version("0.1.0"), author("the CogRSim authors"),
                summary("Simbody 3.7 as it ships: generalized coordinates, error-controlled "
                        "integrators, compliant contact"))
