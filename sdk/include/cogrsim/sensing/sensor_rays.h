// Lines of sight of the ranging sensors, to be drawn.
#pragma once

#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/physics/frame.h"

namespace cogrsim {

struct SensorRay {
  int sensor = -1;           ///< SceneModel::sensors
  Vec3 from = Vec3::Zero();  ///< world [m]
  Vec3 to = Vec3::Zero();    ///< where the reading says the ray ended, or its full range [m]
  bool hit = false;
};

/// The rays of every infrared and lidar that is on, as their latest readings in `frame` tell them
/// (noise included), drawn from where the sensors are in `frame`. Sensors without a reading yet
/// have none. Where any of them says `show`, only those that do.
COGRSIM_API std::vector<SensorRay> sensor_rays(const Frame& frame);

}  // namespace cogrsim
