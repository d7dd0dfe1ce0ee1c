#include "simulation/controllers/supervisor_manager.h"

#include <algorithm>

#include "cogrsim/core/constants.h"
#include "cogrsim/plugin/crash_report.h"

namespace cogrsim {

/// Implementation of SupervisorContext in a simulation.
class LiveSupervisorContext final : public SupervisorContext {
 public:
  LiveSupervisorContext(const SupervisorServices& run, const ControllerModel& description,
                        Parameters parameters, const std::vector<PluginOutput>& declared)
      : run_(run),
        name_(description.name),
        plugin_(description.plugin),
        parameters_(std::move(parameters)),
        declared_(declared),
        outputs_(declared.size(), kNaN),
        random_(run.host.seed(), name_) {}

  const Frame& frame() const override { return *frame_; }
  void send(Command command) override {
    if (run_.commands.send_own(std::move(command))) return;
    if (std::exchange(run_.events.memory.send_limit_reported, true)) return;
    const std::string why = "supervisor '" + name_ + "' sent more than " +
                            std::to_string(kMaxSentPerStep) +
                            " commands in one step; excess commands are discarded, now and later";
    run_.log.report(Severity::error, name_, why);
    run_.events.publish("refused", name_, why);
  }
  const ParameterValue* parameter(const std::string& name) const override {
    const auto found = parameters_.find(name);
    return found == parameters_.end() ? nullptr : &found->second;
  }
  double uniform(double low, double high) override { return random_.uniform(low, high); }
  void report(const std::string& message) override {
    run_.log.report(Severity::note, name_, message);
  }
  void publish(const std::string& output, double value) override {
    if (auto wrong = publish_output(declared_, output, value, outputs_)) fault_ = std::move(wrong);
  }

  void show(FramePtr frame) { frame_ = std::move(frame); }
  RandomStream& random() { return random_; }
  std::vector<double>& outputs() { return outputs_; }
  /// Crash-report scope for a call of the supervisor.
  PluginCall calling(const char* doing) const {
    return {"supervisor", name_.c_str(), "", plugin_.c_str(), doing, run_.clock.time()};
  }
  /// Returns and clears the error since the last call.
  std::optional<std::string> take_fault() { return std::exchange(fault_, std::nullopt); }

