#include "assembly/assembly_access.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/shown_text.h"
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

std::string input_mistake(const std::vector<ControllerInput>& others,
                          const ControllerInput& input) {
  constexpr std::size_t kMost = 64, kLongest = 100;  // what somebody can oversee
  const std::string who = "input '" + one_line(input.name.substr(0, kLongest)) + "'";
  if (input.name.empty() || input.name.size() > kLongest || input.unit.size() > kLongest)
    return fmt::format("{}: a name has 1 to {} bytes, a unit at most as many", who, kLongest);
  // They are written to files and shown, and found again by what was written there.
  if (one_line(input.name) != input.name || one_line(input.unit) != input.unit)
    return who + ": its name and unit are UTF-8 without control characters";
  if (others.size() >= kMost) return fmt::format("{}: a controller has at most {}", who, kMost);
  if (std::any_of(others.begin(), others.end(),
                  [&](const ControllerInput& other) { return other.name == input.name; }))
    return who + " is declared twice";
  if (!std::isfinite(input.lower) || !std::isfinite(input.upper) || !(input.lower < input.upper))
    return fmt::format("{}: its limits {} and {} are no range", who, input.lower, input.upper);
  if (!(input.value >= input.lower && input.value <= input.upper))
    return fmt::format("{}: its value {} is not from {} to {}", who, input.value, input.lower,
                       input.upper);
  return {};
}

void carry_inputs(const std::vector<ControllerInput>& from, std::vector<ControllerInput>& to) {
  for (ControllerInput& input : to)
    for (const ControllerInput& old : from)
      if (old.name == input.name)
        input.value = old.was_set() && std::isfinite(old.value)
                          ? std::clamp(old.value, input.lower, input.upper)
                          : input.start;
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
