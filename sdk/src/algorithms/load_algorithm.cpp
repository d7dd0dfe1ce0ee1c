#include <fmt/format.h>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/algorithms/learner.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/plugin/loader.h"
#include "simulation/impl.h"

namespace cogrsim {

namespace {

/// Where a learner's table lies: in the output folder of the run. Errors: elsewhere.
Result<> place_table(Parameters& parameters, const std::string& scene_folder) {
  const auto table = parameters.find("table");
  if (table == parameters.end()) return {};
  auto* file = std::get_if<std::string>(&table->second);
  if (file == nullptr || file->empty() || scene_folder.empty())
    return {};  // a program's own choice
  const std::string folder = output_folder(scene_folder);
  const auto place = output_in(folder, *file);
  if (!place) return tl::unexpected(place.error());
  OutputRules rules;
  rules.folder = folder;
  rules.overwrite = true;  // one that is there is read first, and refused where it is no table
  if (auto allowed = check_output(*place, OutputKind::learner, rules); !allowed) return allowed;
  *file = *place;
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
    if (auto placed = place_table(*complete, folder); !placed) {
      return tl::unexpected(placed.error());
    }
  }
  void* made = nullptr;
  if (const auto thrown = entry->create(*complete, seed, made)) {
    return fail(fmt::format("algorithm '{}' did not start: {}", name, *thrown));
  }
  return std::shared_ptr<void>(
      made, [keep = *plugin, destroy = entry->destroy](void* object) { destroy(object); });
}

std::shared_ptr<void> Assembly::find_algorithm(const std::string& name, const char* family,
                                               const Parameters& parameters) {
  Simulation::Impl& simulation = *access_->simulation;
  // Two algorithms of a controller, and two controllers with the same algorithm, draw apart.
  const std::string path = access_->mind + "." + name;
  const std::uint64_t seed = RandomStream(simulation.original->physics.seed, path).next();
  auto made = load_algorithm_of(*simulation.loader, name, family, parameters, seed,
                                scene_folder().empty() ? "." : scene_folder());
  if (made) return *made;
  std::string mistake = made.error().message;
  if (!made.error().hint.empty()) mistake += "; " + made.error().hint;
  access_->mistakes.push_back(std::move(mistake));
  return nullptr;
}

}  // namespace cogrsim
