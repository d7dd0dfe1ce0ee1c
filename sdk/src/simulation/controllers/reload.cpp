// Replacing the library of a running controller by a new build.
#include <algorithm>

#include "core/index.h"
#include "simulation/controllers/controller_manager.h"

namespace cogrsim {

Result<std::size_t> find_controller(const SceneModel& model, const std::string& name) {
  std::vector<std::string> names, of_assembly;
  std::size_t last = 0;
  for (std::size_t i = 0; i < model.controllers.size(); ++i) {
    const ControllerModel& controller = model.controllers[i];
    if (controller.removed) continue;
    if (controller.name == name) return i;
    names.push_back(controller.name);
    if (controller.assembly < 0 || model.assemblies[at(controller.assembly)].name != name) {
      continue;
    }
    of_assembly.push_back(controller.name);
    last = i;
  }
  if (of_assembly.size() == 1) return last;
  std::string list;
  for (const std::string& one : of_assembly.empty() ? names : of_assembly) {
    list += (list.empty() ? "'" : ", '") + one + "'";
  }
  if (!of_assembly.empty()) {
    return fail("'" + name + "' has several controllers", "", "one of " + list);
  }
  const std::string near = nearest_name(name, names);
  return fail("there is no controller '" + name + "'", "",
              !near.empty()   ? "did you mean '" + near + "'?"
              : names.empty() ? "the scene has none"
                              : "there are " + list);
}

namespace {

bool same_outputs(const std::vector<PluginOutput>& a, const std::vector<PluginOutput>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const PluginOutput& x, const PluginOutput& y) {
                      return x.name == y.name && x.unit == y.unit;
                    });
}

}  // namespace

// Starts the new controller and gives it the state of the old one. Returns an error message if that
// fails.
std::optional<std::string> ControllerManager::transfer_state(const ControllerSlot& old,
                                                             ControllerSlot& fresh,
                                                             std::size_t index, Reloaded& done) {
  std::optional<std::string> memory;
  if (const auto failure = old.save(memory)) {
    return "the old one " + phrase(*failure, "while its state was saved");
  }
  const DeviceManager::Saved before = devices_.save();
  const StartOutcome outcome = start(fresh, index);
  std::string wrong;
  for (const std::string& mistake : outcome.mistakes) {
    wrong += (wrong.empty() ? "" : "; ") + mistake;
  }
  if (outcome.failure) wrong += (wrong.empty() ? "" : "; ") + ("it " + *outcome.failure);
  if (!wrong.empty()) {
    devices_.restore(before);
    return wrong;
  }
  carry_inputs(old.access->inputs, fresh.access->inputs);  // they are not part of what it saves
  if (!memory) {
    done.note = "it restarted, because the old one saved no state (save())";
    return std::nullopt;
  }
  if (const auto failure = fresh.controller->restore(*memory)) {
    devices_.restore(before);
    return "it does not accept the state of the old one: " + phrase(*failure, "in restore");
  }
  // The controller continues from the current run, not from the initial values of configure().
  devices_.restore(before);
  fresh.access->random->set_state(old.access->random->state());
  fresh.access->outputs = old.access->outputs;
  done.memory_kept = true;
  return std::nullopt;
}

Result<Reloaded> ControllerManager::reload(const std::string& name, RunStatus status) {
  const auto found = find_controller(*host_.model(), name);
  if (!found) return tl::unexpected(found.error());
  const ControllerModel& description = host_.model()->controllers[*found];
  const auto refuse = [&](const std::string& why, const std::string& hint = {}) {
    return fail(
        "controller '" + description.name + "' was not reloaded, the old one is kept: " + why, "",
        hint);
  };
  if (status != RunStatus::running) {
    return refuse(std::string("the run has ended (") + to_string(status) + ")", "restart the run");
  }
  ControllerSlot& old = slots_[*found];
  if (!old.plugin || !old.access) return refuse("it never ran");
  const auto plugin = loader_.load_fresh_copy(*old.plugin);
  if (!plugin) return refuse(plugin.error().text());
  const PluginDescriptor& descriptor = (*plugin)->descriptor();
  if (descriptor.kind != PluginKind::controller) {
    return refuse(std::string("the library holds a ") + to_string(descriptor.kind) + " now");
  }
  auto parameters = complete_parameters(descriptor.parameters, description.parameters);
  if (!parameters) {
    return refuse("its parameters have changed: " + parameters.error().message,
                  parameters.error().hint);
  }
  if (!same_outputs(descriptor.outputs, old.plugin->descriptor().outputs)) {
    return refuse(
        "it publishes other outputs now, but frames and recordings of this run have the previous "
        "ones",
        "restart the run");
  }
  ControllerSlot fresh;
  fresh.plugin = *plugin;
  fresh.access = make_access(port_, description, *plugin, std::move(*parameters));
  fresh.clock = old.clock;
  if (std::exchange(fresh.clock.stopped, false))
    fresh.clock.timer.skip_to(clock_.time(), clock_.dt());
  Reloaded done{description.name, description.plugin, descriptor.version, false, ""};
  if (const auto wrong = transfer_state(old, fresh, *found, done)) return refuse(*wrong);
  loader_.replace(*plugin);
  old.controller.reset();  // before the library it came from
  old = std::move(fresh);
  log_.report(
      Severity::note, "controller '" + description.plugin + "' of '" + old.access->name + "'",
      "reloaded, version " + descriptor.version +
          (done.memory_kept ? "; it continues in the state of the old one" : "; " + done.note));
  return done;
}

}  // namespace cogrsim