 private:
  SupervisorServices run_;
  std::string name_, plugin_;
  Parameters parameters_;
  const std::vector<PluginOutput>& declared_;
  std::vector<double> outputs_;
  std::optional<std::string> fault_;
  RandomStream random_;
  FramePtr frame_;
};

SupervisorSlot::SupervisorSlot() = default;
SupervisorSlot::SupervisorSlot(SupervisorSlot&&) noexcept = default;
SupervisorSlot& SupervisorSlot::operator=(SupervisorSlot&&) noexcept = default;
SupervisorSlot::~SupervisorSlot() {
  if (!supervisor) return;
  const PluginCall call = context->calling("while it was destroyed");
  supervisor.reset();  // before the context, to which it may still refer
}

RandomStream* SupervisorSlot::random() const { return context ? &context->random() : nullptr; }

std::vector<double>* SupervisorSlot::outputs() const {
  return context ? &context->outputs() : nullptr;
}

std::optional<HostFailure> SupervisorSlot::save(std::optional<std::string>& memory) const {
  if (!supervisor) return std::nullopt;
  const PluginCall call = context->calling("while its state was saved");
  return thrown_failure(entry->save(*supervisor, memory));
}

std::optional<HostFailure> SupervisorSlot::restore(const std::string& memory) {
  if (!supervisor) return std::nullopt;
  const PluginCall call = context->calling("while its state was restored");
  return thrown_failure(entry->restore(*supervisor, memory));
}

std::vector<Diagnostic> SupervisorManager::build(FrameSource& frames) {
  slots_.clear();
  std::vector<Diagnostic> found;
  if (!run_.host.has_world()) return found;
  for (const ControllerModel& description : run_.host.model()->supervisors) {
    for (Diagnostic& d : build_one(description, frames)) found.push_back(std::move(d));
  }
  return found;
}

std::vector<Diagnostic> SupervisorManager::build_one(const ControllerModel& description,
                                                     FrameSource& frames) {
  std::vector<Diagnostic> found;
  const SceneModel& model = *run_.host.model();
  SupervisorSlot slot;
  slot.clock.timer = RateTimer(description.rate);
  if (auto loaded =
          load_controller(model, run_.loader, PluginKind::supervisor, description, found)) {
    slot.plugin = loaded->plugin;
    slot.entry = static_cast<const SupervisorEntry*>(slot.plugin->descriptor().factory);
    slot.context = std::make_unique<LiveSupervisorContext>(
        run_, description, std::move(loaded->parameters), slot.plugin->descriptor().outputs);
    const PluginCall call = slot.context->calling("while being configured");
    Supervisor* made = nullptr;
    auto thrown = slot.entry->create(made);
    slot.supervisor = {made, slot.entry->destroy};
    if (made) {
      slot.needs = made->needs();
      slot.context->show(frames.frame_with(slot.needs));
      thrown = slot.entry->configure(*made, *slot.context);
    }
    StartOutcome outcome;
    if (thrown) outcome.failure = "threw while being configured: " + *thrown;
    if (auto mistake = slot.context->take_fault()) outcome.mistakes.push_back(std::move(*mistake));
    report_mistakes(model, description, "supervisor '" + description.plugin + "'", outcome, found);
  }
  slots_.push_back(std::move(slot));
  return found;
}

bool SupervisorManager::update(FrameSource& frames) {
  const SceneModel& model = *run_.host.model();
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    SupervisorSlot& slot = slots_[i];
    if (!slot.clock.due(run_.clock)) continue;
    std::shared_ptr<Frame> frame = frames.latest(slot.needs);
    frame->events = std::exchange(slot.events, {});
    slot.context->show(std::move(frame));
    const Tick tick = slot.clock.tick(run_.clock);
    const PluginCall call = slot.context->calling("in update");
    std::optional<std::string> wrong;
    if (auto thrown = slot.entry->update(*slot.supervisor, tick, *slot.context)) {
      wrong = "threw in update: " + *thrown;
    } else {
      wrong = slot.context->take_fault();
    }
    if (wrong &&
        stop_after_fault(model, model.supervisors[i], slot.clock, *wrong, run_.log, run_.events)) {
      return false;
    }
  }
  return true;
}

void SupervisorManager::deliver(const Event& event) {
  for (SupervisorSlot& slot : slots_) {
    if (slot.events.size() < kMaxEventsPerStep) slot.events.push_back(event);
  }
}

bool SupervisorManager::wants_accelerations() const {
  return std::any_of(slots_.begin(), slots_.end(),
                     [](const SupervisorSlot& slot) { return slot.needs.accelerations; });
}

void SupervisorManager::copy_outputs(std::vector<std::vector<double>>& out) const {
  out.resize(slots_.size());
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (slots_[i].context) out[i] = slots_[i].context->outputs();
  }
}

std::vector<HostedState> SupervisorManager::save() const {
  std::vector<HostedState> saved;
  for (const SupervisorSlot& slot : slots_) {
    saved.push_back(
        {slot.clock, slot.context->random().state(), slot.context->outputs(), slot.events});
  }
  return saved;
}

void SupervisorManager::restore(const std::vector<HostedState>& saved) {
  for (std::size_t i = 0; i < saved.size(); ++i) {
    slots_[i].clock = saved[i].clock;
    if (!slots_[i].context) continue;
    slots_[i].context->random().set_state(saved[i].random);
    slots_[i].context->outputs() = saved[i].outputs;
    slots_[i].events = saved[i].events;
  }
}

}  // namespace cogrsim
