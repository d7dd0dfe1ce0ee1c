// A backend whose worlds are all of one class that stands on HostedWorld. For backends; header only.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "cogrsim/physics/backend.h"
#include "cogrsim/physics/hosted_world.h"

namespace cogrsim {

/// What is left to a backend is its provenance. `HostedWorldType` has a default constructor.
template <class HostedWorldType>
class HostedBackend : public Backend {
 public:
  const char* name() const final { return name_; }
  const char* engine_version() const final { return engine_version_.c_str(); }
  const Capabilities& capabilities() const final { return capabilities_; }
  const ParameterTable& world_options() const final { return world_options_; }
  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const final {
    auto world = std::make_unique<HostedWorldType>();
    if (auto started = world->start(model); !started) return tl::unexpected<Error>(started.error());
    return world;
  }

 protected:
  HostedBackend(const char* name, std::string engine_version, Capabilities capabilities,
                const ParameterTable& world_options)
      : name_(name),
        engine_version_(std::move(engine_version)),
        capabilities_(std::move(capabilities)),
        world_options_(world_options) {}

 private:
  const char* name_;
  std::string engine_version_;
  Capabilities capabilities_;
  const ParameterTable& world_options_;
};

}  // namespace cogrsim
