// Threads that wait for work between calls.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace cogrsim {

class WorkerPool {
 public:
  /// `threads` >= 1 work, the caller of run() among them. Throws std::system_error when the system
  /// gives no more threads.
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls `work(i)` once for every i in [0, count) and returns when all are done. Each thread has
  /// its own stretch of them, the same in every call with the same count, so that what i touches
  /// tends to stay in one core's cache; who is done helps the others. `work` must not throw.
  /// Allocates nothing.
  void run(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  /// A thread's own stretch; alone on its cache line, as others look at it seldom.
  struct alignas(64) Stretch {
    std::atomic<std::size_t> next{0};
    std::size_t end = 0;
  };

  void wait_for_work(std::size_t number);
  void work_through(std::size_t number);
  void end_workers();

  std::unique_ptr<Stretch[]> stretches_;
  const std::function<void(std::size_t)>* work_ = nullptr;
  std::mutex mutex_;
  std::condition_variable begin_, done_;
  std::uint64_t calls_ = 0;  ///< of run(): a worker that has seen fewer has something to do
  std::size_t busy_ = 0;     ///< workers that are not through with the present call
  bool ending_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace cogrsim
