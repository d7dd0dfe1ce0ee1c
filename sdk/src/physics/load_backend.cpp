// The part of the plugin loader that knows backends.
#include <exception>

#include <fmt/format.h>

#include "cogrsim/physics/backend.h"
#include "cogrsim/physics/backend_choice.h"
#include "cogrsim/physics/backend_plugin.h"
#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/plugin/loader.h"
#include "physics/adapter/adapter_plugin.h"

namespace cogrsim {

Result<std::shared_ptr<const Backend>> PluginLoader::backend(const std::string& text) {
  const auto choice = parse_backend_choice(text);
  if (!choice) return tl::unexpected<Error>(choice.error());
  const std::string& name = choice->name;
  const Result<PluginPtr> plugin = load(PluginKind::backend, name);
  if (!plugin) return tl::unexpected<Error>(plugin.error());
  const auto* entry = static_cast<const BackendEntry*>((*plugin)->descriptor().factory);
  std::string problem;
  const PluginCall call("backend", name.c_str(), "", "", "while it was started");
  try {
    const Backend* backend = nullptr;
    if (entry->get) {
      backend = entry->get();
    } else {
      const auto made = static_cast<const AdapterEntry*>(entry)->backend();
      if (!made) return tl::unexpected<Error>(made.error());
      backend = made->get();
    }
    if (backend) {
      if (const auto fine = option_values(*choice, backend->world_options()); !fine) {
        return tl::unexpected<Error>(fine.error());
      }
      return std::shared_ptr<const Backend>(*plugin, backend);  // keeps the library, not the object
    }
  } catch (const std::exception& e) {
    problem = ": " + message_of(e);
  }
  return fail(fmt::format("backend '{}' did not start{}", name, problem), (*plugin)->path(), "",
              "CG0902");
}

}  // namespace cogrsim
