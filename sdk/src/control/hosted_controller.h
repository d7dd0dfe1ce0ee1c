// A controller that runs in this process or in a process of its own.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "assembly/assembly_access.h"
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

/// The failure of a call that threw; nullopt: it did not.
std::optional<HostFailure> thrown_failure(std::optional<std::string> thrown);

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
  /// Id of the process of its own that it runs in; 0: there is none.
  virtual std::int64_t process() const { return 0; }
};

struct SceneForControllers;

std::unique_ptr<HostedController> make_in_process_controller(
    PluginPtr plugin, std::shared_ptr<AssemblyAccess> access);
/// `controller` is the index into SceneModel::controllers; `scene` is shared by the controllers of a
/// run and must outlive them. Errors: the process cannot be started.
Result<std::unique_ptr<HostedController>> make_isolated_controller(
    PluginPtr plugin, std::shared_ptr<AssemblyAccess> access, std::size_t controller,
    SceneForControllers& scene);

/// The parameters and outputs of a plugin as text. Two builds of a plugin can replace each other
/// during a run if their texts are equal.
std::string shape_of(const PluginDescriptor& plugin);

}  // namespace cogrsim
