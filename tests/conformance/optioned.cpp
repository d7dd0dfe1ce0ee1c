#include "optioned.h"

#include <algorithm>

#include "forwarding_backend.h"

namespace conformance {

using namespace cogrsim;

namespace {

class OptionedBackend final : public ForwardingBackend {
 public:
  OptionedBackend(std::shared_ptr<const Backend> backend, std::string name, std::string value)
      : ForwardingBackend(std::move(backend)), option_(std::move(name)), value_(std::move(value)) {}

  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const override {
    auto changed = std::make_shared<SceneModel>(*model);
    changed->physics.engine_options[name()][option_] = value_;
    return backend_->create_world(changed);
  }

 private:
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
