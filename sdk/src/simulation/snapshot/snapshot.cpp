// Saving and restoring the state of a run.
#include "model/diagnose.h"
#include "simulation/impl.h"

namespace cogrsim {

struct SimulationSnapshot {
  WorldHost::Saved host;
  Clock::State clock;
  RunStatus status = RunStatus::running;
  DeviceManager::Saved devices;
  std::vector<HostedState> controllers, supervisors;
  EventState events;
  std::vector<ForceSystem::Applied> forces;
  std::vector<Command> sent;  ///< commands of supervisors for the next step boundary
};

SimulationSnapshotPtr Simulation::save() const {
  const Impl& from = *impl_;
  return std::make_shared<SimulationSnapshot>(
      SimulationSnapshot{from.host.save(), from.clock.save(), from.status, from.devices.save(),
                         from.controllers.save(), from.supervisors.save(), from.events.memory,
                         from.forces.applied(), from.commands.save()});
}

Result<> Simulation::restore(const SimulationSnapshotPtr& snapshot, bool restart_controllers) {
  Impl& to = *impl_;
  if (!snapshot) return fail("there is no snapshot to restore");
  const SceneModelPtr before = to.host.model();
  const SceneModelPtr& then = snapshot->host.model;
  if (snapshot->supervisors.size() != to.supervisors.slots().size() ||
      then->files != before->files || then->name != before->name) {
    return fail("the snapshot was taken from another scene ('" + then->name + "')");
  }
  if (auto done = to.host.restore(snapshot->host); !done) return done;
  to.world_changed();
  to.clock.restore(snapshot->clock);
  to.status = snapshot->status;
  std::vector<Diagnostic> problems;
  // If elements were added or removed since, the devices must be built again.
  if (then != before || restart_controllers) problems = to.build_all();
  to.devices.restore(snapshot->devices);
  to.controllers.restore(snapshot->controllers);
  to.supervisors.restore(snapshot->supervisors);
  to.events.memory = snapshot->events;
  to.forces.set_applied(snapshot->forces);
  to.ending = false;
  to.events.clear();
  to.commands.restore(snapshot->sent);
  if (!problems.empty()) return fail("restore: " + joined(problems), problems.front());
  return {};
}

}  // namespace cogrsim
