// All that can be looked at: the frames of a run so far, or of a recording.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "paths.h"

namespace cogrsim::studio {

/// What there is to see at one time.
struct Moment {
  FramePtr frame;           ///< without pictures
  FramePtr ghost;           ///< of the second run, at the same time; nullptr: there is none
  std::uint32_t scene = 0;  ///< number of the scene it belongs to

  explicit operator bool() const { return frame != nullptr; }
  double time() const { return frame->time; }
};

/// Moments by time, which goes up. From any thread.
class Frames {
 public:
  virtual ~Frames() = default;

  struct Extent {
    double first = 0.0, last = 0.0;  ///< [s]
    std::size_t count = 0;
  };
  virtual Extent extent() const = 0;
  /// The last one at or before `time` [s], the first one if all are later; empty: there are none.
  virtual Moment at(double time) = 0;
  /// The last one before `time`; empty: there is none.
  virtual Moment before(double time) = 0;
  /// Those later than `time`, at most so many, in order.
  virtual std::vector<Moment> after(double time, std::size_t most) = 0;
  /// Another number after everything was let go: what was computed of the frames before is void.
  virtual std::uint64_t epoch() const = 0;

  /// Of all steps there were, also of those whose frames are not kept.
  Paths& paths() { return paths_; }

 private:
  Paths paths_;
};

/// Memory a frame takes, about [byte].
std::size_t bytes_of(const Frame& frame);

/// The frames of a run, within bounds: where they would take more memory than allowed, every second
/// one of the older half is let go. The first and the last always stay.
class History final : public Frames {
 public:
  explicit History(std::size_t limit) : limit_(limit) {}

  /// Takes the place of a moment of the same time. Returns what was let go: to be destroyed where
  /// it does not matter how long that takes.
  std::vector<Moment> add(Moment moment);
  std::vector<Moment> clear();

  Extent extent() const override;
  Moment at(double time) override;
  Moment before(double time) override;
  std::vector<Moment> after(double time, std::size_t most) override;
  std::uint64_t epoch() const override;

 private:
  std::vector<Moment> thin();

  const std::size_t limit_;
  mutable std::mutex mutex_;
  std::vector<Moment> moments_;
  std::size_t bytes_ = 0;
  std::uint64_t epoch_ = 1;
};

}  // namespace cogrsim::studio
