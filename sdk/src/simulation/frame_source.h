// Frames of the current step boundary for the components of a run.
#pragma once

#include <memory>

#include "cogrsim/physics/frame.h"

namespace cogrsim {

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// The frame of this step boundary. One that was made earlier in the step serves again, so it may
  /// be older than the sensor readings and the outputs of controllers.
  virtual FramePtr frame_with(const FrameContents& contents) = 0;
  /// A copy with the latest readings and outputs of controllers, for a consumer whose input must
  /// not depend on what others requested in this step.
  virtual std::shared_ptr<Frame> latest(const FrameContents& contents) = 0;
};

}  // namespace cogrsim
