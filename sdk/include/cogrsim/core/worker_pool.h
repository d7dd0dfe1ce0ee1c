// A pool of threads that wait for work between calls.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "cogrsim/core/export.h"

namespace cogrsim {

/// Threads that share the calls of a loop. One thread at a time may use a pool.
class COGRSIM_API WorkerPool {
 public:
  /// Creates a pool of `threads` >= 1 threads, including the caller of run(). Throws
  /// std::system_error if the system provides no more threads.
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls `work(i)` once for every i in [0, count) and returns when all calls have ended. Each
  /// thread has its own range of indices, the same in every call with the same count, so that the
  /// data of an index tend to stay in the cache of one core. A thread that has finished its range
  /// helps the others. When calls throw, run() throws what one of them threw, after all have ended.
  /// Allocates no memory.
  void run(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  /// The range of a thread, on a cache line of its own because other threads rarely access it.
  struct alignas(64) Stretch {
    std::atomic<std::size_t> next{0};
    std::size_t end = 0;
  };

  void wait_for_work(std::size_t number);
  void work_through(std::size_t number);
  void call(std::size_t index);
  void end_workers();

  std::unique_ptr<Stretch[]> stretches_;
  const std::function<void(std::size_t)>* work_ = nullptr;
  std::mutex mutex_;
  std::condition_variable begin_, done_;
  std::uint64_t calls_ = 0;  ///< number of calls of run(); a worker that has seen fewer has work
  std::size_t busy_ = 0;     ///< number of workers that have not finished the current call
  bool ending_ = false;
  std::exception_ptr thrown_;
  std::vector<std::thread> workers_;
};

}  // namespace cogrsim
