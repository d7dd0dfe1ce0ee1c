// The step order and the clock.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include "simulation/impl.h"

namespace cogrsim {

struct Observation::Slot {
  FrameContents contents;
  Simulation::Observer call;
  bool ended = false;
};

void Observation::end() {
  if (const auto slot = slot_.lock()) slot->ended = true;
}

void Simulation::Impl::world_changed() {
  host.changed();
  cached.reset();
}

FramePtr Simulation::Impl::frame_with(const FrameContents& contents) {
  if (cached && covers(cached_contents, contents)) return cached;
  const FrameContents wanted = cached ? cached_contents | contents : contents;
  std::shared_ptr<Frame> frame = pool->take();
  frame->model = host.model();
  frame->step = clock.steps();
  frame->time = clock.time();
  frame->dt = clock.last_dt();
  frame->state = host.state();
  frame->accelerations.clear();
  const std::vector<Twist>& before = host.before().twists;
  if (wanted.accelerations && !before.empty() && clock.last_dt() > 0.0) {
    mean_accelerations(before, frame->state.twists, clock.last_dt(), frame->accelerations);
  }
  // At the start there is no step to take the mean over.
  frame->contents.accelerations =
      wanted.accelerations && (!before.empty() || clock.last_dt() == 0.0);
  frame->contents.contacts = wanted.contacts;
  frame->contacts.clear();
  if (wanted.contacts) host.world().get_contacts(frame->contacts);
  frame->joint_reactions.clear();
  auto* reactions = wanted.joint_reactions ? host.world().extension<JointReactions>() : nullptr;
  frame->contents.joint_reactions = reactions != nullptr;
  if (reactions) reactions->get_joint_reactions(frame->joint_reactions);
  devices.sensors().copy_readings(frame->readings);
  frame->motor_targets.clear();
  for (const MotorState& motor : devices.motors()) frame->motor_targets.push_back(motor.acting);
  frame->channels = devices.sensors().channels();
  frame->events = events.events();
  controllers.copy_outputs(frame->controller_outputs);
  supervisors.copy_outputs(frame->supervisor_outputs);
  cached = std::move(frame);
  cached_contents = wanted;
  return cached;
}

std::shared_ptr<Frame> Simulation::Impl::latest(const FrameContents& contents) {
  std::shared_ptr<Frame> frame = pool->take();
  *frame = *frame_with(contents);
  devices.sensors().copy_readings(frame->readings);
  controllers.copy_outputs(frame->controller_outputs);
  return frame;
}

bool Simulation::Impl::wants_accelerations() const {
  return devices.sensors().wants_accelerations() || supervisors.wants_accelerations() ||
         std::any_of(observers.begin(), observers.end(),
                     [](const auto& w) { return w->contents.accelerations && !w->ended; });
}

void Simulation::Impl::show_frame() {
  observers.erase(std::remove_if(observers.begin(), observers.end(),
                                 [](const auto& observer) { return observer->ended; }),
                  observers.end());
  if (observers.empty()) return;
  FrameContents needed;
  for (const auto& observer : observers) needed = needed | observer->contents;
  if (needed.for_sensors) needed = needed | devices.sensors().needs();
  const FramePtr frame = frame_with(needed);
  for (const auto& observer : observers)
    if (!observer->ended) observer->call(frame);
}

void Simulation::Impl::show_start() {
  if (start_shown || observers.empty()) return;
  start_shown = true;
  show_frame();
}

RunStatus Simulation::Impl::step() {
  if (stop_requested.exchange(false) && status == RunStatus::running) status = RunStatus::stopped;
  const auto begin = [this] {
    if (status != RunStatus::running) return;
    show_start();
    if (!events.memory.started) events.process(host, devices.sensors(), *this);
    apply_due();
  };
  begin();
  apply_commands();                     // also after the end, because of Restart
  if (!events.memory.started) begin();  // the new run
  if (ending && pace.waits()) status = RunStatus::stopped;
  if (status != RunStatus::running || pace.waits()) return status;
  pace.single_step = false;
  devices.read_sensors(*this, log);
  if (!controllers.update() || !supervisors.update(*this)) return status = RunStatus::fault;
  const auto channels = [this](int sensor) {
    return &devices.sensors().channels(static_cast<std::size_t>(sensor));
  };
  devices.follow_signals(*this);
  forces.apply(host, clock, channels, *this);
  limits.check_start(host, clock, log);
  const StepResult result =
      host.step(clock.time(), clock.dt(), devices.make_drives(), wants_accelerations());
  cached.reset();
  if (result.status == StepStatus::fault) {
    log.report(Severity::error, "physics", result.message);
    return status = RunStatus::fault;
  }
  if (result.status == StepStatus::diverged) {
    status = RunStatus::diverged;
    const std::string body = result.body >= 0 ? model().bodies[result.body].name : "";
    // Some engines already name the body in their message.
    const bool named = body.empty() || result.message.find("'" + body + "'") != std::string::npos;
    log.report(Severity::error, body.empty() ? "physics" : body,
               "diverged: " + (named ? "" : "body '" + body + "': ") + result.message);
    return status;
  }
  clock.advance();
  limits.check(host, clock, log);
  events.process(host, devices.sensors(), *this);
  show_frame();
  events.clear();
  events.memory.added_in_step = 0;
  if (ending) status = RunStatus::stopped;
  return status;
}

Simulation::Simulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Simulation::~Simulation() = default;

const Backend& Simulation::backend() const { return impl_->host.backend(); }
const Provenance& Simulation::provenance() const { return impl_->host.provenance(); }
const SceneModelPtr& Simulation::model() const { return impl_->host.model(); }
double Simulation::time() const { return impl_->clock.time(); }
double Simulation::dt() const { return impl_->clock.dt(); }
std::uint64_t Simulation::step_count() const { return impl_->clock.steps(); }
RunStatus Simulation::status() const { return impl_->status; }
const std::vector<RunMessage>& Simulation::messages() const { return impl_->log.messages(); }
void Simulation::stop() noexcept { impl_->stop_requested.store(true); }
bool Simulation::paused() const { return impl_->pace.paused; }

FramePtr Simulation::frame() { return impl_->frame_with({true, true, true}); }

Observation Simulation::observe(FrameContents contents, Observer observer) {
  auto slot = std::make_shared<Observation::Slot>();
  slot->contents = contents;
  slot->call = std::move(observer);
  impl_->observers.push_back(slot);
  return Observation(slot);
}

const std::vector<Channel>& Simulation::channels(int sensor) const {
  return impl_->devices.sensors().channels(static_cast<std::size_t>(sensor));
}

Result<Reloaded> Simulation::reload_controller(const std::string& name) {
  auto done = impl_->controllers.reload(name, impl_->status);
  if (done) impl_->cached.reset();
  return done;
}

const Reading& Simulation::reading(int sensor) const {
  return impl_->devices.sensors().reading(static_cast<std::size_t>(sensor));
}

std::vector<ControllerInputs> Simulation::controller_inputs() const {
  return impl_->controllers.inputs();
}

std::vector<ControllerProcess> Simulation::controller_processes() const {
  return impl_->controllers.processes();
}

RunStatus Simulation::step() { return impl_->step(); }

RunStatus Simulation::run_until(double end_time) {
  using WallClock = std::chrono::steady_clock;
  WallClock::time_point wall_start = WallClock::now();
  double simulated_start = time();
  double speed = impl_->pace.speed;
  // With a tolerance of half a step: the end is the nearest step boundary.
  while (impl_->status == RunStatus::running && time() + 0.5 * impl_->clock.dt() < end_time) {
    const double before = time();
    step();
    if (impl_->pace.paused && impl_->commands.size() == 0) return impl_->status;
    if (impl_->pace.speed != speed || time() < before) {
      speed = impl_->pace.speed;
      wall_start = WallClock::now();
      simulated_start = time();
    }
    if (!std::isfinite(speed)) continue;
    const auto due =
        wall_start + std::chrono::duration_cast<WallClock::duration>(
                         std::chrono::duration<double>((time() - simulated_start) / speed));
    // Sleeps in short intervals, so that stop() takes effect.
    while (WallClock::now() < due && !impl_->stop_requested.load()) {
      std::this_thread::sleep_until(
          std::min(due, WallClock::now() + std::chrono::milliseconds(10)));
    }
  }
  impl_->show_start();
  return impl_->status == RunStatus::running ? RunStatus::completed : impl_->status;
}

}  // namespace cogrsim
