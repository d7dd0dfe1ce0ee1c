// Frames are reused: their vectors keep their memory from one to the next.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "cogrsim/physics/frame.h"

namespace cogrsim {

/// Consumers may hold frames in other threads and longer than the simulation lives.
class FramePool : public std::enable_shared_from_this<FramePool> {
 public:
  std::shared_ptr<Frame> take() {
    std::unique_ptr<Frame> frame;
    {
      std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        frame = std::move(free_.back());
        free_.pop_back();
      }
    }
    if (!frame) frame = std::make_unique<Frame>();
    return {frame.release(), [pool = shared_from_this()](Frame* f) { pool->give_back(f); }};
  }

 private:
  static constexpr std::size_t kKept = 16;

  void give_back(Frame* frame) {
    std::unique_ptr<Frame> owned(frame);
    owned->model.reset();
    std::lock_guard lock(mutex_);
    if (free_.size() < kKept) free_.push_back(std::move(owned));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Frame>> free_;
};

}  // namespace cogrsim
