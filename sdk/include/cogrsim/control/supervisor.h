// Watches the whole world and may change it by commands.
#pragma once

#include "cogrsim/control/controller.h"
#include "cogrsim/simulation/command.h"

namespace cogrsim {

/// What a supervisor is given: every frame, and a way to send commands.
class COGRSIM_API Stage {
 public:
  virtual ~Stage() = default;
  /// The latest frame, with what the supervisor asked for in needs(), the readings and outputs of this
  /// very moment, and all events since its last update.
  virtual const Frame& frame() const = 0;
  /// Queued for the next step boundary. What cannot be done there is reported as an event.
  virtual void send(Command command) = 0;
  /// A declared parameter; nullptr: not declared.
  virtual const ParameterValue* parameter(const std::string& name) const = 0;
  /// Uniform in [low, high) from the supervisor's own seeded stream.
  virtual double uniform(double low, double high) = 0;
  virtual void report(const std::string& message) = 0;
  /// Value of a declared output from now on. Undeclared: a fault.
  virtual void publish(const std::string& output, double value) = 0;
};

class Supervisor {
 public:
  virtual ~Supervisor() = default;
  virtual FrameContents needs() const { return {}; }
  /// Before the run and after every restart, on a new object.
  virtual void configure(Stage& stage) = 0;
  virtual void update(const Tick& tick, Stage& stage) = 0;
  /// As Controller's.
  virtual std::optional<std::string> save() const { return std::nullopt; }
  virtual void restore(const std::string& memory) { static_cast<void>(memory); }
};

/// Factory table of a supervisor plugin; made by COGRSIM_SUPERVISOR.
struct SupervisorEntry {
  std::optional<std::string> (*create)(Supervisor*& out);
  void (*destroy)(Supervisor*);
  std::optional<std::string> (*configure)(Supervisor&, Stage&);
  std::optional<std::string> (*update)(Supervisor&, const Tick&, Stage&);
  std::optional<std::string> (*save)(const Supervisor&, std::optional<std::string>& memory);
  std::optional<std::string> (*restore)(Supervisor&, const std::string& memory);
};

}  // namespace cogrsim

#define COGRSIM_SUPERVISOR(Class, name, ...)                                               \
  namespace {                                                                              \
  const ::cogrsim::SupervisorEntry cogrsim_entry = {                                       \
      [](::cogrsim::Supervisor*& out) {                                                    \
        return ::cogrsim::detail::guarded([&] { out = new Class; });                       \
      },                                                                                   \
      [](::cogrsim::Supervisor* s) { ::cogrsim::detail::guarded([&] { delete s; }); },     \
      [](::cogrsim::Supervisor& s, ::cogrsim::Stage& stage) {                              \
        return ::cogrsim::detail::guarded([&] { s.configure(stage); });                    \
      },                                                                                   \
      [](::cogrsim::Supervisor& s, const ::cogrsim::Tick& tick, ::cogrsim::Stage& stage) { \
        return ::cogrsim::detail::guarded([&] { s.update(tick, stage); });                 \
      },                                                                                   \
      [](const ::cogrsim::Supervisor& s, std::optional<std::string>& memory) {             \
        return ::cogrsim::detail::guarded([&] { memory = s.save(); });                     \
      },                                                                                   \
      [](::cogrsim::Supervisor& s, const std::string& memory) {                            \
        return ::cogrsim::detail::guarded([&] { s.restore(memory); });                     \
      }};                                                                                  \
  }                                                                                        \
  COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::supervisor, name, &cogrsim_entry, ##__VA_ARGS__)
