// The interface of a supervisor plugin, which observes the whole world and can change it by
// commands.
#pragma once

#include "cogrsim/control/command.h"
#include "cogrsim/control/controller.h"

namespace cogrsim {

/// The interface of a supervisor to the simulation. Only valid during the calls of the supervisor.
class COGRSIM_API SupervisorContext {
 public:
  virtual ~SupervisorContext() = default;
  /// The current frame, with the contents requested in Supervisor::needs(), the latest readings and
  /// outputs, and all events since the previous update. The reference is valid during the call.
  virtual const Frame& frame() const = 0;
  /// Queues a command for the next step boundary. A command that cannot be carried out there is
  /// reported as an event.
  virtual void send(Command command) = 0;
  /// The value of a declared parameter; nullptr if it is not declared.
  virtual const ParameterValue* parameter(const std::string& name) const = 0;
  /// A number drawn uniformly from [low, high), from the seeded random stream of the supervisor.
  virtual double uniform(double low, double high) = 0;
  /// Reports a message to the user.
  virtual void report(const std::string& message) = 0;
  /// Sets the value of a declared output. An undeclared output is a fault.
  virtual void publish(const std::string& output, double value) = 0;
};

/// A supervisor. All calls of one object are made by one thread at a time, between two steps;
/// objects of different simulations run in parallel, so static data must be thread-safe.
class Supervisor {
 public:
  virtual ~Supervisor() = default;
  /// The frame contents that update() needs.
  virtual FrameContents needs() const { return {}; }
  /// Called before the run, and on a new object after every restart.
  virtual void configure(SupervisorContext& context) = 0;
  /// Called at the rate of the supervisor.
  virtual void update(const Tick& tick, SupervisorContext& context) = 0;
  /// As Controller::save() and Controller::restore().
  virtual std::optional<std::string> save() const { return std::nullopt; }
  virtual void restore(const std::string& memory) { static_cast<void>(memory); }
};

/// Factory table of a supervisor plugin, defined by COGRSIM_SUPERVISOR.
struct SupervisorEntry {
  std::optional<std::string> (*create)(Supervisor*& out);
  void (*destroy)(Supervisor*);
  std::optional<std::string> (*configure)(Supervisor&, SupervisorContext&);
  std::optional<std::string> (*update)(Supervisor&, const Tick&, SupervisorContext&);
  std::optional<std::string> (*save)(const Supervisor&, std::optional<std::string>& memory);
  std::optional<std::string> (*restore)(Supervisor&, const std::string& memory);
};

}  // namespace cogrsim

/// Exports a Supervisor class under a plugin name, with the same arguments as COGRSIM_CONTROLLER.
#define COGRSIM_SUPERVISOR(Class, name, ...)                                               \
  namespace {                                                                              \
  const ::cogrsim::SupervisorEntry cogrsim_entry = {                                       \
      [](::cogrsim::Supervisor*& out) {                                                    \
        return ::cogrsim::detail::guarded([&] { out = new Class; });                       \
      },                                                                                   \
      [](::cogrsim::Supervisor* s) { ::cogrsim::detail::guarded([&] { delete s; }); },     \
      [](::cogrsim::Supervisor& s, ::cogrsim::SupervisorContext& context) {                \
        return ::cogrsim::detail::guarded([&] { s.configure(context); });                  \
      },                                                                                   \
      [](::cogrsim::Supervisor& s, const ::cogrsim::Tick& tick,                            \
         ::cogrsim::SupervisorContext& context) {                                          \
        return ::cogrsim::detail::guarded([&] { s.update(tick, context); });               \
      },                                                                                   \
      [](const ::cogrsim::Supervisor& s, std::optional<std::string>& memory) {             \
        return ::cogrsim::detail::guarded([&] { memory = s.save(); });                     \
      },                                                                                   \
      [](::cogrsim::Supervisor& s, const std::string& memory) {                            \
        return ::cogrsim::detail::guarded([&] { s.restore(memory); });                     \
      }};                                                                                  \
  }                                                                                        \
  COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::supervisor, name, &cogrsim_entry, ##__VA_ARGS__)
