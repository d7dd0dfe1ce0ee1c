// The commands that wait for the next step boundary.
#pragma once

#include <algorithm>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "cogrsim/control/command.h"

namespace cogrsim {

/// Commands of all supervisors together that may wait at the same time.
inline constexpr std::size_t kMaxSentPerStep = 10000;

/// Commands in the order of their arrival. Thread-safe.
class CommandQueue {
 public:
  /// Queues a command from outside the run. It is not part of snapshots and survives a restart.
  void send(Command command) {
    std::lock_guard lock(mutex_);
    queue_.push_back({std::move(command), false});
  }
  /// Queues a command of a supervisor, which is part of the state of the run. False: it is
  /// discarded, because kMaxSentPerStep of them are waiting.
  bool send_own(Command command) {
    std::lock_guard lock(mutex_);
    if (own_ >= kMaxSentPerStep) return false;
    queue_.push_back({std::move(command), true});
    ++own_;
    return true;
  }

  std::size_t size() const {
    std::lock_guard lock(mutex_);
    return queue_.size();
  }
  /// Number of waiting commands of supervisors.
  std::size_t own_count() const {
    std::lock_guard lock(mutex_);
    return own_;
  }
  /// Removes and returns the first command; nullopt: none waits.
  std::optional<Command> take() {
    std::lock_guard lock(mutex_);
    if (queue_.empty()) return std::nullopt;
    Entry first = std::move(queue_.front());
    queue_.pop_front();
    if (first.own) --own_;
    return std::move(first.command);
  }

  /// The commands of supervisors: the part of the queue that belongs to snapshots.
  std::vector<Command> save() const {
    std::lock_guard lock(mutex_);
    std::vector<Command> sent;
    for (const Entry& entry : queue_) {
      if (entry.own) sent.push_back(entry.command);
    }
    return sent;
  }
  /// Replaces the commands of supervisors; they are the first ones to be applied.
  void restore(const std::vector<Command>& sent) {
    std::lock_guard lock(mutex_);
    queue_.erase(
        std::remove_if(queue_.begin(), queue_.end(), [](const Entry& entry) { return entry.own; }),
        queue_.end());
    for (auto it = sent.rbegin(); it != sent.rend(); ++it) queue_.push_front({*it, true});
    own_ = sent.size();
  }

 private:
  struct Entry {
    Command command;
    bool own = false;  ///< of a supervisor
  };

  mutable std::mutex mutex_;
  std::deque<Entry> queue_;
  std::size_t own_ = 0;
};

}  // namespace cogrsim
