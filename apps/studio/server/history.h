// All that can be viewed: the frames of a run so far, or of a recording.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "paths.h"

namespace cogrsim::studio {

/// What can be seen at one time.
struct Instant {
  FramePtr frame;           ///< without pictures
  FramePtr ghost;           ///< of the second run, at the same time; nullptr: there is none
  std::uint32_t scene = 0;  ///< number of the scene it belongs to

  explicit operator bool() const { return frame != nullptr; }
  double time() const { return frame->time; }
};

/// Instants in the order of time. From any thread.
class Frames {
 public:
  virtual ~Frames() = default;

  struct Extent {
    double first = 0.0, last = 0.0;  ///< [s]
    std::size_t count = 0;
  };
  virtual Extent extent() const = 0;
  /// The last one at or before `time` [s], the first one if all are later; empty: there are none.
  virtual Instant at(double time) = 0;
  /// The last one before `time`; empty: there is none.
  virtual Instant before(double time) = 0;
  /// Those later than `time`, at most so many, in order.
  virtual std::vector<Instant> after(double time, std::size_t most) = 0;
  /// Another number after all frames were dropped: results computed from earlier frames are void.
  virtual std::uint64_t epoch() const = 0;

  /// Of all steps there were, also of those whose frames are not kept.
  Paths& paths() { return paths_; }

 private:
  Paths paths_;
};

/// The frames of a run, within bounds: where they would take more memory than allowed, every second
/// one of the older half is dropped. The first and the last always stay.
class History final : public Frames {
 public:
  explicit History(std::size_t limit) : limit_(limit) {}

  /// Replaces an instant of the same time. Returns what was removed: to be destroyed where
  /// it does not matter how long that takes.
  std::vector<Instant> add(Instant instant);
  std::vector<Instant> clear();

  Extent extent() const override;
  Instant at(double time) override;
  Instant before(double time) override;
  std::vector<Instant> after(double time, std::size_t most) override;
  std::uint64_t epoch() const override;

 private:
  std::vector<Instant> thin();

  const std::size_t limit_;
  mutable std::mutex mutex_;
  std::vector<Instant> instants_;
  std::size_t bytes_ = 0;
  std::uint64_t epoch_ = 1;
};

}  // namespace cogrsim::studio
