// Saving and restoring the state of a run.
#include <algorithm>

#include "simulation/impl.h"

namespace cogrsim {

SimulationSnapshotPtr Simulation::save() const {
  const Impl& from = *impl_;
  auto snapshot = std::make_shared<SimulationSnapshot>();
  snapshot->model = from.model;
  snapshot->world = from.world->save();
  snapshot->clock = from.clock.save();
  snapshot->status = from.status;
  snapshot->motors = from.motors;
  snapshot->sensors = from.sensors.save();
  for (const ControllerSlot& slot : from.controllers) {
    snapshot->controllers.push_back(slot.clock);
    snapshot->controller_random.push_back(slot.access ? slot.access->random->state() : 0);
    snapshot->controller_outputs.push_back(slot.access ? slot.access->outputs
                                                       : std::vector<double>());
  }
  for (const SupervisorSlot& slot : from.supervisors) {
    snapshot->supervisors.push_back(slot.clock);
    snapshot->supervisor_random.push_back(slot.context->random().state());
    snapshot->supervisor_outputs.push_back(slot.context->outputs());
    snapshot->supervisor_events.push_back(slot.events);
  }
  snapshot->twists_before = from.twists_before;
  snapshot->joint_efforts_before = from.joint_efforts_before;
  snapshot->motor_efforts_before = from.motor_efforts_before;
  snapshot->event_system = from.event_system.memory;
  snapshot->sent = from.commands.save();
  return snapshot;
}

Result<> Simulation::restore(const SimulationSnapshotPtr& snapshot, bool restart_controllers) {
  Impl& to = *impl_;
  if (!snapshot) return fail("there is no snapshot to restore");
  if (snapshot->supervisors.size() != to.supervisors.size() ||
      snapshot->model->files != to.model->files || snapshot->model->name != to.model->name) {
    return fail("the snapshot was taken from another scene ('" + snapshot->model->name + "')");
  }
  if (auto done = to.world->restore(snapshot->world); !done) return done;
  const bool same_model = to.model == snapshot->model;
  to.model = snapshot->model;
  to.world_changed();
  to.clock.restore(snapshot->clock);
  to.status = snapshot->status;
  to.twists_before = snapshot->twists_before;
  to.joint_efforts_before = snapshot->joint_efforts_before;
  to.motor_efforts_before = snapshot->motor_efforts_before;
  std::string problems;
  // If elements were added or removed since, the devices must be built again.
  if (!same_model || restart_controllers) {
    for (const Diagnostic& d : to.build_all()) {
      problems += (problems.empty() ? "" : "; ") + d.message;
    }
  }
  to.motors = snapshot->motors;
  to.sensors.restore(snapshot->sensors);
  for (std::size_t i = 0; i < snapshot->controllers.size() && i < to.controllers.size(); ++i) {
    to.controllers[i].clock = snapshot->controllers[i];
    if (!to.controllers[i].access) continue;
    to.controllers[i].access->random->set_state(snapshot->controller_random[i]);
    to.controllers[i].access->outputs = snapshot->controller_outputs[i];
  }
  for (std::size_t i = 0; i < snapshot->supervisors.size(); ++i) {
    to.supervisors[i].clock = snapshot->supervisors[i];
    if (!to.supervisors[i].context) continue;
    to.supervisors[i].context->random().set_state(snapshot->supervisor_random[i]);
    to.supervisors[i].context->outputs() = snapshot->supervisor_outputs[i];
    to.supervisors[i].events = snapshot->supervisor_events[i];
  }
  to.event_system.memory = snapshot->event_system;
  to.ending = false;
  to.events.clear();
  to.event_causes.clear();
  to.commands.restore(snapshot->sent);
  if (!problems.empty()) return fail("restore: " + problems);
  return {};
}

}  // namespace cogrsim
