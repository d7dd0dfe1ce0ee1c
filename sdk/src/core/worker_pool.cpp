#include "cogrsim/core/worker_pool.h"

#include <utility>

namespace cogrsim {

WorkerPool::WorkerPool(int threads)
    : stretches_(std::make_unique<Stretch[]>(static_cast<std::size_t>(threads))) {
  try {
    for (int i = 1; i < threads; ++i) {
      workers_.emplace_back([this, i] { wait_for_work(static_cast<std::size_t>(i)); });
    }
  } catch (...) {
    end_workers();  // the workers that were started
    throw;
  }
}

WorkerPool::~WorkerPool() { end_workers(); }

void WorkerPool::end_workers() {
  {
    std::lock_guard lock(mutex_);
    ending_ = true;
  }
  begin_.notify_all();
  for (std::thread& worker : workers_) worker.join();
  workers_.clear();
}

void WorkerPool::wait_for_work(std::size_t number) {
  std::uint64_t seen = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      begin_.wait(lock, [&] { return ending_ || calls_ != seen; });
      if (ending_) return;
      seen = calls_;
    }
    work_through(number);
    std::lock_guard lock(mutex_);
    if (--busy_ == 0) done_.notify_one();
  }
}

void WorkerPool::work_through(std::size_t number) {
  const std::size_t all = workers_.size() + 1;
  for (std::size_t k = 0; k < all; ++k) {
    Stretch& stretch = stretches_[(number + k) % all];
    for (;;) {
      const std::size_t i = stretch.next.fetch_add(1, std::memory_order_relaxed);
      if (i >= stretch.end) break;
      call(i);
    }
  }
}

void WorkerPool::call(std::size_t index) {
  try {
    (*work_)(index);
  } catch (...) {
    std::lock_guard lock(mutex_);
    if (!thrown_) thrown_ = std::current_exception();
  }
}

void WorkerPool::run(std::size_t count, const std::function<void(std::size_t)>& work) {
  if (workers_.empty() || count <= 1) {
    for (std::size_t i = 0; i < count; ++i) work(i);
    return;
  }
  {
    std::lock_guard lock(mutex_);
    const std::size_t all = workers_.size() + 1;
    for (std::size_t k = 0; k < all; ++k) {
      stretches_[k].next.store(count * k / all, std::memory_order_relaxed);
      stretches_[k].end = count * (k + 1) / all;
    }
    work_ = &work;
    busy_ = workers_.size();
    ++calls_;
  }
  begin_.notify_all();
  work_through(0);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [&] { return busy_ == 0; });
  if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
}

}  // namespace cogrsim
