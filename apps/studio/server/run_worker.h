// A thread for long jobs, one after the other; the clients take turns.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

#include "turns.h"

namespace cogrsim::studio {

class Worker {
 public:
  Worker() : thread_([this] { run(); }) {}
  ~Worker() { stop(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// `client` 0: no client asked.
  void post(ClientId client, Role role, std::function<void()> job) {
    std::lock_guard lock(mutex_);
    jobs_.put(client, role, std::move(job));
    waiting_.notify_one();
  }
  /// Jobs of this viewer that have not begun are dropped.
  void forget_viewer(ClientId client) {
    std::deque<std::function<void()>> forgotten;  // destroyed without the lock
    const std::lock_guard lock(mutex_);
    forgotten = jobs_.forget_viewer(client);
  }
  /// Jobs that have not begun are dropped.
  void stop() {
    {
      std::lock_guard lock(mutex_);
      over_ = true;
      waiting_.notify_one();
    }
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run() {
    for (;;) {
      std::function<void()> job;
      {
        std::unique_lock lock(mutex_);
        waiting_.wait(lock, [this] { return over_ || !jobs_.empty(); });
        if (over_) return;
        job = jobs_.take();
      }
      job();
    }
  }

  std::mutex mutex_;
  std::condition_variable waiting_;
  Turns<std::function<void()>> jobs_;
  bool over_ = false;
  std::thread thread_;
};

}  // namespace cogrsim::studio
