// Frames and messages of a run on their way to a thread that writes or encodes them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include "cogrsim/simulation/simulation.h"
#include "core/rate_timer.h"

namespace cogrsim {

/// Filled by the thread of the run, which never waits; bounded in bytes. Shared with the observer, which may
/// outlive its reader.
struct RunQueue {
  struct Item {
    FramePtr frame;
    bool keep = true;
    std::uint64_t number = 0;
    bool new_model = false;
    std::vector<RunMessage> messages;
    std::size_t bytes = 0;
  };

  /// The reader is woken up at this size, because a wake-up costs a step more than the queueing.
  static constexpr std::size_t kWakeBytes = 512u << 10;

  mutable std::mutex mutex;
  std::condition_variable waiting;
  std::deque<Item> items;
  std::size_t bytes = 0;
  bool closed = false;         ///< there are no further frames
  bool failed = false;         ///< writing has failed
  std::string problem;         ///< empty: none
  std::uint64_t left_out = 0;  ///< number of dropped frames

  // Used only by the thread of the run.
  std::size_t limit = 0;
  double every = 0.0;
  RateTimer timer;
  double last_time = 0.0;
  std::uint64_t number = 0;
  SceneModelPtr model;
  std::size_t messages_seen = 0;
  std::vector<const Picture*> pictures_seen;
  /// Frames without events that are taken in a second of wall-clock time, at most.
  double frames_per_second = std::numeric_limits<double>::infinity();
  double allowance = 0.0;
  std::chrono::steady_clock::time_point counted = std::chrono::steady_clock::now();

  void observe(const Simulation& simulation, const FramePtr& frame);
  /// Takes what is there, after `look` or at kWakeBytes. Returns false if the queue is closed.
  bool take(std::deque<Item>& taken, std::chrono::milliseconds look);
  /// Memory of taken items is free again.
  void release(std::size_t freed);
  void close();

  /// Of the end, which come with no frame.
  void put_last_messages(const Simulation& simulation);

 private:
  void take_messages(const Simulation& simulation, std::vector<RunMessage>& out);
  bool in_allowance(const Frame& frame);
  std::size_t new_pictures(const Frame& frame);
};

/// The channels of all sensors of a run.
SensorChannels channels_of(const Simulation& simulation);

}  // namespace cogrsim
