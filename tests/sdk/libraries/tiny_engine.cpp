#include "cogrsim/physics/backend_plugin.h"

namespace {
class TinyEngine final : public cogrsim::Backend {
 public:
  const char* name() const override { return "tiny_engine"; }
  const char* engine_version() const override { return "0.1"; }
  cogrsim::Provenance provenance(const cogrsim::Parameters&) const override { return {}; }
  const cogrsim::Capabilities& capabilities() const override { return capabilities_; }
  const cogrsim::ParameterTable& world_options() const override { return none_; }
  cogrsim::Result<std::unique_ptr<cogrsim::World>> create_world(
      const cogrsim::SceneModelPtr&) const override {
    return cogrsim::fail("the tiny engine has no worlds");
  }

 private:
  cogrsim::Capabilities capabilities_;
  cogrsim::ParameterTable none_;
};
}  // namespace

COGRSIM_BACKEND(TinyEngine, "tiny_engine", version("0.1.0"))
