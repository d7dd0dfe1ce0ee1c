#include "cogrsim/dsl/loader_catalog.h"

#include <algorithm>
#include <memory>

#include "cogrsim/physics/backend.h"
#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/sensing/sensor.h"

namespace cogrsim::dsl {

Result<ParameterTable> LoaderCatalog::parameters(PluginKind kind, const std::string& name) {
  if (kind == PluginKind::sensor) {
    for (const PluginDescriptor& sensor : built_in_sensors()) {
      if (sensor.name == name) return sensor.parameters;
    }
  }
  const auto plugin = loader_->load(kind, name);
  if (!plugin) return tl::unexpected(plugin.error());
  return (*plugin)->descriptor().parameters;
}

std::vector<OutputModel> LoaderCatalog::outputs(PluginKind kind, const std::string& name) {
  std::vector<OutputModel> outputs;
  if (const auto plugin = loader_->load(kind, name)) {
    for (const PluginOutput& output : (*plugin)->descriptor().outputs) {
      outputs.push_back({output.name, output.unit});
    }
  }
  return outputs;
}

std::vector<Channel> LoaderCatalog::channels(const SceneModel& model, const SensorModel& sensor) {
  const auto plugin = loader_->load(PluginKind::sensor, sensor.type);
  if (!plugin) return {};
  const auto* entry = static_cast<const SensorEntry*>((*plugin)->descriptor().factory);
  const PluginCall call("sensor", sensor.name.c_str(), "", sensor.type.c_str(),
                        "while being configured");
  // What it throws here it throws again when the run is set up, where it is reported.
  try {
    const std::unique_ptr<Sensor, void (*)(Sensor*)> probe(entry->create(), entry->destroy);
    const auto parameters =
        complete_parameters((*plugin)->descriptor().parameters, sensor.parameters);
    if (probe && parameters && probe->configure(model, sensor, *parameters))
      return probe->channels();
  } catch (...) {
  }
  return {};
}

std::vector<std::string> LoaderCatalog::names(PluginKind kind) {
  std::vector<std::string> names;
  if (kind == PluginKind::sensor) {
    for (const PluginDescriptor& sensor : built_in_sensors()) names.push_back(sensor.name);
  }
  if (!all_) all_ = loader_->all();
  for (const PluginPtr& plugin : *all_) {
    if (plugin->descriptor().kind == kind) names.push_back(plugin->descriptor().name);
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

Result<ParameterTable> LoaderCatalog::world_options(const std::string& backend) {
  const auto engine = loader_->backend(backend);
  if (!engine) return tl::unexpected(engine.error());
  return (*engine)->world_options();
}

Result<ParameterTable> LoaderCatalog::element_options(const std::string& backend,
                                                      std::string_view element) {
  const auto engine = loader_->backend(backend);
  if (!engine) return tl::unexpected(engine.error());
  return (*engine)->element_options(element);
}

}  // namespace cogrsim::dsl
