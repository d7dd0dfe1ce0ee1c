// Frames are reused: their vectors keep their memory from one to the next.
#pragma once

#include <algorithm>
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
  // Frames that wait for the disk come back in batches; so many are kept that the next batch needs
  // no new memory, but never more than this much of it.
  static constexpr std::size_t kKeptFrames = 4096;
  static constexpr std::size_t kKeptBytes = 64u << 20;

  static std::size_t bytes_of(const Frame& frame) {
    return sizeof(Frame) + frame.state.poses.capacity() * sizeof(Pose) +
           frame.state.twists.capacity() * sizeof(Twist) +
           frame.accelerations.capacity() * sizeof(Twist) +
           frame.contacts.capacity() * sizeof(Contact) +
           frame.joint_reactions.capacity() * sizeof(Wrench) +
           frame.readings.capacity() * sizeof(Reading) +
           4 * frame.state.joint_positions.capacity() * sizeof(double);
  }

  void give_back(Frame* frame) {
    std::unique_ptr<Frame> owned(frame);
    owned->model.reset();
    // A frame that lies idle holds on to no picture.
    for (Reading& reading : owned->readings) reading.picture.reset();
    const std::size_t most = std::max<std::size_t>(16, kKeptBytes / bytes_of(*owned));
    std::lock_guard lock(mutex_);
    if (free_.size() < std::min(most, kKeptFrames)) free_.push_back(std::move(owned));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Frame>> free_;
};

}  // namespace cogrsim
