// The backend as plugin: what it can do, its options, and its worlds.
#include <LinearMath/btAlignedAllocator.h>

#include <exception>
#include <memory>
#include <new>
#include <string>
#include <system_error>

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/backend_plugin.h"
#include "world.h"

namespace cogrsim::dynamics {
namespace {

constexpr ShapeType kShapes[] = {ShapeType::box,     ShapeType::sphere,   ShapeType::cylinder,
                                 ShapeType::capsule, ShapeType::plane,    ShapeType::convex_mesh,
                                 ShapeType::mesh,    ShapeType::heightmap};
constexpr JointType kJoints[] = {JointType::fixed,  JointType::hinge,       JointType::slider,
                                 JointType::screw,  JointType::cylindrical, JointType::universal,
                                 JointType::planar, JointType::ball,        JointType::free,
                                 JointType::gimbal};

bool is_open(ShapeType type) {
  return type == ShapeType::plane || type == ShapeType::mesh || type == ShapeType::heightmap;
}

Capabilities make_capabilities() {
  Capabilities c;
  for (ShapeType shape : kShapes) c.set(std::string("shape.") + to_string(shape), Support::exact);
  for (ShapeType a : kShapes) {
    for (ShapeType b : kShapes) {
      if (is_open(a) && is_open(b))
        c.set(pair_feature(a, b), Support::unsupported,
              "surfaces without thickness do not meet each other");
      else
        c.set(pair_feature(a, b), Support::exact);
    }
  }
  c.set("shape.mesh", Support::approximate,
        "a surface, solid below: what gets under it is let through; convex pieces are exact");
  c.set("shape.heightmap", Support::approximate,
        "a surface, solid below: what gets under it is let through");
  for (JointType joint : kJoints) {
    const std::string name = to_string(joint);
    c.set("joint." + name, Support::exact);
    c.set("loop." + name, Support::exact);
    if (joint == JointType::fixed || joint == JointType::free) continue;
    for (const char* what : {"limit", "damping", "friction", "stiffness", "rotor-inertia"})
      c.set(std::string("joint.") + what + "." + name, Support::exact);
  }
  for (const char* mode : {"velocity", "torque", "position", "servo", "dc"})
    c.set(std::string("motor.") + mode, Support::exact);
  c.set_all({"body.static", "body.kinematic", "body.gravity-scale", "body.force", "joint.coupling",
             "joint.coupling-effort", "runtime.add", "runtime.remove", "runtime.save",
             "runtime.set_state", "runtime.attach", "runtime.body_kind", "runtime.joint_axes",
             "report.contact_force", "report.joint_reaction", "report.joint_effort"},
            Support::exact);
  for (const char* what :
       {"stiffness", "rolling-friction", "spinning-friction", "surface-velocity"})
    c.set(std::string("contact.") + what, Support::exact);
  return c;
}

ParameterTable make_options() {
  return {
      parameter("integrator", "auto",
                "auto: Runge-Kutta of fourth order while nothing touches, midpoint otherwise; "
                "midpoint: always, one evaluation a step")
          .one_of({"auto", "midpoint"}),
      parameter("substeps", 1, "equal parts that each step is split into").range(1, 1000),
      parameter("iterations", 60, "most sweeps of the contact solver").range(1, 10000),
      parameter("tolerance", 1e-7, "m/s",
                "the contact solver stops when no velocity changes by more")
          .range(0.0, 1.0),
      parameter(
          "sleep", false,
          "what has been at rest for 0.5 s is not computed until contact, a motor, a force or a "
          "change of the scene wakes it"),
      parameter("threads", 1,
                "that detect and solve contacts; the results do not depend on how many there are")
          .range(1, 256),
  };
}

Result<StepperOptions> read_options(const SceneModel& model, const ParameterTable& table) {
  const auto complete = physics_options(model, "cogrsim", table);
  if (!complete) return tl::unexpected(complete.error());
  StepperOptions out;
  const Parameters& p = *complete;
  if (std::get<std::string>(p.at("integrator")) == "midpoint") out.scheme = Scheme::midpoint;
  out.substeps = int(std::get<std::int64_t>(p.at("substeps")));
  out.solver.iterations = int(std::get<std::int64_t>(p.at("iterations")));
  out.solver.tolerance = std::get<double>(p.at("tolerance"));
  out.solver.bounce_threshold = model.physics.bounce_threshold;
  out.sleep = std::get<bool>(p.at("sleep"));
  out.threads = int(std::get<std::int64_t>(p.at("threads")));
  return out;
}

class DynamicsBackend final : public Backend {
 public:
  DynamicsBackend() {
    // Bullet's collision detection does not look whether malloc gave it memory, and would write
    // through a null pointer. It keeps these for the whole process, so they must be functions that
    // are never unloaded.
    btAlignedAllocSetCustom(static_cast<void* (*)(std::size_t)>(::operator new),
                            static_cast<void (*)(void*)>(::operator delete));
  }
  const char* name() const override { return "cogrsim"; }
  const char* engine_version() const override { return COGRSIM_VERSION; }
  Provenance provenance(const Parameters& options) const override {
    Provenance out;
    out.engine = "CogRSim dynamics";
    out.solver = "projected Gauss-Seidel over islands, direct where it can";
    out.formulation = "reduced coordinates";
    out.integrator = std::get<std::string>(options.at("integrator")) == "midpoint"
                         ? "Moreau's midpoint scheme"
                         : "Moreau's midpoint scheme, Runge-Kutta 4 in free motion";
    const auto ours = [&](StepStage stage, const char* name) {
      out[stage] = {ComputedBy::cogrsim, name};
    };
    ours(StepStage::broad_phase, "Detector");
    ours(StepStage::narrow_phase, "Detector, with Bullet's btGjkPairDetector for hulls");
    ours(StepStage::contact_memory, "Manifold");
    ours(StepStage::contact_law, "Solver, impulses of non-penetration");
    ours(StepStage::friction, "Solver, Coulomb's cone");
    ours(StepStage::restitution, "Solver, Newton's law");
    ours(StepStage::joints, "Mechanism, loops by projection");
    ours(StepStage::limits, "Rows");
    ours(StepStage::motors, "Drives, implicit");
    ours(StepStage::integrator, "Stepper");
    return out;
  }
  const Capabilities& capabilities() const override { return capabilities_; }
  const ParameterTable& world_options() const override { return options_; }

  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const override {
    if (!model) return fail("no scene given");
    if (auto r = check_parts(*model); !r) return tl::unexpected<Error>(r.error());
    auto options = read_options(*model, options_);
    if (!options) return tl::unexpected<Error>(options.error());
    try {
      if (options->threads > 1) options->pool = std::make_shared<WorkerPool>(options->threads);
      return std::make_unique<DynamicsWorld>(model, *options);
    } catch (const std::system_error& e) {
      return fail(std::to_string(options->threads) + " threads cannot be started: " + e.what(),
                  source_position(*model, model->physics.origin), "set the option 'threads' lower");
    } catch (const std::exception& e) {
      return fail(message_of(e), source_position(*model, model->physics.origin));
    }
  }

 private:
  Capabilities capabilities_ = make_capabilities();
  ParameterTable options_ = make_options();
};

}  // namespace

}  // namespace cogrsim::dynamics

using cogrsim::dynamics::DynamicsBackend;
COGRSIM_BACKEND(DynamicsBackend, "cogrsim", version("0.1.0"), author("CogRSim"),
                summary("CogRSim's own dynamics: reduced coordinates, time stepping with exact "
                        "friction and limits"))
