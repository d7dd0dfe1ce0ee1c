// The step order and the clock.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include "simulation/impl.h"

namespace cogrsim {

namespace {

bool covers(const FrameContents& has, const FrameContents& wanted) {
  return (has.contacts || !wanted.contacts) && (has.joint_reactions || !wanted.joint_reactions) &&
         (has.accelerations || !wanted.accelerations);
}

}  // namespace

struct Observation::Slot {
  FrameContents contents;
  Simulation::Observer call;
  bool ended = false;
};

void Observation::end() {
  if (const auto slot = slot_.lock()) slot->ended = true;
}

void Simulation::Impl::get_state(WorldState& out) const {
  world->get_state(out);
  const auto known = [](const std::vector<double>& before, std::vector<double>& now) {
    std::copy_n(before.begin(), std::min(before.size(), now.size()), now.begin());
  };
  known(joint_efforts_before, out.joint_efforts);
  known(motor_efforts_before, out.motor_efforts);
}

const WorldState& Simulation::Impl::present_state() {
  if (!state_fresh) {
    if (world) {
      get_state(state);
    } else {  // the world could not be built; handles still work while errors are collected
      state.poses.resize(model->bodies.size());
      state.twists.resize(model->bodies.size());
      state.joint_positions.assign(static_cast<std::size_t>(model->joint_positions), 0.0);
      state.joint_velocities.assign(static_cast<std::size_t>(model->joint_speeds), 0.0);
      state.joint_efforts.assign(static_cast<std::size_t>(model->joint_speeds), 0.0);
      state.motor_efforts.assign(model->motors.size(), 0.0);
    }
    state_fresh = true;
  }
  return state;
}

void Simulation::Impl::world_changed() {
  state_fresh = false;
  cached.reset();
}

void Simulation::Impl::copy_controller_outputs(Frame& frame) const {
  frame.controller_outputs.resize(controllers.size());
  for (std::size_t i = 0; i < controllers.size(); ++i) {
    frame.controller_outputs[i].clear();
    if (controllers[i].access) frame.controller_outputs[i] = controllers[i].access->outputs;
  }
}

FramePtr Simulation::Impl::frame_with(const FrameContents& contents) {
  if (cached && covers(cached_contents, contents)) return cached;
  const FrameContents wanted = cached ? cached_contents | contents : contents;
  std::shared_ptr<Frame> frame = pool->take();
  frame->model = model;
  frame->step = clock.steps();
  frame->time = time();
  frame->dt = clock.last_dt();
  frame->state = present_state();
  frame->accelerations.clear();
  if (wanted.accelerations && !twists_before.empty() && clock.last_dt() > 0.0) {
    mean_accelerations(twists_before, frame->state.twists, clock.last_dt(), frame->accelerations);
  }
  frame->contacts.clear();
  if (wanted.contacts) world->get_contacts(frame->contacts);
  frame->joint_reactions.clear();
  if (wanted.joint_reactions) {
    if (auto* reactions = static_cast<JointReactions*>(world->extension(JointReactions::kId))) {
      reactions->get_joint_reactions(frame->joint_reactions);
    }
  }
  sensors.copy_readings(frame->readings);
  frame->channels = sensors.channels();
  frame->events = events;
  copy_controller_outputs(*frame);
  frame->supervisor_outputs.resize(supervisors.size());
  for (std::size_t i = 0; i < supervisors.size(); ++i) {
    if (supervisors[i].context) frame->supervisor_outputs[i] = supervisors[i].context->outputs();
  }
  cached = std::move(frame);
  cached_contents = wanted;
  return cached;
}

bool Simulation::Impl::wants_accelerations() const {
  return sensors.wants_accelerations() ||
         std::any_of(supervisors.begin(), supervisors.end(),
                     [](const SupervisorSlot& s) { return s.needs.accelerations; }) ||
         std::any_of(observers.begin(), observers.end(),
                     [](const auto& w) { return w->contents.accelerations && !w->ended; });
}

void Simulation::Impl::read_sensors() {
  const auto needed = sensors.begin(time(), clock.dt());
  if (!needed) return;
  sensing.show(frame_with(*needed));
  for (const SensorFault& fault : sensors.read(sensing)) {
    const std::string& name = model->sensors[static_cast<std::size_t>(fault.sensor)].name;
    log.report(Severity::error, name, "sensor '" + name + "' cannot measure: " + fault.error.text());
  }
  sensing.hide();
}

// Warns once in a run about rotations that are too fast for the time step: integrators of any order
// lose accuracy if a body turns by a large angle in a step, and wheels slip. Checked only in some
// steps, because reading the state has a cost.
void Simulation::Impl::check_spin() {
  constexpr std::uint64_t kEvery = 64;  // steps
  constexpr double kMost = 0.5;         // [rad] in a step
  if (spin_reported || clock.steps() % kEvery != 1) return;
  const double dt = clock.dt();
  const WorldState& now = present_state();
  for (std::size_t i = 0; i < now.twists.size(); ++i) {
    const double turned = now.twists[i].angular.norm() * dt;
    if (model->bodies[i].removed || !(turned > kMost)) continue;
    spin_reported = true;
    log.report(Severity::warning, model->bodies[i].name,
           fmt::format("body '{}' turns by {:.2g} rad in a step of {} ms: beyond {} rad engines "
                       "gain or lose energy; a step of {:.2g} ms keeps it below",
                       model->bodies[i].name, turned, 1e3 * dt, kMost, 1e3 * dt * kMost / turned));
    return;
  }
}

void Simulation::Impl::show_frame() {
  observers.erase(std::remove_if(observers.begin(), observers.end(),
                                [](const auto& observer) { return observer->ended; }),
                 observers.end());
  if (observers.empty()) return;
  FrameContents needed;
  for (const auto& observer : observers) needed = needed | observer->contents;
  if (needed.for_sensors) needed = needed | sensors.needs();
  const FramePtr frame = frame_with(needed);
  for (const auto& observer : observers)
    if (!observer->ended) observer->call(frame);
}

void Simulation::Impl::show_start() {
  if (start_shown || observers.empty()) return;
  start_shown = true;
  show_frame();
}

void Simulation::Impl::apply_forces() {
  forces.apply(
      *world, model, present_state(), time(), clock.dt(),
      [this](int sensor) { return &sensors.channels(static_cast<std::size_t>(sensor)); },
      [this](const FrameContents& contents) {
        // Controllers have published since the frame of this step was made.
        auto frame = std::make_shared<Frame>(*frame_with(contents));
        copy_controller_outputs(*frame);
        return FramePtr(std::move(frame));
      });
}

RunStatus Simulation::Impl::step() {
  if (stop_requested.exchange(false) && status == RunStatus::running) status = RunStatus::stopped;
  const auto begin = [this] {
    if (status != RunStatus::running) return;
    show_start();
    if (!event_system.memory.started) detect_events();
    apply_due();
  };
  begin();
  apply_commands();                     // also after the end, because of Restart
  if (!event_system.memory.started) begin();  // the new run
  if (ending && pace.waits()) status = RunStatus::stopped;
  if (status != RunStatus::running || pace.waits()) return status;
  pace.single_step = false;
  read_sensors();
  run_controllers();
  if (status != RunStatus::running) return status;
  if (!model->motors.empty()) make_drives(*model, present_state(), clock.dt(), motors, drives);
  if (wants_accelerations()) {
    twists_before = present_state().twists;
  } else {
    twists_before.clear();
  }
  apply_forces();
  const StepResult result = [&] {
    const PluginCall call("backend", backend->name(), "", "", "in a step", time());
    return world->step(clock.dt(), drives);
  }();
  joint_efforts_before.clear();
  motor_efforts_before.clear();
  world_changed();
  if (result.status == StepStatus::diverged) {
    status = RunStatus::diverged;
    const std::string body =
        result.body >= 0 ? model->bodies[static_cast<std::size_t>(result.body)].name : "";
    // Some engines already name the body in their message.
    const bool named = body.empty() || result.message.find("'" + body + "'") != std::string::npos;
    log.report(Severity::error, body.empty() ? "physics" : body,
           "diverged: " + (named ? "" : "body '" + body + "': ") + result.message);
    return status;
  }
  clock.advance();
  check_spin();
  detect_events();
  show_frame();
  events.clear();
  event_causes.clear();
  event_system.memory.added_in_step = 0;
  if (ending) status = RunStatus::stopped;
  return status;
}

Simulation::Simulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Simulation::~Simulation() {
  // Controllers and sensors are destroyed before the world that they use.
  impl_->controllers.clear();
  impl_->supervisors.clear();
  impl_->sensors.clear();
  impl_->world.reset();
}

const Backend& Simulation::backend() const { return *impl_->backend; }
const Provenance& Simulation::provenance() const { return impl_->provenance; }
const SceneModelPtr& Simulation::model() const { return impl_->model; }
double Simulation::time() const { return impl_->time(); }
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
  return impl_->sensors.channels(static_cast<std::size_t>(sensor));
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
      std::this_thread::sleep_until(std::min(due, WallClock::now() + std::chrono::milliseconds(10)));
    }
  }
  impl_->show_start();
  return impl_->status == RunStatus::running ? RunStatus::completed : impl_->status;
}

}  // namespace cogrsim
