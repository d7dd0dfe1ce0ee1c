// Answers the scene compiler's questions about plugins with what the loader finds.
#pragma once

#include <memory>
#include <optional>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/plugin/loader.h"

namespace cogrsim::cli {

class LoaderCatalog final : public dsl::PluginCatalog {
 public:
  explicit LoaderCatalog(std::shared_ptr<PluginLoader> loader) : loader_(std::move(loader)) {}

  /// The SDK's own sensors, then libraries.
  Result<ParameterTable> parameters(PluginKind kind, const std::string& name) override;
  std::vector<OutputModel> outputs(PluginKind kind, const std::string& name) override;
  std::vector<Channel> channels(const SceneModel& model, const SensorModel& sensor) override;
  std::vector<std::string> names(PluginKind kind) override;
  Result<ParameterTable> world_options(const std::string& backend) override;
  Result<ParameterTable> assembly_options(const std::string& backend) override;

 private:
  std::shared_ptr<PluginLoader> loader_;
  std::optional<std::vector<PluginPtr>> all_;  // looked up once
};

}  // namespace cogrsim::cli
