#include <fmt/format.h>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/algorithms/learner.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/plugin/loader.h"

namespace cogrsim {

namespace {

/// Path of the table of a learner, which must be in the output folder of the run. Errors: it is
/// not.
Result<> resolve_table(Parameters& parameters, const std::string& scene_folder) {
  const auto table = parameters.find("table");
  if (table == parameters.end()) return {};
  auto* file = std::get_if<std::string>(&table->second);
  if (file == nullptr || file->empty() || scene_folder.empty())
    return {};  // chosen by a program
  const std::string folder = output_folder(scene_folder);
  const auto path = output_in(folder, *file);
  if (!path) return tl::unexpected(path.error());
  OutputRules rules;
  rules.folder = folder;
  rules.overwrite = true;  // an existing file is read first, and rejected unless it is a table
  if (auto allowed = check_output(*path, OutputKind::learner, rules); !allowed) return allowed;
  *file = *path;
  return {};
}

}  // namespace

Result<std::shared_ptr<void>> load_algorithm_of(PluginLoader& loader, const std::string& name,
                                                const char* family, const Parameters& parameters,
                                                std::uint64_t seed, const std::string& folder) {
  const Result<PluginPtr> plugin = loader.load(PluginKind::algorithm, name);
  if (!plugin) return tl::unexpected<Error>(plugin.error());
  const PluginDescriptor& descriptor = (*plugin)->descriptor();
  const auto* entry = static_cast<const AlgorithmEntry*>(descriptor.factory);
  if (std::string(entry->family) != family) {
    return fail(fmt::format("'{}' is a {}, and was asked for as a {}", name, entry->family, family),
                (*plugin)->path(), "", "CG0903");
  }
  Result<Parameters> complete = complete_parameters(descriptor.parameters, parameters);
  if (!complete) {
    return fail(fmt::format("algorithm '{}': {}", name, complete.error().message), "", "",
                "CG0904");
  }
  if (std::string(family) == Learner::kFamily) {
    if (auto resolved = resolve_table(*complete, folder); !resolved) {
      return tl::unexpected(resolved.error());
    }
  }
  void* made = nullptr;
  if (const auto thrown = entry->create(*complete, seed, made)) {
    return fail(fmt::format("algorithm '{}' did not start: {}", name, *thrown));
  }
  return std::shared_ptr<void>(
      made, [keep = *plugin, destroy = entry->destroy](void* object) { destroy(object); });
}

}  // namespace cogrsim
