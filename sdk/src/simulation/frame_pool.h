// A pool of frames, whose vectors retain their memory when the frames are reused.
#pragma once

#include <algorithm>
#include <cassert>
#include <memory>
#include <mutex>
#include <new>
#include <vector>

#include "cogrsim/physics/frame_memory.h"

namespace cogrsim {

/// Consumers may hold frames in other threads and after the simulation has been destroyed.
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
    const std::shared_ptr<FramePool> self = shared_from_this();
    return {frame.release(), [self](Frame* f) { self->give_back(f); }, BlockAllocator<Frame>(self)};
  }

  ~FramePool() {
    for (void* block : blocks_) ::operator delete(block);
  }

 private:
  /// Allocator of the control blocks of the shared pointers, which are reused, too.
  template <class T>
  struct BlockAllocator {
    using value_type = T;
    explicit BlockAllocator(std::shared_ptr<FramePool> owner) : pool(std::move(owner)) {}
    template <class Other>
    BlockAllocator(const BlockAllocator<Other>& other) : pool(other.pool) {}
    T* allocate(std::size_t count) {
      assert(count == 1);
      return static_cast<T*>(pool->take_block(count * sizeof(T)));
    }
    void deallocate(T* block, std::size_t) { pool->give_back_block(block); }
    template <class Other>
    bool operator==(const BlockAllocator<Other>& other) const {
      return pool == other.pool;
    }
    template <class Other>
    bool operator!=(const BlockAllocator<Other>& other) const {
      return pool != other.pool;
    }

    std::shared_ptr<FramePool> pool;
  };

  void* take_block(std::size_t size) {
    {
      std::lock_guard lock(mutex_);
      if (!blocks_.empty()) {
        void* const block = blocks_.back();
        blocks_.pop_back();
        return block;
      }
    }
    return ::operator new(size);
  }
  void give_back_block(void* block) {
    {
      std::lock_guard lock(mutex_);
      if (blocks_.size() < kKeptFrames) {
        blocks_.push_back(block);
        return;
      }
    }
    ::operator delete(block);
  }

  // Frames that were written to disk come back in batches. Enough are retained for the next batch
  // to need no new memory, up to this limit.
  static constexpr std::size_t kKeptFrames = 4096;
  static constexpr std::size_t kKeptBytes = 64u << 20;

  void give_back(Frame* frame) {
    std::unique_ptr<Frame> owned(frame);
    owned->model.reset();
    owned->channels.reset();
    // An idle frame must not retain an image.
    for (Reading& reading : owned->readings) reading.picture.reset();
    const std::size_t most = std::max<std::size_t>(16, kKeptBytes / bytes_of(*owned));
    std::lock_guard lock(mutex_);
    if (free_.size() < std::min(most, kKeptFrames)) free_.push_back(std::move(owned));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Frame>> free_;
  std::vector<void*> blocks_;  ///< idle blocks, see BlockAllocator
};

}  // namespace cogrsim
