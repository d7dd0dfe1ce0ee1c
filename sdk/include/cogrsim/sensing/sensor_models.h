// Geometry of the built-in cameras and range finders, for drawing their fields of view and for
// rendering a camera image at any time.
#pragma once

#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/rendering/renderer.h"

namespace cogrsim {

/// Pose X_WS of a sensor for a state of the world.
COGRSIM_API Pose sensor_pose(const SensorModel& sensor, const WorldState& state);

/// Unit directions of the rays of an "infrared" or "lidar" sensor in the sensor frame, in the order
/// of the rays; empty for any other type or for invalid parameters.
COGRSIM_API std::vector<Vec3> ray_directions(const SensorModel& sensor);

/// Minimum and maximum range of a range finder [m]; 0 and 0 for any other type.
struct RangeLimits {
  double least = 0.0, most = 0.0;
};
COGRSIM_API RangeLimits range_limits(const SensorModel& sensor);

/// Render request for the image of a "camera" sensor in a state of the world, without an overlay.
/// Errors: the sensor is not a camera, a parameter is invalid, or those of check_camera().
COGRSIM_API Result<RenderRequest> camera_request(const SceneModel& model, const SensorModel& sensor,
                                                 const WorldState& state);

/// A motor or sensor whose delay or latency cannot be: not from 0 to kLongestDelay, or with more
/// targets, values or pixels in flight than memory is kept for.
struct UnusableDelay {
  bool motor = false;
  int index = -1;  ///< into SceneModel::motors or SceneModel::sensors
  Error error;     ///< CG0716, without a source location
};
/// All of a scene with steps of `step` [s].
COGRSIM_API std::vector<UnusableDelay> unusable_delays(const SceneModel& model, double step);

/// A camera whose optical centre is inside a visible shape of another body at time 0. A camera may
/// be inside the body that carries it, because it does not see that body.
struct BuriedCamera {
  int sensor = -1;  ///< index into SceneModel::sensors
  Error error;      ///< CG0711, without a source location
};
/// All such cameras of a scene.
COGRSIM_API std::vector<BuriedCamera> buried_cameras(const SceneModel& model);

}  // namespace cogrsim
