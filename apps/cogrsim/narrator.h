// Tells of a run while it goes on: messages as they come, and events for who asked for them.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <vector>

#include "cogrsim/simulation/simulation.h"
#include "progress.h"
#include "scene_loading.h"

namespace cogrsim::cli {

class Narrator {
 public:
  /// Events kept for JSON at most.
  static constexpr std::size_t kMostEvents = 10000;

  /// Prints to stderr the messages there are already. `events`: where every event is printed, nullptr
  /// for nowhere; only if that is asked for, or `keep`, it looks at every step. `progress` makes
  /// way for what is printed. Simulation and progress must outlive the last step.
  Narrator(Simulation& simulation, Progress& progress, std::FILE* events, bool keep);
  Narrator(const Narrator&) = delete;
  Narrator& operator=(const Narrator&) = delete;

  /// Prints the messages that have come since.
  void tell_messages();

  /// After the last step: what came too late for a frame, and how many messages were not printed.
  void finish();

  const std::vector<Event>& events() const { return events_; }
  std::uint64_t events_left_out() const { return left_out_; }

 private:
  void see(const FramePtr& frame);

  Simulation& simulation_;
  Progress& progress_;
  std::FILE* printed_events_;
  std::size_t messages_seen_ = 0;
  MessageBudget budget_;
  FramePtr last_;
  std::vector<Event> events_;
  std::uint64_t left_out_ = 0;
};

/// "1.25 s  enter  walls.T1  bot: …", a line: time, kind, source, subject, message.
std::string event_text(const Event& event);

}  // namespace cogrsim::cli
