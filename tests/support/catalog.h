// What the compiler asks about plugins, answered by loading them; backends have no options.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/plugin/loader.h"

namespace cogrsim::test {

class LoadingCatalog final : public dsl::PluginCatalog {
 public:
  explicit LoadingCatalog(PluginLoader& loader) : loader_(loader) {}
  Result<ParameterTable> parameters(PluginKind kind, const std::string& name) override {
    const auto plugin = loader_.load(kind, name);
    if (!plugin) return tl::unexpected(plugin.error());
    return (*plugin)->descriptor().parameters;
  }
  std::vector<std::string> names(PluginKind) override { return {}; }
  Result<ParameterTable> world_options(const std::string&) override { return ParameterTable{}; }
  Result<ParameterTable> assembly_options(const std::string&) override { return ParameterTable{}; }

 private:
  PluginLoader& loader_;
};

}  // namespace cogrsim::test
