// The rays of the range finders, for drawing.
#pragma once

#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/physics/frame.h"

namespace cogrsim {

/// One ray of a range finder, in the world frame.
struct SensorRay {
  int sensor = -1;           ///< index into SceneModel::sensors
  Vec3 from = Vec3::Zero();  ///< origin of the ray [m]
  Vec3 to = Vec3::Zero();    ///< end at the measured distance, or at the maximum range [m]
  bool hit = false;
};

/// The rays of all enabled infrared and lidar sensors, with the distances of their latest readings
/// in `frame` (including noise), from where the sensors were when they measured. A sensor without a
/// reading has no rays. If any sensor has SensorModel::show set, only the rays of such sensors are
/// returned.
COGRSIM_API std::vector<SensorRay> sensor_rays(const Frame& frame);

}  // namespace cogrsim
