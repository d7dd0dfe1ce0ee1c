// What the run publishes, kept for the threads that send it to the pages: the run itself never
// waits for them.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/simulation/simulation.h"
#include "history.h"

namespace cogrsim::studio {

/// The state of the run: the `status` message, without the fields that others fill in.
struct Situation {
  std::string state = "stopped";  ///< "stopped", "playing", "paused", "ended", "recording"
  std::string ending;             ///< how it ended, with the reason
  double time = 0.0;
  std::uint64_t step_count = 0;
  double dt = 0.0, scene_dt = 0.0;
  std::optional<double> speed = 1.0;  ///< empty: as fast as possible
  double factor = 0.0;                ///< simulated per wall second, measured
  std::string backend, engine_version;
  std::shared_ptr<const Provenance> provenance;  ///< nullptr: there is no run, or it is not known
  std::optional<std::string> recording;          ///< file
  std::uint32_t scene = 0;
  std::size_t inputs = 0;  ///< of a person, so far
  std::vector<ControllerInputs> controllers;
  std::string state_hash;  ///< of the newest state, as the command line has it; empty while playing
  struct Comparison {
    std::array<std::string, 2> labels;
    std::optional<double> first_over;  ///< [s]
    std::vector<LeftOut> left_out;     ///< of the second run
  };
  std::optional<Comparison> compare;
  std::optional<PluginWatch::Call> waiting;  ///< for a plugin call that has not returned for long
};

struct IndexedEvent {
  std::size_t index = 0;  ///< never used twice
  Event event;
};

class StatusPublisher {
 public:
  // The run's side. None of these waits for longer than it takes to copy a few bytes.
  void set_situation(Situation situation, bool urgent);
  /// While a call lasts, until the next set_situation().
  void set_waiting(std::optional<PluginWatch::Call> call);
  /// While a call is waited for: reports the run as paused. False: there is no such call, or the
  /// run does not play.
  bool pause_meanwhile();
  void set_newest(Instant instant);
  void add_event(Event event);
  void clear_events();
  void add_messages(std::vector<RunMessage> messages);
  /// To be destroyed in another thread.
  void discard(std::vector<Instant> instants);

  // The other side.
  Situation situation() const;
  Instant newest() const;
  /// Events of the present run from that index on.
  std::vector<IndexedEvent> events_from(std::size_t index) const;
  /// The latest ones of the present run, for pages that join later.
  std::vector<RunMessage> messages() const;

  struct News {
    bool status = false, urgent = false, frame = false, viewers = false, over = false;
    std::vector<IndexedEvent> events;
    std::vector<RunMessage> messages;
  };
  /// Waits until there is news, or until `until`. What was discarded is destroyed here.
  News wait(std::chrono::steady_clock::time_point until);
  /// A client joined, left, or views another instant.
  void poke();
  void close();

 private:
  mutable std::mutex mutex_;
  std::condition_variable waiting_;
  Situation situation_;
  Instant newest_;
  std::vector<IndexedEvent> events_;
  std::size_t next_event_ = 0, published_event_ = 0;
  std::vector<RunMessage> messages_;
  News news_;
  std::vector<Instant> trash_;
};

}  // namespace cogrsim::studio
