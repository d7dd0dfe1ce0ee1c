// The interface of a controller plugin, which controls a robot.
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

/// Timing of an update.
struct Tick {
  double time = 0.0;        ///< time of the measured frame [s]
  double period = 0.0;      ///< time since the previous update [s]; nominal at the first update
  std::uint64_t count = 0;  ///< number of previous updates
};

/// A controller. All calls of one object are made by one thread at a time, between two steps;
/// objects of different simulations run in parallel, so static data must be thread-safe.
class Controller {
 public:
  virtual ~Controller() = default;
  /// Called once before the run, and on a new object after every restart. `robot` is destroyed
  /// afterwards: store handles or a copy, which is cheap and refers to the same assembly.
  virtual void configure(Assembly& robot) = 0;
  /// Called at the rate of the controller. An exception stops this controller, or the run if the
  /// scene sets `on-fault`, and is reported with the robot, the time and the message.
  virtual void update(const Tick& tick) = 0;

  /// The complete internal state as text, for a snapshot in a file. nullopt: the controller does
  /// not support this and restarts when the snapshot is loaded.
  virtual std::optional<std::string> save() const { return std::nullopt; }
  /// Called after configure() with the result of save(). An exception means that the state does not
  /// match this controller.
  virtual void restore(const std::string& memory) { static_cast<void>(memory); }
};

/// Calls plugin code inside the library of the plugin, so that no exception leaves it. Returns the
/// message of a thrown exception.
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

/// Factory table of a controller plugin, defined by COGRSIM_CONTROLLER.
struct ControllerEntry {
  std::optional<std::string> (*create)(Controller*& out);
  void (*destroy)(Controller*);
  std::optional<std::string> (*configure)(Controller&, Assembly&);
  std::optional<std::string> (*update)(Controller&, const Tick&);
  std::optional<std::string> (*save)(const Controller&, std::optional<std::string>& memory);
  std::optional<std::string> (*restore)(Controller&, const std::string& memory);
};

}  // namespace cogrsim

/// Exports a Controller class under a plugin name. Optional further arguments: parameter(…),
/// output(…), version(…), author(…), summary(…).
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
