// The part that answers everything in PROTOCOL.md under "Debugging": one controller of the run, in
// gdb.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "debug_session.h"
#include "run.h"
#include "sources.h"
#include "talk.h"

namespace cogrsim::studio {

struct DebuggerOptions {
  std::string folder;    ///< the scene's, with the controllers' sources
  bool allowed = false;  ///< the user lets pages build and debug
};

/// gdb is started when a controller is debugged, and ends with that. All on a thread of its own.
class Debugger final : public Part {
 public:
  /// `run` and `outbox` outlive it.
  Debugger(DebuggerOptions options, Run& run, Outbox& outbox);
  ~Debugger() override;

  bool answers(Section section) const override { return section == Section::debug; }
  void handle(Request request, Reply reply) override;
  void joined(ClientId client, Role role) override;
  /// When the last operator has left for a while (pages are loaded again), gdb detaches.
  void left(ClientId client) override;
  /// Detaches; nothing is answered any more. From any thread.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  enum class State { off, waiting, attaching, running, stopped };

  void post(std::function<void()> job);
  void work();
  void attempt(const std::function<void()>& job);
  Answer answer(const Request& request);
  void attach(const std::string& controller);
  void detach(const std::string& note = {});
  /// Attaches to the process that the wanted controller has now.
  void follow_process();
  void processes_changed(const std::vector<ControllerProcess>& now);
  void take(const MiRecord& record);
  void debugger_ended(const std::string& how);
  void drop_session(const std::string& note, const std::string& help);
  std::optional<ControllerProcess> wanted_process();
  std::string stale_sources(const std::string& library) const;
  Json topic() const;
  void publish();

  DebuggerOptions options_;
  Run& run_;
  Outbox& outbox_;
  SourceFolder sources_;

  // On the debugger's thread alone.
  State state_ = State::off;
  std::string controller_;  ///< that is debugged; "": none
  std::int64_t process_ = 0;
  std::int64_t refused_ = 0;  ///< process that has ended, or that gdb cannot attach to
  std::unique_ptr<DebugSession> session_;
  std::uint64_t session_number_ = 0;  ///< what comes late from a gdb before is dropped
  std::vector<DebugBreakpoint> breakpoints_;
  DebugStop stop_;
  std::optional<HeldCall> held_;
  std::string note_, help_;
  std::set<ClientId> operators_;
  std::optional<Clock::time_point> leave_at_;

  std::mutex mutex_;
  std::condition_variable news_;
  std::deque<std::function<void()>> jobs_;
  std::vector<ControllerProcess> processes_;
  std::uint64_t processes_number_ = 0, processes_done_ = 0;
  bool over_ = false;
  std::thread thread_;
};

}  // namespace cogrsim::studio
