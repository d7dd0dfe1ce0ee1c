// Implementation of the handles of cogrsim/assembly/assembly.h.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "assembly/device_port.h"
#include "cogrsim/assembly/input.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/core/random.h"

namespace cogrsim {

/// One controller as its handles see it; lives as long as the handles.
struct AssemblyAccess {
  DevicePort* port = nullptr;
  int assembly = -1;
  std::string name;
  std::string controller;  ///< dotted name of the controller
  std::string plugin;
  const ParameterTable* table = nullptr;
  Parameters parameters;
  const std::vector<PluginOutput>* declared = nullptr;
  std::vector<double> outputs;  ///< in the order of `declared`
  std::vector<ControllerInput> inputs;
  bool configured = false;  ///< configure() has ended: nothing can be declared any more
  std::optional<RandomStream> random;
  std::vector<int> motors;            ///< the motors that it requested
  std::vector<std::string> mistakes;  ///< errors in configure()
  std::optional<std::string> fault;   ///< error in the current update
};

/// Creates the access of a new controller; `parameters` are complete. `port` must outlive it.
std::shared_ptr<AssemblyAccess> make_access(DevicePort& port, const ControllerModel& description,
                                            const PluginPtr& plugin, Parameters parameters);

/// Name of an assembly for messages; "the scene" for -1.
std::string assembly_name(const SceneModel& model, int assembly);

/// What is wrong with an input that a controller declares beside these; empty: nothing.
std::string input_mistake(const std::vector<ControllerInput>& others, const ControllerInput& input);

/// Gives those of these inputs that have the name of one of the others its value, within their limits;
/// where nobody has set the other one, their own start value.
void carry_inputs(const std::vector<ControllerInput>& from, std::vector<ControllerInput>& to);

/// Sets one of the declared outputs; returns an error message if it is not declared.
std::optional<std::string> publish_output(const std::vector<PluginOutput>& declared,
                                          const std::string& name, double value,
                                          std::vector<double>& outputs);

}  // namespace cogrsim
