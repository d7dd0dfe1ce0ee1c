#include <fmt/format.h>

#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/rendering/renderer.h"

namespace cogrsim {

namespace {
constexpr const char* kDefaultRenderer = "osmesa";
}

Result<std::shared_ptr<Renderer>> load_renderer(PluginLoader& loader, const std::string& name) {
  const std::string wanted = name.empty() ? kDefaultRenderer : name;
  const Result<PluginPtr> plugin = loader.load(PluginKind::renderer, wanted);
  if (!plugin) return tl::unexpected<Error>(plugin.error());
  const auto* entry = static_cast<const RendererEntry*>((*plugin)->descriptor().factory);
  std::string problem;
  const PluginCall call("renderer", wanted.c_str(), "", "", "while it was started");
  if (Renderer* renderer = entry->create(&problem)) {
    return std::shared_ptr<Renderer>(
        renderer, [keep = *plugin, destroy = entry->destroy](Renderer* r) { destroy(r); });
  }
  return fail(fmt::format("renderer '{}' did not start: {}", wanted, problem), (*plugin)->path(),
              "", "CG0902");
}

}  // namespace cogrsim
