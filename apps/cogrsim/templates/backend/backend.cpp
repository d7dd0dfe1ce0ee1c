// The backend @NAME@: its capabilities, its options, and its worlds.
#include <memory>
#include <string>
#include <variant>

#include <cogrsim/physics/backend_checks.h>
#include <cogrsim/physics/backend_plugin.h>

#include "world.h"

namespace {

using cogrsim::Capabilities;
using cogrsim::JointType;
using cogrsim::ShapeType;
using cogrsim::Support;

// All features of cogrsim/physics/capabilities.h: exact, approximate (state how), or unsupported
// (state why). CogRSim rejects scenes by this table before create_world() is called, with the
// reason given here, so it must be correct.
Capabilities make_capabilities() {
  Capabilities c;
  const auto cannot = [&c](const std::string& feature, const char* reason) {
    c.set(feature, Support::unsupported, reason);
  };
  for (const ShapeType a : cogrsim::kShapeTypes) {
    // A single shape is only drawn; collisions are features of pairs.
    c.set(std::string("shape.") + to_string(a), Support::exact);
    for (const ShapeType b : cogrsim::kShapeTypes) {
      cannot(pair_feature(a, b), "collisions are not computed");
    }
  }
  for (const JointType type : cogrsim::kJointTypes) {
    const std::string name = to_string(type);
    cannot("joint." + name, "bodies fly freely, there are no joints");
    cannot("loop." + name, "there are no joints");
    for (const char* what : {"limit", "damping", "friction", "stiffness"}) {
      cannot(std::string("joint.") + what + "." + name, "there are no joints");
    }
  }
  for (const cogrsim::MotorMode mode : cogrsim::kMotorModes) {
    cannot(std::string("motor.") + to_string(mode), "there are no joints to drive");
  }
  for (const char* what : {"stiffness", "rolling-friction", "spinning-friction", "surface-velocity"})
    cannot(std::string("contact.") + what, "collisions are not computed");
  cannot("body.force", "forces from outside are not applied");
  cannot("runtime.attach", "there are no joints");
  cannot("runtime.joint_axes", "there are no joints");
  cannot("report.contact_force", "collisions are not computed");
  cannot("report.joint_reaction", "there are no joints");
  cannot("report.joint_effort", "there are no joints");
  c.set_all({"body.static", "body.kinematic", "runtime.add", "runtime.remove", "runtime.save",
             "runtime.set_state", "runtime.body_kind"},
            Support::exact);
  return c;
}

class @CLASS@Backend final : public cogrsim::Backend {
 public:
  const char* name() const override { return "@NAME@"; }
  // Query the library of your engine, so that the version is that of the library in use.
  const char* engine_version() const override { return "0.1"; }
  // Every result states which code computed it: the engine, or code of this folder (cogrsim), by
  // class or function. The conformance suite rejects a backend that omits a stage.
  cogrsim::Provenance provenance(const cogrsim::Parameters&) const override {
    cogrsim::Provenance out;
    out.engine = "flight";
    out.solver = out.formulation = "none";
    out.integrator = "exact free flight";
    for (const cogrsim::StepStage stage : cogrsim::kStepStages) {
      out[stage] = {cogrsim::ComputedBy::none, "bodies fly freely"};
    }
    out[cogrsim::StepStage::integrator] = {cogrsim::ComputedBy::engine, "adapter::FlightWorld"};
    return out;
  }
  const Capabilities& capabilities() const override { return capabilities_; }
  const cogrsim::ParameterTable& world_options() const override { return options_; }

  cogrsim::Result<std::unique_ptr<cogrsim::World>> create_world(
      const cogrsim::SceneModelPtr& model) const override {
    if (!model) return cogrsim::fail("no scene given");
    if (auto possible = adapter::check_scene(*model); !possible) {
      return tl::unexpected(possible.error());
    }
    // The options in the block <@NAME@ …/> of the scene; a scene created by a program may have
    // none.
    cogrsim::Parameters given;
    if (const auto block = model->physics.engine_options.find("@NAME@");
        block != model->physics.engine_options.end()) {
      given = block->second;
    }
    const auto options = cogrsim::complete_parameters(options_, given);
    if (!options) return tl::unexpected(options.error());
    const auto substeps = static_cast<int>(std::get<std::int64_t>(options->at("substeps")));
    return std::make_unique<adapter::FlightWorld>(model, substeps);
  }

 private:
  Capabilities capabilities_ = make_capabilities();
  cogrsim::ParameterTable options_ = {
      cogrsim::parameter("substeps", 1, "number of equal parts of each step").range(1, 1000)};
};

}  // namespace

COGRSIM_BACKEND(@CLASS@Backend, "@NAME@", version("0.1.0"), author("you"),
                summary("rigid bodies in free flight"))
