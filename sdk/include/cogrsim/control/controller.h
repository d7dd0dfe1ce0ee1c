// The robot's brain: a plugin.
//
//     class WallFollower final : public cogrsim::Controller {
//      public:
//       void configure(cogrsim::Assembly& robot) override { left_ = robot.motor("left"); … }
//       void update(const cogrsim::Tick& tick) override { left_.set(2.0); }
//       …
//     };
//     COGRSIM_CONTROLLER(WallFollower, "wall_follower", version("1.0.0"),
//                        parameter("speed", 0.2, "m/s", "cruising speed").range(0.0, 2.0))
#pragma once

#include <exception>
#include <optional>
#include <string>

#include "cogrsim/assembly/assembly.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

/// When an update happens.
struct Tick {
  double time = 0.0;        ///< of the frame that the sensors read [s]
  double period = 0.0;      ///< since the update before [s]; the nominal one at the first
  std::uint64_t count = 0;  ///< updates before this one
};

class Controller {
 public:
  virtual ~Controller() = default;
  /// Once before the run, and again after every restart, on a new object. `robot` is gone
  /// afterwards: keep handles, or a copy, which is cheap and refers to the same assembly.
  virtual void configure(Assembly& robot) = 0;
  /// At the controller's own rate. An exception stops this controller (or the run, as the scene's
  /// `on-fault` says) and is reported with robot, time and message.
  virtual void update(const Tick& tick) = 0;

  /// All it remembers, as text, for a snapshot on file; empty: it offers none, and begins anew when
  /// the snapshot is loaded.
  virtual std::optional<std::string> save() const { return std::nullopt; }
  /// After configure(), with what save() gave. An exception: the memory does not fit.
  virtual void restore(const std::string& memory) { static_cast<void>(memory); }
};

/// Runs plugin code inside the plugin's own library, so that no exception leaves it. Returns what
/// was thrown.
namespace detail {
template <class Function>
std::optional<std::string> guarded(Function&& function) {
  try {
    function();
    return std::nullopt;
  } catch (const std::exception& e) {
    return std::string(e.what());
  } catch (...) {
    return std::string("threw something that is not a std::exception");
  }
}
}  // namespace detail

/// Factory table of a controller plugin; made by COGRSIM_CONTROLLER.
struct ControllerEntry {
  std::optional<std::string> (*create)(Controller*& out);
  void (*destroy)(Controller*);
  std::optional<std::string> (*configure)(Controller&, Assembly&);
  std::optional<std::string> (*update)(Controller&, const Tick&);
  std::optional<std::string> (*save)(const Controller&, std::optional<std::string>& memory);
  std::optional<std::string> (*restore)(Controller&, const std::string& memory);
};

}  // namespace cogrsim

/// Exports a Controller. After class and name: parameter(…), output(…), version(…), author(…),
/// summary(…).
#define COGRSIM_CONTROLLER(Class, name, ...)                                           \
  namespace {                                                                          \
  const ::cogrsim::ControllerEntry cogrsim_entry = {                                   \
      [](::cogrsim::Controller*& out) {                                                \
        return ::cogrsim::detail::guarded([&] { out = new Class; });                   \
      },                                                                               \
      [](::cogrsim::Controller* c) { ::cogrsim::detail::guarded([&] { delete c; }); }, \
      [](::cogrsim::Controller& c, ::cogrsim::Assembly& robot) {                       \
        return ::cogrsim::detail::guarded([&] { c.configure(robot); });                \
      },                                                                               \
      [](::cogrsim::Controller& c, const ::cogrsim::Tick& tick) {                      \
        return ::cogrsim::detail::guarded([&] { c.update(tick); });                    \
      },                                                                               \
      [](const ::cogrsim::Controller& c, std::optional<std::string>& memory) {         \
        return ::cogrsim::detail::guarded([&] { memory = c.save(); });                 \
      },                                                                               \
      [](::cogrsim::Controller& c, const std::string& memory) {                        \
        return ::cogrsim::detail::guarded([&] { c.restore(memory); });                 \
      }};                                                                              \
  }                                                                                    \
  COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::controller, name, &cogrsim_entry, ##__VA_ARGS__)
