#include "debugger.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

namespace cogrsim::studio {

namespace fs = std::filesystem;

namespace {

/// A run does not wait for gdb for longer than this before it goes on without it.
constexpr auto kRunWaits = std::chrono::seconds(30);
/// Pages that are loaded again are back by then.
constexpr auto kOperatorsAway = std::chrono::seconds(10);
constexpr std::size_t kMostValues = 64;  // of a sensor

}  // namespace

Debugger::Debugger(DebuggerOptions options, Run& run, Outbox& outbox)
    : options_(std::move(options)), run_(run), outbox_(outbox), sources_(options_.folder) {
  thread_ = std::thread([this] { work(); });
  if (options_.allowed)
    run_.watch_processes([this](const auto& processes) { processes_changed(processes); });
}

Debugger::~Debugger() {
  finish();
  run_.watch_processes(nullptr);
}

void Debugger::finish() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  news_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Debugger::post(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  news_.notify_all();
}

void Debugger::work() {
  while (true) {
    std::function<void()> job;
    {
      std::unique_lock lock(mutex_);
      const auto due = [this] { return over_ || !jobs_.empty(); };
      if (leave_at_ ? !news_.wait_until(lock, *leave_at_, due) : (news_.wait(lock, due), false)) {
        lock.unlock();
        leave_at_.reset();
        detach("the last page was closed");
        continue;
      }
      if (over_) break;
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    attempt(job);
  }
  session_.reset();
}

/// What goes wrong unforeseen ends the debugging, and not the studio.
void Debugger::attempt(const std::function<void()>& job) {
  try {
    job();
  } catch (const std::exception& e) {
    detach(std::string("the debugger failed: ") + e.what());
  }
}

// ---- requests

void Debugger::handle(Request request, Reply reply) {
  if (!options_.allowed)
    return reply(fail("nothing is debugged from the page", "",
                      "start the studio with --allow-build", "not-allowed"));
  post([this, request = std::move(request), reply = std::move(reply)] {
    Answer out = fail("the debugger failed", "", "press Debug again");
    attempt([&] { out = answer(request); });
    reply(std::move(out));
  });
}

Answer Debugger::answer(const Request& request) {
  const Json& f = request.fields;
  const std::string& what = request.what;
  if (what == "debug-attach") {
    attach(f.at("controller").get<std::string>());
    return Json::object();
  }
  if (what == "debug-detach") {
    detach();
    return Json::object();
  }
  if (what == "debug-breakpoints") {
    std::vector<DebugBreakpoint> wanted;
    for (const Json& one : f.at("breakpoints")) {
      DebugBreakpoint breakpoint;
      breakpoint.file = one.at("file").get<std::string>();
      breakpoint.line = one.at("line").get<int>();
      breakpoint.condition = one.at("condition").get<std::string>();
      wanted.push_back(std::move(breakpoint));
    }
    if (session_) session_->place(wanted);
    breakpoints_ = std::move(wanted);
    publish();
    return Json::object();
  }
  if (!session_)
    return fail("no controller is in the debugger", "", "press Debug in the code panel");
  if (what == "debug-run") {
    const auto how = f.at("how").get<std::string>();
    if (auto done = session_->run(how); !done) return tl::unexpected(done.error());
    return Json::object();
  }
  if (what == "debug-variables") return session_->variables(f.at("frame").get<int>());
  if (what == "debug-children") return session_->children(f.at("of").get<std::string>());
  return session_->evaluate(f.at("expression").get<std::string>(), f.at("frame").get<int>());
}

void Debugger::attach(const std::string& controller) {
  if (controller_ == controller && session_) return;
  detach();
  controller_ = controller;
  follow_process();
  // The run tells of no controller that a supervisor has added or restarted.
  run_.ask_processes();
}

void Debugger::detach(const std::string& note) {
  ++session_number_;
  session_.reset();
  refused_ = 0;
  if (controller_.empty() && state_ == State::off) return;
  controller_.clear();
  process_ = 0;
  state_ = State::off;
  stop_ = {};
  held_.reset();
  note_ = note;
  help_.clear();
  publish();
}

/// The controller stays the one that is wanted: its next process is debugged, too.
void Debugger::drop_session(const std::string& note, const std::string& help) {
  ++session_number_;
  session_.reset();
  process_ = 0;
  state_ = State::waiting;
  stop_ = {};
  held_.reset();
  for (DebugBreakpoint& one : breakpoints_) one.placed.reset();
  note_ = note;
  help_ = help;
  publish();
}

std::optional<ControllerProcess> Debugger::wanted_process() {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::find_if(processes_.begin(), processes_.end(),
                   [this](const ControllerProcess& one) { return one.controller == controller_; });
  return found == processes_.end() ? std::nullopt : std::optional(*found);
}

void Debugger::follow_process() {
  if (controller_.empty()) return;
  const auto wanted = wanted_process();
  if (session_ && wanted && wanted->process == process_) return;
  if (!wanted)
    return drop_session("the run has no controller '" + controller_ + "' yet",
                        "when it has, it is debugged");
  if (wanted->process == 0) {
    if (!session_ && state_ == State::waiting && !note_.empty()) return;  // how it ended
    return drop_session(
        "controller '" + controller_ + "' has no process of its own",
        "Restart gives it another one when a fault has ended it; with isolation=\"none\" it cannot "
        "be debugged here");
  }
  if (wanted->process == refused_) return;
  ++session_number_;
  session_.reset();
  process_ = wanted->process;
  state_ = State::attaching;
  stop_ = {};
  held_.reset();
  note_.clear();
  help_.clear();
  publish();
  const auto number = session_number_;
  GdbClient::Listener listener;
  listener.record = [this, number](MiRecord record) {
    // Of what the debugged program makes gdb write, the rest is not even queued.
    if (record.kind != MiRecord::Kind::exec && record.kind != MiRecord::Kind::log) return;
    post([this, number, record = std::move(record)] {
      if (number == session_number_) take(record);
    });
  };
  listener.ended = [this, number](const std::string& how) {
    post([this, number, how] {
      if (number == session_number_) debugger_ended(how);
    });
  };
  auto attached = DebugSession::attach(static_cast<int>(process_), sources_, std::move(listener));
  if (!attached) {
    refused_ = process_;
    return drop_session(attached.error().message, attached.error().hint);
  }
  session_ = std::move(*attached);
  session_->place(breakpoints_);
  note_ = stale_sources(wanted->library);
  if (!note_.empty()) help_ = "Debug builds and loads them";
  if (auto going = session_->run("continue"); !going)
    return drop_session(going.error().message, going.error().hint);
  state_ = State::running;
  publish();
}

std::string Debugger::stale_sources(const std::string& library) const {
  std::error_code error;
  const auto built = fs::last_write_time(library, error);
  if (error) return {};
  for (const SourceFolder::File& file : sources_.files()) {
    const auto written = fs::last_write_time(file.path, error);
    if (!error && written > built)
      return "'" + file.name + "' is newer than the library that runs: lines may not match";
  }
  return {};
}

// ---- what happens

/// On the run's thread: it waits until breakpoints are set, so that the first update can be debugged.
void Debugger::processes_changed(const std::vector<ControllerProcess>& now) {
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    processes_ = now;
    number = ++processes_number_;
  }
  post([this, number] {
    attempt([this] { follow_process(); });
    const std::lock_guard lock(mutex_);
    processes_done_ = number;
    news_.notify_all();
  });
  std::unique_lock lock(mutex_);
  news_.wait_for(lock, kRunWaits, [&] { return over_ || processes_done_ >= number; });
}

void Debugger::take(const MiRecord& record) {
  if (!session_) return;
  DebugSession::Event event = session_->take(record);
  switch (event.kind) {
    case DebugSession::Event::Kind::none:
      return;
    case DebugSession::Event::Kind::running:
      if (state_ == State::running) return;
      state_ = State::running;
      stop_ = {};
      held_.reset();
      return publish();
    case DebugSession::Event::Kind::stopped:
      state_ = State::stopped;
      stop_ = std::move(event.stop);
      held_ = run_.held_call(controller_);
      return publish();
    case DebugSession::Event::Kind::ended:
      refused_ = process_;
      drop_session("the controller's process " + event.ending,
                   "Restart gives it another one, which is debugged again");
      // A restart by the run itself has given it another process already.
      run_.ask_processes();
      return;
  }
}

void Debugger::debugger_ended(const std::string& how) {
  drop_session(
      "gdb has ended (" + how + ")",
      "press Debug again; if the controller then ends by SIGTRAP, a breakpoint was left in "
      "it, and Restart gives it a new process");
  controller_.clear();
  state_ = State::off;
  publish();
}

void Debugger::joined(ClientId client, Role role) {
  if (!options_.allowed) return;
  post([this, client, role] {
    if (role == Role::operator_) {
      operators_.insert(client);
      leave_at_.reset();
    }
    outbox_.send(client, topic().dump(-1, ' ', false, Json::error_handler_t::replace));
  });
}

void Debugger::left(ClientId client) {
  if (!options_.allowed) return;
  post([this, client] {
    if (operators_.erase(client) > 0 && operators_.empty() && !controller_.empty())
      leave_at_ = Clock::now() + kOperatorsAway;
  });
}

// ---- what is published

Json Debugger::topic() const {
  const char* const states[] = {"off", "waiting", "attaching", "running", "stopped"};
  Json frames = Json::array(), breakpoints = Json::array(), readings = Json::array();
  for (const DebugFrame& frame : stop_.frames) frames.push_back(to_json(frame));
  for (const DebugBreakpoint& one : breakpoints_) breakpoints.push_back(to_json(one));
  if (held_) {
    for (const HeldReading& reading : held_->readings) {
      Json values = Json::array();
      for (std::size_t i = 0; i < std::min(reading.values.size(), kMostValues); ++i) {
        const bool named = i < reading.channels.size();
        const double value = reading.values[i];
        values.push_back({{"name", named ? reading.channels[i].name : std::to_string(i)},
                          {"unit", named ? reading.channels[i].unit : ""},
                          {"value", std::isfinite(value) ? Json(value) : Json(nullptr)}});
      }
      readings.push_back({{"sensor", reading.sensor},
                          {"time", reading.time},
                          {"valid", reading.valid},
                          {"count", reading.values.size()},
                          {"values", std::move(values)}});
    }
  }
  return {{"topic", "debug"},
          {"state", states[static_cast<int>(state_)]},
          {"controller", controller_},
          {"process", process_ > 0 ? Json(process_) : Json(nullptr)},
          {"reason", stop_.reason},
          {"crashed", stop_.crashed},
          {"note", stop_.note.empty() ? note_ : stop_.note},
          {"help", stop_.note.empty() ? help_ : ""},
          {"frames", std::move(frames)},
          {"breakpoints", std::move(breakpoints)},
          {"time", held_ ? Json(held_->time) : Json(nullptr)},
          {"readings", std::move(readings)}};
}

void Debugger::publish() {
  outbox_.send_all(topic().dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace cogrsim::studio
