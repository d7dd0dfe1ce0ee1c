// The geometry of the SDK's own cameras and range finders, for those who draw what they look at, or
// look through a camera at another time than its own.
#pragma once

#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/rendering/renderer.h"

namespace cogrsim {

/// X_WS of a sensor in a state of the world.
COGRSIM_API Pose sensor_pose(const SensorModel& sensor, const WorldState& state);

/// Unit directions, in the sensor's own frame, along which an "infrared" or "lidar" looks, in the
/// order of its rays; empty for any other type, or when its parameters are wrong.
COGRSIM_API std::vector<Vec3> ray_directions(const SensorModel& sensor);

/// Least and largest distance a range finder reads [m]; 0 and 0 for any other type.
struct RangeLimits {
  double least = 0.0, most = 0.0;
};
COGRSIM_API RangeLimits range_limits(const SensorModel& sensor);

/// The picture a "camera" would take in a state of the world, overlay empty. Errors: it is no
/// camera, a parameter is wrong, or check_camera's.
COGRSIM_API Result<RenderRequest> camera_request(const SceneModel& model, const SensorModel& sensor,
                                                 const WorldState& state);

/// Cameras whose eye lies inside a visible shape of a body that does not carry them, at the poses
/// of time 0. A camera in its own body is in order, it does not see that body.
struct BuriedCamera {
  int sensor = -1;  ///< SceneModel::sensors
  Error error;      ///< CG0711, without a place
};
COGRSIM_API std::vector<BuriedCamera> buried_cameras(const SceneModel& model);

}  // namespace cogrsim
