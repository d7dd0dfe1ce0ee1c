#include "optioned.h"

#include <algorithm>

namespace conformance {

using namespace cogrsim;

namespace {

class OptionedBackend final : public Backend {
 public:
  OptionedBackend(std::shared_ptr<const Backend> backend, std::string name, std::string value)
      : backend_(std::move(backend)), option_(std::move(name)), value_(std::move(value)) {}

  const char* name() const override { return backend_->name(); }
  const char* engine_version() const override { return backend_->engine_version(); }
  Provenance provenance(const Parameters& options) const override {
    return backend_->provenance(options);
  }
  const Capabilities& capabilities() const override { return backend_->capabilities(); }
  const ParameterTable& world_options() const override { return backend_->world_options(); }
  const ParameterTable& assembly_options() const override { return backend_->assembly_options(); }

  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const override {
    auto changed = std::make_shared<SceneModel>(*model);
    changed->physics.engine_options[name()][option_] = value_;
    return backend_->create_world(changed);
  }

 private:
  std::shared_ptr<const Backend> backend_;
  std::string option_, value_;
};

}  // namespace

Result<std::shared_ptr<const Backend>> with_option(std::shared_ptr<const Backend> backend,
                                                   const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos) return fail("'" + text + "': write name=value");
  const std::string option = text.substr(0, equals);
  const ParameterTable& table = backend->world_options();
  const bool known = std::any_of(table.begin(), table.end(), [&](const ParameterSpec& spec) {
    return spec.name == option && spec.type() == ParameterType::text;
  });
  if (!known) {
    return fail(std::string(backend->name()) + " has no text option '" + option + "' of its world");
  }
  return std::make_shared<OptionedBackend>(std::move(backend), option, text.substr(equals + 1));
}

}  // namespace conformance
