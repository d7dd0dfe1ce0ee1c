// A controller where it lives: in this process or in one of its own.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "cogrsim/control/controller.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// What went wrong in a call of a controller.
struct HostFailure {
  enum class Kind {
    thrown,   ///< an exception; `what` is its text
    process,  ///< something happened to its process: "crashed (SIGSEGV)"
    refused   ///< it could not be made; `what` says all
  };
  Kind kind = Kind::thrown;
  std::string what;
  std::string more{};  ///< that is known, to be said last
};

/// "threw in update: cell 9 of 8", "crashed (SIGSEGV) in update".
std::string phrase(const HostFailure& failure, const std::string& doing);

/// Calls of a Controller. What it publishes, reports and does to motors has happened in the
/// simulation when a call returns; mistakes and faults are in its AssemblyAccess.
class HostedController {
 public:
  virtual ~HostedController() = default;
  /// Makes the object and configures it.
  virtual std::optional<HostFailure> configure() = 0;
  virtual std::optional<HostFailure> update(const Tick& tick) = 0;
  virtual std::optional<HostFailure> save(std::optional<std::string>& memory) = 0;
  virtual std::optional<HostFailure> restore(const std::string& memory) = 0;
};

class Plugin;
using PluginPtr = std::shared_ptr<const Plugin>;
struct AssemblyAccess;

std::unique_ptr<HostedController> host_here(PluginPtr plugin,
                                            std::shared_ptr<AssemblyAccess> access);
/// `controller`: its place in SceneModel::controllers. Errors: the process cannot be started.
Result<std::unique_ptr<HostedController>> host_apart(PluginPtr plugin,
                                                     std::shared_ptr<AssemblyAccess> access,
                                                     std::size_t controller);

}  // namespace cogrsim
