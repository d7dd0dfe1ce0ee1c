// Prints the messages of a run while it runs, and its events if they are asked for.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <vector>

#include "cogrsim/simulation/simulation.h"
#include "common/progress.h"
#include "common/scene_loading.h"

namespace cogrsim::cli {

class Live;

/// Whether a run of this status can be stepped.
inline bool can_step(RunStatus status) {
  return status == RunStatus::running || status == RunStatus::completed;
}

class RunLog {
 public:
  /// Events kept for JSON at most.
  static constexpr std::size_t kMostEvents = 10000;

  /// Prints the messages so far to stderr. `events`: where every event is printed, nullptr for
  /// nowhere; it observes every step only with `events` or `keep`. The progress line is removed
  /// before anything is printed. Simulation and progress must outlive the last step.
  /// `live`: serves clients between the pieces of run(); nullptr: none.
  RunLog(Simulation& simulation, Progress& progress, std::FILE* events, bool keep,
         Live* live = nullptr);
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  /// Runs to `duration` [s] in pieces short enough to redraw the progress line and to print new
  /// messages; the result does not depend on the pieces. Ends early if the run is over or paused.
  RunStatus run(double duration);
  /// Wall-clock time that run() spent in the simulation [s].
  double wall_time() const { return wall_time_; }

  /// Prints the new messages.
  void print_messages();

  /// After the last step: what came too late for a frame, and how many messages were not printed.
  void finish();

  const std::vector<Event>& events() const { return events_; }
  std::uint64_t events_left_out() const { return left_out_; }

 private:
  void see(const FramePtr& frame);

  Simulation& simulation_;
  Progress& progress_;
  std::FILE* printed_events_;
  Live* live_;
  double wall_time_ = 0.0;
  std::size_t messages_seen_ = 0;
  MessageBudget budget_;
  FramePtr last_;
  std::vector<Event> events_;
  std::uint64_t left_out_ = 0;
};

/// "1.25 s  enter  walls.T1  bot: …", a line: time, kind, source, subject, message.
std::string event_text(const Event& event);

}  // namespace cogrsim::cli
