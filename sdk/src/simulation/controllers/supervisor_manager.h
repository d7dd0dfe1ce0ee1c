// The supervisors of a run.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/control/supervisor.h"
#include "simulation/command_queue.h"
#include "simulation/controllers/hosted_plugin.h"
#include "simulation/frame_source.h"
#include "simulation/world_host.h"

namespace cogrsim {

class LiveSupervisorContext;

struct SupervisorSlot {
  PluginPtr plugin;
  const SupervisorEntry* entry = nullptr;
  std::unique_ptr<LiveSupervisorContext> context;
  std::unique_ptr<Supervisor, void (*)(Supervisor*)> supervisor{nullptr, nullptr};
  FrameContents needs;
  std::vector<Event> events;  ///< since its last update
  ControllerClock clock;
  SupervisorSlot();
  SupervisorSlot(SupervisorSlot&&) noexcept;
  SupervisorSlot& operator=(SupervisorSlot&&) noexcept;
  ~SupervisorSlot();

  RandomStream* random() const;
  std::vector<double>* outputs() const;
  /// The state that the supervisor itself saves; none if it was never created.
  std::optional<HostFailure> save(std::optional<std::string>& memory) const;
  std::optional<HostFailure> restore(const std::string& memory);
};

/// What supervisors use of a run, which must outlive them.
struct SupervisorServices {
  PluginLoader& loader;
  WorldHost& host;
  const Clock& clock;
  MessageLog& log;
  EventSystem& events;
  CommandQueue& commands;
};

class SupervisorManager {
 public:
  explicit SupervisorManager(const SupervisorServices& run) : run_(run) {}

  /// Creates and configures the supervisors of the model; none without a world, because they need
  /// frames. Errors have the source location of the supervisor.
  std::vector<Diagnostic> build(FrameSource& frames);

  /// Updates the supervisors that are due, in the order of the model. False: a fault ends the run.
  bool update(FrameSource& frames);
  /// Stores an event for the next update of each supervisor.
  void deliver(const Event& event);

  bool wants_accelerations() const;
  /// The published outputs, as in Frame::supervisor_outputs.
  void copy_outputs(std::vector<std::vector<double>>& out) const;

  std::vector<HostedState> save() const;
  /// Precondition: saved.size() == slots().size().
  void restore(const std::vector<HostedState>& saved);
  std::vector<SupervisorSlot>& slots() { return slots_; }
  const std::vector<SupervisorSlot>& slots() const { return slots_; }

 private:
  std::vector<Diagnostic> build_one(const ControllerModel& description, FrameSource& frames);

  SupervisorServices run_;
  std::vector<SupervisorSlot> slots_;
};

}  // namespace cogrsim
