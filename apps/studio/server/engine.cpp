// Executes requests, and paces the run.
#include "engine.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/physics/default_backend.h"
#include "cogrsim/physics/leave_out.h"
#include "common/terminal.h"
#include "run_wire.h"

namespace cogrsim::studio {

namespace {

/// A piece of work between two checks for requests.
constexpr auto kPiece = std::chrono::milliseconds(8);
/// Short sleeps are inaccurate: several steps are done at a time.
constexpr auto kNap = std::chrono::milliseconds(2);
constexpr auto kStatusInterval = std::chrono::milliseconds(50);
/// A run that cannot keep up does not catch up later.
constexpr double kMostBehind = 0.1;  // [s] of wall-clock time
/// A plugin that does not return for so long is not waited for at the end, as in runs from the
/// command line.
constexpr double kMostAtEnd = 3.0;  // [s]
/// From one common time of two runs to the next: twice what steps_meet() allows to both together.
constexpr int kMostApart = 4000;

}  // namespace

Error to_error(const Refusal& found) {
  const Diagnostic* first = first_error(found);
  if (first == nullptr) return Error("the scene was refused");
  Error error = to_error(*first);
  const auto errors = std::count_if(found.begin(), found.end(), [](const Diagnostic& d) {
    return d.severity == Severity::error;
  });
  if (errors > 1) error.message += " (and " + std::to_string(errors - 1) + " more)";
  return error;
}

Engine::Engine(RunOptions options, std::vector<std::string> plugin_folders, History& history,
               Scenes& scenes, StatusPublisher& publisher, std::function<void()> restarted)
    : options_(std::move(options)),
      plugin_folders_(std::move(plugin_folders)),
      history_(history),
      scenes_(scenes),
      publisher_(publisher),
      restarted_(std::move(restarted)),
      backend_(options_.backend) {
  if (options_.step > 0.0) dt_ = options_.step;
  thread_ = std::thread([this] { run(); });
  onlooker_ = std::thread([this] { watch_calls(); });
}

Engine::~Engine() {
  finish();
  thread_.join();
  onlooker_.join();
}

std::string Engine::finish() {
  std::unique_lock lock(mutex_);
  over_ = true;
  asked_ = true;
  waiting_.notify_one();
  const Clock::time_point begin = Clock::now();
  while (!ending_or_time_.wait_for(lock, kNap, [this] { return ended_; })) {
    const auto call = watch_.call();
    const std::chrono::duration<double> waited = Clock::now() - begin;
    if (call && std::min(call->lasts, waited.count()) > kMostAtEnd) return described(*call);
  }
  return {};
}

void Engine::post(std::function<void()> task) {
  std::lock_guard lock(mutex_);
  tasks_.push_back(std::move(task));
  asked_ = true;
  waiting_.notify_one();
}

void Engine::post_ending(std::function<void()> task) {
  ++endings_;
  post([this, task = std::move(task)] {
    --endings_;
    task();
  });
}

bool Engine::run_tasks() {
  for (;;) {
    std::function<void()> task;
    {
      std::lock_guard lock(mutex_);
      if (over_) return false;
      if (tasks_.empty()) {
        asked_ = false;
        return true;
      }
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    task();
  }
}

void Engine::run() {
  watch_.watch_this_thread();
  while (run_tasks()) {
    const bool stepping = steps_left_ > 0;
    if (simulation_ && (state_ == State::playing || stepping)) {
      const Clock::duration rest = stepping ? Clock::duration::zero() : until_due();
      if (rest <= Clock::duration::zero()) {
        run_piece();
        continue;
      }
      std::unique_lock lock(mutex_);
      waiting_.wait_for(lock, std::max<Clock::duration>(rest, kNap),
                        [this] { return over_ || !tasks_.empty(); });
      continue;
    }
    std::unique_lock lock(mutex_);
    waiting_.wait(lock, [this] { return over_ || !tasks_.empty(); });
  }
  end_recording("");
  settle();
  ghost_.reset();
  simulation_.reset();
  std::lock_guard lock(mutex_);
  ended_ = true;
  ending_or_time_.notify_all();
}

void Engine::anchor() {
  anchor_wall_ = measured_wall_ = Clock::now();
  anchor_time_ = measured_time_ = simulation_ ? simulation_->time() : 0.0;
}

Engine::Clock::duration Engine::until_due() const {
  if (!speed_) return Clock::duration::zero();
  const double next = simulation_->time() + simulation_->dt() - anchor_time_;
  const auto due = anchor_wall_ + std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(next / *speed_));
  return due - Clock::now();
}

void Engine::run_piece() {
  const Clock::time_point begin = Clock::now();
  bool going = true;
  while (going) {
    const bool stepping = steps_left_ > 0;
    const bool within = within_duration();
    going = advance();
    if (going && stepping && --steps_left_ == 0) {
      state_ = State::paused;
      going = false;
    }
    if (going && !stepping && within && !within_duration()) {
      state_ = State::paused;
      ending_ =
          "the scene's duration, " + cli::time_text(*scene_->model->physics.duration) + ", is over";
      going = false;
    }
    if (Clock::now() - begin >= kPiece || asked_.load(std::memory_order_relaxed)) break;
    if (going && !stepping && until_due() > Clock::duration::zero()) break;
  }
  if (!going) settle();
  if (speed_ && going) {
    const double behind = std::chrono::duration<double>(-until_due()).count();
    if (behind > kMostBehind) {
      anchor_wall_ = Clock::now();
      anchor_time_ = simulation_->time();
    }
  }
  collect_messages();
  measure();
  if (going && Clock::now() - status_published_ < kStatusInterval) return;
  status_published_ = Clock::now();
  publish(!going);
}

/// As runs from the command line: the run is over at the end of the step nearest to its duration.
bool Engine::within_duration() const {
  const std::optional<double>& duration = scene_->model->physics.duration;
  return duration && simulation_->time() + 0.5 * simulation_->dt() < *duration;
}

bool Engine::step_main() {
  give_hands();
  const std::uint64_t before = simulation_->step_count();
  const RunStatus status = simulation_->step();
  if (simulation_->step_count() != before && status == RunStatus::running) return true;
  if (status != RunStatus::running) {
    found_status();
    return false;
  }
  // A supervisor has paused it; stepping resumes it.
  state_ = State::paused;
  return false;
}

bool Engine::step_ghost() {
  Simulation& other = *ghost_->simulation;
  for (int tries = 0; tries < 2; ++tries) {
    const std::uint64_t before = other.step_count();
    const RunStatus status = other.step();
    if (status != RunStatus::running) {
      const std::vector<RunMessage>& said = other.messages();
      end("the second run (" + ghost_->labels[1] +
          ") ended: " + (said.empty() ? std::string(to_string(status)) : said.back().message));
      return false;
    }
    if (other.step_count() != before) return true;
    other.send(Resume{});  // the first run alone is paused
  }
  end("the second run (" + ghost_->labels[1] + ") does not advance");
  return false;
}

bool Engine::advance() {
  if (!ghost_) {
    if (!step_main()) return false;
  } else {
    const double tick = std::min(simulation_->dt(), ghost_->simulation->dt());
    int steps = 0;
    do {
      // Something in the run has set another step: they would be stepped for ever.
      if (++steps > kMostApart) {
        end("the steps of the two runs have no time in common any more");
        return false;
      }
      // Half a tick of slack: clocks that agree differ by rounding at most.
      const double ahead = simulation_->time() - ghost_->simulation->time();
      if (ahead < 1e-6 * tick ? !step_main() : !step_ghost()) return false;
    } while (std::fabs(simulation_->time() - ghost_->simulation->time()) > 1e-6 * tick);
  }
  take_instant(due_to_be_kept());
  return true;
}

/// When the run stops: the newest instant can be sought, and pending requests are answered.
void Engine::settle() {
  steps_left_ = 0;
  if (simulation_ && state_ != State::playing && latest_) take_instant(true);
  if (step_reply_) std::exchange(step_reply_, nullptr)(Json::object());
}

Result<> Engine::may_run() const {
  if (!simulation_)
    return fail("there is no scene yet that can be run", "", "mend what is wrong in it");
  if (scene_->only_shown)
    return fail(
        "the scene is shown without what needs a plugin that is not found, and does not run", "",
        "build the plugin, or mend its name");
  if (state_ == State::ended)
    return fail("the run has ended: " + ending_, "", "stop goes back to the start");
  return {};
}

Answer Engine::play() {
  if (auto good = may_run(); !good) return tl::unexpected(good.error());
  if (simulation_->paused()) simulation_->send(Resume{});
  settle();
  if (state_ != State::playing) anchor();
  state_ = State::playing;
  ending_.clear();
  publish(true);
  return Json::object();
}

Answer Engine::pause() {
  if (state_ == State::playing || steps_left_ > 0) state_ = State::paused;
  settle();
  publish(true);
  return Json::object();
}

void Engine::pause(const Reply& reply) {
  const bool answered = publisher_.pause_meanwhile();
  if (answered) reply(Json::object());
  post([this, reply, answered] {
    Answer answer = pause();
    if (!answered) reply(std::move(answer));
  });
}

Answer Engine::stop(bool then_play) {
  if (!scene_) return fail("there is no scene yet that can be run");
  settle();
  const std::optional<CompareRequest> request =
      ghost_ ? std::optional<CompareRequest>(ghost_->request) : std::nullopt;
  if (auto done = begin_again(*scene_, backend_, dt_, request); !done) {
    return tl::unexpected(to_error(done.error()));
  }
  return then_play ? play() : Answer(Json::object());
}

void Engine::step(std::int64_t count, Reply reply) {
  if (auto good = may_run(); !good) return reply(tl::unexpected(good.error()));
  settle();
  if (simulation_->paused()) simulation_->send(Resume{});
  anchor();
  state_ = State::paused;
  ending_.clear();
  steps_left_ = count;
  step_reply_ = std::move(reply);
}

Answer Engine::set_speed(std::optional<double> factor) {
  speed_ = factor;
  if (simulation_) anchor();
  publish(true);
  return Json::object();
}

Answer Engine::reload(const std::optional<std::string>& controller) {
  if (!simulation_ || state_ != State::paused) {
    return fail("controllers are reloaded while the run is paused", "", "pause it first");
  }
  if (ghost_) {
    return fail("controllers are not reloaded while two runs are compared", "",
                "end the comparison first");
  }
  std::vector<std::string> names;
  if (controller) {
    names.push_back(*controller);
  } else {
    for (const ControllerModel& each : simulation_->model()->controllers) {
      if (!each.removed) names.push_back(each.name);
    }
  }
  if (names.empty()) return fail("the scene has no controllers");
  lose_inputs("controllers were reloaded");
  Json reloaded = Json::array(), kept = Json::array();
  for (const std::string& name : names) {
    const auto done = simulation_->reload_controller(name);
    if (!done && controller) return tl::unexpected(done.error());
    if (!done) {
      kept.push_back({{"controller", name}, {"message", done.error().text()}});
      continue;
    }
    reloaded.push_back({{"controller", done->controller},
                        {"version", done->version},
                        {"memory_kept", done->memory_kept},
                        {"note", done->note}});
  }
  tell_processes();
  collect_messages();
  publish(true);
  return Json{{"reloaded", std::move(reloaded)}, {"kept", std::move(kept)}};
}

Answer Engine::set_step(std::optional<double> dt) {
  if (!simulation_) {
    dt_ = dt;
    publish(true);
    return Json::object();
  }
  if (ghost_ && ghost_->request.step) {
    return fail("the two runs that are compared have steps of their own", "",
                "end the comparison first");
  }
  if (simulation_->step_count() == 0) {
    const auto request = ghost_ ? std::optional<CompareRequest>(ghost_->request) : std::nullopt;
    const bool playing = state_ == State::playing;
    if (auto done = begin_again(*scene_, backend_, dt, request); !done) {
      return tl::unexpected(to_error(done.error()));
    }
    dt_ = dt;
    // The status published in between still had the previous step.
    publish(true);
    return playing ? play() : Answer(Json::object());
  }
  const double now = dt.value_or(scene_->model->physics.step);
  if (auto given = give(SetStep{now}); !given) return tl::unexpected(given.error());
  dt_ = dt;
  if (ghost_) ghost_->simulation->send(SetStep{now});
  publish(true);
  return Json::object();
}

/// What `act` refuses changes nothing; a run that was playing plays on.
Answer Engine::with_options(const Without& without, const std::function<Answer()>& act) {
  const std::vector<std::string> before = options_.without;
  if (without) {
    if (auto good = check_without(*without); !good) return tl::unexpected(good.error());
    options_.without = *without;
  }
  settle();
  const bool playing = state_ == State::playing;
  Answer answer = act();
  if (!answer) {
    options_.without = before;
  } else if (playing && state_ != State::playing) {
    if (auto going = play(); !going) return going;
  }
  return answer;
}

Answer Engine::set_backend(const std::string& name, const Without& without) {
  const bool anyway = without && *without != options_.without;
  return with_options(without, [&] { return continue_on(name, anyway); });
}

Answer Engine::continue_on(const std::string& name, bool anyway) {
  if (!scene_ && !refused_) {
    backend_ = name;
    publish(true);
    return Json{{"notes", Json::array()}};
  }
  const Scene scene = refused_ ? *refused_ : *scene_;
  std::vector<std::string> notes;
  if (ghost_ || !simulation_ || simulation_->step_count() == 0 || state_ == State::ended) {
    const auto request = ghost_ ? std::optional<CompareRequest>(ghost_->request) : std::nullopt;
    if (simulation_ && simulation_->step_count() > 0) {
      notes.push_back(ghost_ ? "the comparison restarts" : "the run restarts: it had ended");
    }
    if (auto done = begin_again(scene, name, dt_, request); !done) {
      return tl::unexpected(to_error(done.error()));
    }
  } else {
    auto carried = carry_over(scene, name, anyway);
    if (!carried) return tl::unexpected(to_error(carried.error()));
    notes = std::move(*carried);
  }
  backend_ = name;
  refused_.reset();
  publish(true);
  return Json{{"notes", notes}};
}

Answer Engine::lacking(const std::string& name, bool beside) const {
  if (!scene_ && (beside || !refused_)) return fail("there is no scene yet that can be run");
  const SceneModelPtr model = (refused_ && !beside ? *refused_ : *scene_).model;
  std::vector<std::string> asked = {name.empty() ? backend_ : name};
  if (ghost_ && !beside && ghost_->request.backend) asked.push_back(*ghost_->request.backend);
  PluginLoader loader(plugin_folders_);
  Json answer;
  for (std::string& chosen : asked) {
    if (chosen.empty()) chosen = model->physics.backend;
    const auto backend = loader.backend(chosen.empty() ? kDefaultBackend : chosen);
    if (!backend) return tl::unexpected(backend.error());
    const Capabilities& has = (*backend)->capabilities();
    std::vector<LeftOut> lacks;
    const SceneModelPtr rest = leave_out(model, has, {"lacking"}, &lacks);
    Json needed = Json::array();
    for (const Diagnostic& it : check_capabilities(*rest, (*backend)->name(), has))
      if (it.severity == Severity::error) needed.push_back(it.message);
    const bool hopeless = !needed.empty();
    if (answer.is_null() || hopeless || (answer.at("left_out").empty() && !lacks.empty()))
      answer = {{"name", std::string((*backend)->name())},
                {"left_out", to_json(lacks)},
                {"needed", std::move(needed)}};
    if (hopeless) break;
  }
  return answer;
}

Answer Engine::compare(CompareRequest request, const Without& without) {
  if (!scene_) return fail("there is no scene yet that can be run");
  return with_options(without, [&]() -> Answer {
    if (auto done = begin_again(*scene_, backend_, dt_, std::move(request)); !done)
      return tl::unexpected(to_error(done.error()));
    return Json::object();
  });
}

Answer Engine::end_compare() {
  if (!ghost_) return fail("nothing is compared");
  settle();
  ghost_.reset();
  if (state_ == State::ended && simulation_->status() == RunStatus::running) {
    state_ = State::paused;  // the second one alone had ended
    ending_.clear();
  }
  take_instant(true);
  publish(true);
  return Json::object();
}

}  // namespace cogrsim::studio
