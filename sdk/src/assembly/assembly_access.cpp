#include "assembly/assembly_access.h"

#include "cogrsim/core/constants.h"
#include "core/index.h"

namespace cogrsim {

std::shared_ptr<AssemblyAccess> make_access(DevicePort& port, const ControllerModel& description,
                                            const PluginPtr& plugin, Parameters parameters) {
  auto access = std::make_shared<AssemblyAccess>();
  access->port = &port;
  access->assembly = description.assembly;
  access->name = assembly_name(*port.model(), description.assembly);
  access->controller = description.name;
  access->plugin = description.plugin;
  access->table = &plugin->descriptor().parameters;
  access->parameters = std::move(parameters);
  access->declared = &plugin->descriptor().outputs;
  access->outputs.assign(access->declared->size(), kNaN);
  access->random.emplace(port.original()->physics.seed, description.name);
  return access;
}

std::string assembly_name(const SceneModel& model, int assembly) {
  return assembly < 0 ? "the scene" : model.assemblies[at(assembly)].name;
}

std::optional<std::string> publish_output(const std::vector<PluginOutput>& declared,
                                          const std::string& name, double value,
                                          std::vector<double>& outputs) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < declared.size(); ++i) {
    if (declared[i].name == name) {
      outputs[i] = value;
      return std::nullopt;
    }
    names.push_back(declared[i].name);
  }
  const std::string near = nearest_name(name, names);
  return "there is no declared output '" + name + "'" +
         (near.empty() ? "" : "; did you mean '" + near + "'?");
}

}  // namespace cogrsim
