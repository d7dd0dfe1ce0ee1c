// The interface of steering methods for vehicles in the plane, such as "pure_pursuit",
// "potential_field" and "dynamic_window".
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/core/result.h"
#include "cogrsim/core/types.h"

namespace cogrsim {

/// A point in the plane.
struct PlanarPoint {
  double x = 0.0, y = 0.0;  ///< [m]
};

/// Position and heading in the plane; the heading is measured from +x towards +y.
struct PlanarPose {
  double x = 0.0, y = 0.0;  ///< [m]
  double heading = 0.0;     ///< [rad]
};

/// Velocity of a vehicle in the plane.
struct PlanarVelocity {
  double forward = 0.0;  ///< along the heading [m/s]
  double turn = 0.0;     ///< turn rate, positive to the left [rad/s]
};

/// Limits of a vehicle. An infinite acceleration means no limit.
struct SteeringLimits {
  double max_speed = 0.3;         ///< forward [m/s], > 0
  double max_reverse = 0.0;       ///< backward [m/s], >= 0; 0: never backward
  double max_turn = 2.0;          ///< [rad/s], > 0
  double acceleration = 1.0;      ///< also braking [m/s^2], > 0
  double turn_acceleration = 10;  ///< [rad/s^2], > 0
};

/// Input of a steering method at each update. Pose, path and obstacles are in the same frame, which
/// may be that of the world or any other.
struct SteeringTask {
  PlanarPose pose;
  PlanarVelocity velocity;             ///< current velocity
  std::vector<PlanarPoint> path;       ///< at least one point; the last one is the goal
  std::vector<PlanarPoint> obstacles;  ///< points on obstacles
  double radius = 0.1;   ///< of a disc about the pose that contains the vehicle [m], >= 0
  double period = 0.05;  ///< time until the next update [s], > 0
  SteeringLimits limits;
};

/// Output of a steering method.
struct SteeringCommand {
  PlanarVelocity velocity;  ///< commanded velocity, within the limits
  PlanarPoint target;       ///< target point on the path
  bool arrived = false;     ///< the vehicle is at the goal; the velocity brings it to a stop
  /// The vehicle has not arrived but makes no progress, for example in a local minimum of a
  /// potential field or without an admissible velocity. `why` has the reason.
  bool stuck = false;
  std::string why;
};

/// Computes velocities that follow a path. One object steers one vehicle, because it may store the
/// progress along the path.
class Steering {
 public:
  static constexpr const char* kFamily = "steering";
  virtual ~Steering() = default;

  /// Computes the next velocity. Errors: the path is empty, or a pose, velocity, point or limit is
  /// not finite or out of range. The caller should then stop the vehicle.
  virtual Result<SteeringCommand> steer(const SteeringTask& task) = 0;

  /// Discards the progress along the path. Not necessary for a new path.
  virtual void reset() {}
};

/// Checks a task for the errors that all steering methods report in the same way.
COGRSIM_API Result<> check_task(const SteeringTask& task);

/// The end points of the rays of a range finder, as obstacles. `bearings` [rad] are measured from
/// the x axis of the sensor towards its y axis. `ranges` [m] that are negative or not finite are
/// omitted. `sensor` is the pose of the sensor in the desired frame. Precondition: both lists have
/// the same length.
COGRSIM_API std::vector<PlanarPoint> ray_ends(const PlanarPose& sensor,
                                              const std::vector<double>& bearings,
                                              const std::vector<double>& ranges);

/// Projection of a pose onto the plane; the heading is that of its x axis.
COGRSIM_API PlanarPose planar(const Pose& X_WB);

/// The angle [rad] plus full turns so that it is in (-pi, pi].
COGRSIM_API double wrapped_angle(double angle);

}  // namespace cogrsim
