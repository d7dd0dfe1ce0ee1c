// What is kept of a run, and what is published.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "engine.h"

namespace cogrsim::studio {

namespace {

/// Of scenes with no more bodies than this, every step is kept; of others the rate of a display.
constexpr std::size_t kSmallScene = 64;
constexpr double kBetweenKept = 0.01;  // [s]
constexpr auto kBetweenPublished = std::chrono::microseconds(15'000);
/// A call that lasts longer is reported.
constexpr double kLong = 0.5;  // [s]
constexpr auto kBetweenLooks = std::chrono::milliseconds(200);

/// Thousands of frames are kept: pictures are rendered again from them when a client asks.
FramePtr without_pictures(const FramePtr& frame) {
  const auto has = [](const Reading& reading) { return reading.picture != nullptr; };
  if (std::none_of(frame->readings.begin(), frame->readings.end(), has)) return frame;
  auto plain = std::make_shared<Frame>(*frame);
  for (Reading& reading : plain->readings) reading.picture.reset();
  return plain;
}

}  // namespace

std::string described(const PluginWatch::Call& call) {
  std::string out = call.kind;
  if (!call.name.empty()) out += " '" + call.name + "'";
  if (!call.of.empty()) out += " of '" + call.of + "'";
  return out;
}

void Engine::watch_calls() {
  bool reported = false, over = false;
  while (true) {
    {
      std::unique_lock lock(mutex_);
      if (ending_or_time_.wait_for(lock, kBetweenLooks, [this] { return ended_; })) return;
      over = over_;
    }
    auto call = watch_.call();
    if (call && call->lasts < kLong) call.reset();
    if (call && (over || endings_ > 0)) watch_.give_up();
    if (call || reported) publisher_.set_waiting(call);
    reported = call.has_value();
  }
}

void Engine::watch_processes(Run::ProcessListener changed) {
  {
    const std::lock_guard lock(listener_mutex_);
    processes_changed_ = std::move(changed);
    if (!processes_changed_) return;
  }
  ask_processes();
}

void Engine::ask_processes() {
  post([this] { tell_processes(); });
}

void Engine::tell_processes() {
  const std::lock_guard lock(listener_mutex_);
  if (processes_changed_ && simulation_) processes_changed_(simulation_->controller_processes());
}

std::optional<HeldCall> Engine::held_call(const std::string& controller) const {
  std::optional<HeldCall> out;
  watch_.during([&](const PluginWatch::Call& call) {
    // It may stand outside its update: then the run goes on, and changes what would be read here.
    if (call.kind != "controller" || call.name != controller) return;
    if (!simulation_) return;  // its first controllers are being made
    const SceneModel& model = *simulation_->model();
    const auto found = std::find_if(
        model.controllers.begin(), model.controllers.end(),
        [&](const ControllerModel& one) { return !one.removed && one.name == controller; });
    if (found == model.controllers.end()) return;
    out = HeldCall{simulation_->time(), {}};
    for (std::size_t i = 0; i < model.sensors.size(); ++i) {
      const SensorModel& sensor = model.sensors[i];
      int owner = sensor.assembly;
      while (owner >= 0 && owner != found->assembly)
        owner = model.assemblies[static_cast<std::size_t>(owner)].parent;
      if (sensor.removed || owner != found->assembly) continue;
      const Reading& reading = simulation_->reading(static_cast<int>(i));
      out->readings.push_back({sensor.name, reading.time, reading.valid,
                               simulation_->channels(static_cast<int>(i)), reading.values});
    }
  });
  return out;
}

Answer Engine::end_controller() {
  const auto call = watch_.call();
  if (!call || call->lasts < kLong) return fail("no controller is waited for");
  if (watch_.give_up()) return Json{{"controller", call->name}};
  return fail(described(*call) + " runs in the studio's own process and cannot be ended alone", "",
              "end the studio where it was started, with Ctrl-C" +
                  std::string(call->kind == "controller"
                                  ? "; with isolation=\"process\" it has a process of its own"
                                  : ""));
}

void Engine::on_frame(const FramePtr& frame) {
  // The frame at the start is shown once more with the first step.
  const bool again = latest_ && latest_->step == frame->step;
  if (latest_ && frame->step < latest_->step) {
    // Inputs are known by their steps, which come once more.
    if (inputs_.lost.empty())
      inputs_.lost = fmt::format("the run was restarted at {:.6g} s", latest_->time);
    forget_past();
  }
  latest_ = frame;
  if (again) return;
  for (const Event& event : frame->events) {
    if (event.kind == "ended") end_reason_ = event.message;
    publisher_.add_event(event);
  }
}

bool Engine::due_to_be_kept() const {
  if (steps_left_ > 0 || !last_kept_ || latest_->model->bodies.size() <= kSmallScene) return true;
  // Half a step of slack, so that rounding does not halve the rate.
  return latest_->time - *last_kept_ >= kBetweenKept - 0.5 * simulation_->dt();
}

Instant Engine::instant() {
  Instant out;
  out.frame = without_pictures(latest_);
  if (ghost_) {
    const FramePtr other = without_pictures(ghost_->simulation->frame());
    // Where one of them ended it may be a step ahead.
    if (std::fabs(other->time - latest_->time) < 0.5 * simulation_->dt()) out.ghost = other;
  }
  if (latest_->model != numbered_model_) {
    const bool same_lineage = numbered_model_ != nullptr || same_lineage_;
    numbered_model_ = latest_->model;
    same_lineage_ = false;
    scene_number_ = scenes_.add(numbered_model_, origins_, same_lineage,
                                [this](int sensor) -> const std::vector<Channel>& {
                                  return simulation_->channels(sensor);
                                });
  }
  out.scene = scene_number_;
  return out;
}

void Engine::take_instant(bool keep) {
  history_.paths().take(*latest_);
  const bool publish_due = Clock::now() - published_ >= kBetweenPublished;
  if (!keep && !publish_due && !ghost_ && latest_->model == numbered_model_) return;
  Instant now = instant();
  if (now.ghost && !ghost_->first_over) {
    if (const auto found = ghost_->divergence.look(*now.frame, *now.ghost)) {
      ghost_->first_over = found->time;
      Event event;
      event.time = found->time;
      event.kind = "diverged";
      event.source = found->body;
      event.message =
          fmt::format("{} and {} have diverged by {:.3g} cm and {:.3g} degrees", ghost_->labels[0],
                      ghost_->labels[1], 100.0 * found->distance, found->angle * 180.0 / M_PI);
      publisher_.add_event(std::move(event));
      keep = true;
    }
  }
  if (keep) {
    last_kept_ = now.time();
    publisher_.discard(history_.add(now));
  }
  if (keep && !publish_due && state_ == State::playing) return;
  published_ = Clock::now();
  publisher_.set_newest(std::move(now));
}

void Engine::end(const std::string& why) {
  state_ = State::ended;
  ending_ = why;
  steps_left_ = 0;
}

void Engine::found_status() {
  const RunStatus status = simulation_->status();
  const std::vector<RunMessage>& said = simulation_->messages();
  const auto last_error = std::find_if(said.rbegin(), said.rend(), [](const RunMessage& m) {
    return m.severity == Severity::error;
  });
  const std::string error = last_error == said.rend() ? "" : last_error->message;
  switch (status) {
    case RunStatus::diverged:
      end(error.empty() ? "the physics diverged" : error);
      break;
    case RunStatus::fault:
      end("a fault ended it: " + error);
      break;
    case RunStatus::stopped:
      end(end_reason_.empty() ? "a supervisor ended it" : end_reason_);
      break;
    case RunStatus::running:
    case RunStatus::completed:
      end(to_string(status));
      break;
  }
  // The step in which it ended was observed; a failed step has no frame.
  if (latest_) take_instant(true);
}

void Engine::collect_messages() {
  const std::vector<RunMessage>& all = simulation_->messages();
  if (messages_seen_ >= all.size()) return;
  publisher_.add_messages({all.begin() + static_cast<std::ptrdiff_t>(messages_seen_), all.end()});
  messages_seen_ = all.size();
}

void Engine::measure() {
  const Clock::time_point now = Clock::now();
  const double wall = std::chrono::duration<double>(now - measured_wall_).count();
  if (wall < 0.5) return;
  factor_ = (simulation_->time() - measured_time_) / wall;
  measured_wall_ = now;
  measured_time_ = simulation_->time();
}

void Engine::publish(bool urgent) {
  Situation s;
  switch (state_) {
    case State::stopped:
      s.state = "stopped";
      break;
    case State::playing:
      s.state = "playing";
      break;
    case State::paused:
      s.state = "paused";
      break;
    case State::ended:
      s.state = "ended";
      break;
  }
  s.ending = ending_;
  s.speed = speed_;
  s.factor = state_ == State::playing ? factor_ : 0.0;
  s.backend = backend_;
  s.dt = dt_.value_or(0.0);
  if (scene_) {
    s.scene_dt = scene_->model->physics.step;
    if (!dt_) s.dt = s.scene_dt;
  }
  if (simulation_) {
    s.time = simulation_->time();
    s.step_count = simulation_->step_count();
    s.backend = simulation_->backend().name();
    s.engine_version = simulation_->backend().engine_version();
    s.provenance = provenance_;
    s.controllers = simulation_->controller_inputs();
  }
  if (recorder_) s.recording = recording_;
  s.scene = scene_number_;
  s.inputs = inputs_.list.size();
  if (latest_ && state_ != State::playing) {
    s.state_hash = fmt::format("{:016x}", state_hash(latest_->state));
  }
  if (ghost_)
    s.compare = {ghost_->labels, ghost_->first_over, ghost_->simulation->provenance().left_out};
  publisher_.set_situation(std::move(s), urgent);
}

}  // namespace cogrsim::studio
