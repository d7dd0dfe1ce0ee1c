// The plugin: a stateless factory of Bullet worlds.
#include <LinearMath/btAlignedAllocator.h>

#include <new>

#include "bullet_world.h"
#include "capabilities.h"

#include "cogrsim/physics/backend_plugin.h"

namespace cogrsim::bullet {

class BulletBackend final : public Backend {
 public:
  BulletBackend() {
    // Bullet does not look whether malloc gave it memory, and would write through a null pointer. It
    // keeps these for the whole process, so they must be functions that are never unloaded.
    btAlignedAllocSetCustom(static_cast<void* (*)(std::size_t)>(::operator new),
                            static_cast<void (*)(void*)>(::operator delete));
  }
  const char* name() const override { return "bullet"; }
  const char* engine_version() const override {
    static const std::string version =
        std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
    return version.c_str();
  }
  Provenance provenance(const Parameters& options) const override {
    Provenance out;
    out.engine = "Bullet Physics";
    out.solver = "cogrsim: sequential impulses in groups";
    out.formulation = std::get<std::string>(options.at("formulation"));
    out.integrator = "cogrsim: midpoint";
    for (const StepStage stage : kStepStages) out[stage] = {ComputedBy::cogrsim, "cogrsim::bullet"};
    out[StepStage::broad_phase] = {ComputedBy::engine, "btDbvtBroadphase"};
    return out;
  }
  const Capabilities& capabilities() const override { return capabilities_; }
  const ParameterTable& world_options() const override { return world_option_table(); }
  const ParameterTable& assembly_options() const override { return assembly_option_table(); }
  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const override {
    return BulletWorld::create(model);
  }

 private:
  Capabilities capabilities_ = make_capabilities();
};

}  // namespace cogrsim::bullet

COGRSIM_BACKEND(cogrsim::bullet::BulletBackend, "bullet", version("0.1.0"),
                author("the CogRSim authors"),
                summary("Bullet 3.24: fast rigid bodies with hard contact"))
