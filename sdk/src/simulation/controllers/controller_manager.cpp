#include "simulation/controllers/controller_manager.h"

#include <fmt/format.h>

#include "simulation/find_named.h"

namespace cogrsim {

std::vector<Diagnostic> ControllerManager::build(std::size_t first) {
  slots_.erase(slots_.begin() + static_cast<std::ptrdiff_t>(first), slots_.end());
  std::vector<Diagnostic> found;
  for (std::size_t i = first; i < host_.model()->controllers.size(); ++i) {
    for (Diagnostic& d : build_one(i)) found.push_back(std::move(d));
  }
  return found;
}

std::vector<Diagnostic> ControllerManager::build_one(std::size_t index) {
  std::vector<Diagnostic> found;
  const SceneModel& model = *host_.model();
  const ControllerModel& description = model.controllers[index];
  ControllerSlot slot;
  slot.clock.timer = RateTimer(description.rate);
  if (description.removed) {
    slot.clock.stopped = true;
  } else if (auto loaded =
                 load_controller(model, loader_, PluginKind::controller, description, found)) {
    slot.plugin = loaded->plugin;
    slot.access = make_access(port_, description, slot.plugin, std::move(loaded->parameters));
    const StartOutcome outcome = start(slot, index);
    report_mistakes(model, description,
                    "controller '" + description.plugin + "' of '" + slot.access->name + "'",
                    outcome, found);
  }
  slots_.push_back(std::move(slot));
  return found;
}

StartOutcome ControllerManager::start(ControllerSlot& slot, std::size_t index) {
  StartOutcome outcome;
  if (host_.model()->controllers[index].isolation.value_or(isolation_) == Isolation::process) {
    auto isolated = make_isolated_controller(slot.plugin, slot.access, index, scene_);
    if (!isolated) {
      outcome.failure = isolated.error().text();
      return outcome;
    }
    slot.controller = std::move(*isolated);
  } else {
    slot.controller = make_in_process_controller(slot.plugin, slot.access);
  }
  if (const auto failure = slot.controller->configure()) {
    outcome.failure = phrase(*failure, "while being configured");
  }
  outcome.mistakes = std::exchange(slot.access->mistakes, {});
  if (slot.access->fault) outcome.mistakes.push_back(*slot.access->fault);
  slot.access->fault.reset();
  return outcome;
}

void ControllerManager::stop(ControllerSlot& slot) {
  slot.clock.stopped = true;
  slot.controller.reset();
}

void ControllerManager::stop(std::size_t first) {
  for (std::size_t i = first; i < slots_.size(); ++i) stop(slots_[i]);
}

void ControllerManager::drop_removed() {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (!host_.model()->controllers[i].removed) continue;
    stop(slots_[i]);
    if (slots_[i].access) slots_[i].access->parameters.clear();
  }
}

std::vector<ControllerProcess> ControllerManager::processes() const {
  std::vector<ControllerProcess> out;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const ControllerModel& description = host_.model()->controllers[i];
    if (description.removed || !slots_[i].plugin) continue;
    const std::int64_t process = slots_[i].controller ? slots_[i].controller->process() : 0;
    out.push_back({description.name, process, slots_[i].plugin->path()});
  }
  return out;
}

std::vector<ControllerInputs> ControllerManager::inputs() const {
  std::vector<ControllerInputs> out;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const ControllerModel& description = host_.model()->controllers[i];
    if (description.removed || !slots_[i].runs() || slots_[i].access->inputs.empty()) continue;
    out.push_back({description.name, slots_[i].access->inputs});
  }
  return out;
}

Result<> ControllerManager::set_input(const SetInput& command) {
  const auto found = find_controller(*host_.model(), command.controller);
  if (!found) return tl::unexpected(found.error());
  const std::string& name = host_.model()->controllers[*found].name;
  if (!slots_[*found].access) return fail("controller '" + name + "' never ran");
  if (!slots_[*found].runs())
    return fail("controller '" + name + "' has stopped, and its inputs act no more");
  std::vector<std::string> names;
  for (ControllerInput& input : slots_[*found].access->inputs) {
    names.push_back(input.name);
    if (input.name != command.input) continue;
    if (!(command.value >= input.lower && command.value <= input.upper))
      return fail(fmt::format("input '{}' of '{}': {} is not from {} to {}", input.name, name,
                              command.value, input.lower, input.upper));
    input.value = command.value;
    return {};
  }
  const std::string near = nearest_name(command.input, names);
  return fail("controller '" + name + "' has no input '" + command.input + "'", "",
              names.empty()  ? "it has none"
              : near.empty() ? ""
                             : "did you mean '" + near + "'?");
}

bool ControllerManager::update() {
  const SceneModel& model = *host_.model();
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    ControllerSlot& slot = slots_[i];
    if (!slot.clock.due(clock_)) continue;
    std::optional<std::string> wrong;
    if (const auto failure = slot.controller->update(slot.clock.tick(clock_))) {
      wrong = phrase(*failure, "in update");
    } else {
      wrong = slot.access->fault;
    }
    slot.access->fault.reset();
    if (!wrong) continue;
    const bool ends =
        stop_after_fault(model, model.controllers[i], slot.clock, *wrong, log_, events_);
    devices_.stop(slot.access->motors);
    if (ends) return false;
  }
  return true;
}

void ControllerManager::copy_outputs(std::vector<std::vector<double>>& out) const {
  out.resize(slots_.size());
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    out[i].clear();
    if (slots_[i].access) out[i] = slots_[i].access->outputs;
  }
}

std::vector<HostedState> ControllerManager::save() const {
  std::vector<HostedState> saved;
  for (const ControllerSlot& slot : slots_) {
    HostedState& state = saved.emplace_back();
    state.clock = slot.clock;
    if (!slot.access) continue;
    state.random = slot.access->random->state();
    state.outputs = slot.access->outputs;
    state.inputs = slot.access->inputs;
  }
  return saved;
}

void ControllerManager::restore(const std::vector<HostedState>& saved) {
  for (std::size_t i = 0; i < saved.size() && i < slots_.size(); ++i) {
    slots_[i].clock = saved[i].clock;
    if (!slots_[i].access) continue;
    slots_[i].access->random->set_state(saved[i].random);
    slots_[i].access->outputs = saved[i].outputs;
    carry_inputs(saved[i].inputs, slots_[i].access->inputs);
  }
}

}  // namespace cogrsim
