// The plugin: a stateless factory of DART worlds.
#include <dart/config.hpp>
#include <string>

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/backend_plugin.h"
#include "cogrsim/physics/hosted_backend.h"
#include "engine.h"

namespace cogrsim::dart_engine {

namespace {

/// Why a pair is not exact; null: it is.
const char* pair_note(ShapeType a, ShapeType b) {
  const auto is = [&](ShapeType x) { return a == x || b == x; };
  using T = ShapeType;
  if (is(T::mesh) || is(T::heightmap) || is(T::convex_mesh))
    return "ODE's triangles, in single precision, one by one: solid from their outer side only, "
           "with "
           "bumps at the seams";
  if (is(T::cylinder) && !is(T::sphere))
    return "ODE's, by libccd where no end lies flat: one point, or two ends of a line that share "
           "their load at will";
  if (a == T::capsule && b == T::capsule) return "one point unless both lie along each other";
  return nullptr;
}

Capabilities make_capabilities() {
  Capabilities out;
  set_shape_features(out);
  set_pair_notes(out, pair_note);
  set_joint_features(out);
  const Support lacks = Support::unsupported, differs = Support::approximate;
  for (const JointType type : kJointTypes) {
    const std::string name = to_string(type);
    if (type == JointType::fixed || type == JointType::free) continue;
    out.set("loop." + name, differs,
            "the joint holds a half of its body, welded to the other half by WeldJointConstraint, "
            "which takes away 0.01 of an error in a step");
    if (type == JointType::ball) continue;
    out.set("joint.rotor-inertia." + name, Support::exact);
    out.set(
        "joint.stiffness." + name, differs,
        "taken implicitly and before contacts are known: it loses energy, of the first order of "
        "the step");
  }
  out.set("loop.fixed", differs, "WeldJointConstraint takes away 0.01 of an error in a step");
  out.set("joint.limit.ball", lacks, "DART bounds the coordinates of a turn one by one");
  out.set("joint.friction.ball", lacks, "DART bounds the friction of each axis by itself");
  out.set("joint.stiffness.ball", differs, "taken implicitly and before contacts are known");
  out.set("joint.gimbal", differs, "the run ends where the second angle is a right one");
  set_world_features(out);
  out.set_all({"joint.coupling", "joint.coupling-effort"}, Support::exact);
  out.set("runtime.joint_axes", differs,
          "DART's limits stop what is beyond them and never bring it back");
  out.set("contact.stiffness", lacks, "DART's contacts of rigid bodies have none");
  out.set("contact.surface-velocity", lacks, "DART 6.12's contacts know no motion of a surface");
  out.set_all({"contact.rolling-friction", "contact.spinning-friction"}, lacks,
              "DART's contacts have no torques");
  return out;
}

const void* in_libdart() {
  using Create = dart::simulation::WorldPtr (*)(const std::string&);
  return reinterpret_cast<const void*>(static_cast<Create>(&dart::simulation::World::create));
}

}  // namespace

class DartBackend final : public HostedBackend<EngineWorld<Engine>> {
 public:
  DartBackend()
      : HostedBackend(Engine::kName, library_version(DART_VERSION, in_libdart()),
                      make_capabilities(), Engine::options()) {}
  Provenance provenance(const Parameters& options) const override {
    const bool pgs = value_of<std::string>(options, "lcp-solver") == "pgs";
    Provenance out;
    out.engine = "DART";
    out.solver = pgs ? "boxed LCP by PgsBoxedLcpSolver"
                     : "boxed LCP by DantzigBoxedLcpSolver, PgsBoxedLcpSolver where that fails";
    out.formulation = "generalized coordinates";
    out.integrator = "semi-implicit Euler";
    out.by_engine(StepStage::broad_phase, "OdeCollisionDetector (ODE's dHashSpace)");
    out.by_engine(StepStage::narrow_phase, "OdeCollisionDetector (ODE's dCollide)");
    out[StepStage::contact_memory] = {ComputedBy::none,
                                      "no memory: each step finds its contacts again"};
    out.by_engine(StepStage::contact_law, "ContactConstraint");
    out.by_engine(StepStage::friction, "ContactConstraint, a pyramid about world axes");
    out.by_engine(StepStage::restitution, "ContactConstraint");
    out.by_engine(
        StepStage::joints,
        "RevoluteJoint, PrismaticJoint, ScrewJoint, BallJoint, WeldJoint, FreeJoint, rows of "
        "them; loops: WeldJointConstraint; rotors and couplings: rows of ConstraintBase");
    out.by_engine(StepStage::limits, "JointConstraint");
    out.by_engine(
        StepStage::motors,
        "rows of ConstraintBase and Joint::setCommand; springs, dampers and dry friction: the "
        "joints' own");
    out.by_engine(StepStage::integrator, "World::step");
    return out;
  }
};

}  // namespace cogrsim::dart_engine

COGRSIM_BACKEND(
    cogrsim::dart_engine::DartBackend, "dart", version("0.1.0"), author("the CogRSim authors"),
    summary("DART 6.12 as it is: trees of joints in generalized coordinates, contacts by "
            "a boxed LCP"))
