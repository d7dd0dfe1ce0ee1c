// A controller that runs in this process or in a process of its own.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "cogrsim/control/controller.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// A failed call of a controller.
struct HostFailure {
  enum class Kind {
    thrown,   ///< an exception; `what` is its text
    process,  ///< its process failed: "crashed (SIGSEGV)"
    refused   ///< it could not be created; `what` is the complete message
  };
  Kind kind = Kind::thrown;
  std::string what;
  std::string more{};  ///< further details, appended to the message
};

/// The message of a failure: "threw in update: cell 9 of 8", "crashed (SIGSEGV) in update".
std::string phrase(const HostFailure& failure, const std::string& doing);

/// Calls of a Controller. When a call returns, the published outputs, the messages and the motor
/// targets have taken effect in the simulation; errors and faults are in the AssemblyAccess.
class HostedController {
 public:
  virtual ~HostedController() = default;
  /// Creates the controller object and configures it.
  virtual std::optional<HostFailure> configure() = 0;
  virtual std::optional<HostFailure> update(const Tick& tick) = 0;
  virtual std::optional<HostFailure> save(std::optional<std::string>& memory) = 0;
  virtual std::optional<HostFailure> restore(const std::string& memory) = 0;
};

class Plugin;
using PluginPtr = std::shared_ptr<const Plugin>;
struct AssemblyAccess;

std::unique_ptr<HostedController> make_in_process_controller(
    PluginPtr plugin, std::shared_ptr<AssemblyAccess> access);
/// `controller` is the index into SceneModel::controllers. Errors: the process cannot be started.
Result<std::unique_ptr<HostedController>> make_isolated_controller(
    PluginPtr plugin, std::shared_ptr<AssemblyAccess> access, std::size_t controller);

}  // namespace cogrsim
