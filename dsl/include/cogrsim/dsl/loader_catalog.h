// Answers the scene compiler's questions about plugins with a plugin loader.
//
//     const auto loader = std::make_shared<PluginLoader>();
//     dsl::LoaderCatalog catalog(loader);
//     dsl::CompileOptions options;
//     options.plugins = &catalog;
//     const dsl::CompileResult scene = dsl::compile_file("robot.scene.xml", options);
//     if (!scene.ok()) …
//     auto run = Simulation::create(scene.model, {}, loader);
#pragma once

#include <memory>
#include <optional>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/plugin/loader.h"

namespace cogrsim::dsl {

/// The SDK's own sensors, and the libraries that the loader finds. Asking loads a library, which
/// runs code of it. For one thread at a time.
class COGRSIM_API LoaderCatalog final : public PluginCatalog {
 public:
  /// Without a loader: one that looks in the usual folders.
  explicit LoaderCatalog(std::shared_ptr<PluginLoader> loader = std::make_shared<PluginLoader>())
      : loader_(std::move(loader)) {}

  Result<ParameterTable> parameters(PluginKind kind, const std::string& name) override;
  std::vector<OutputModel> outputs(PluginKind kind, const std::string& name) override;
  std::vector<Channel> channels(const SceneModel& model, const SensorModel& sensor) override;
  std::vector<std::string> names(PluginKind kind) override;
  Result<ParameterTable> world_options(const std::string& backend) override;
  Result<ParameterTable> element_options(const std::string& backend,
                                         std::string_view element) override;

 private:
  std::shared_ptr<PluginLoader> loader_;
  std::optional<std::vector<PluginPtr>> all_;  // looked up once
};

}  // namespace cogrsim::dsl
