// Steering of a vehicle in the plane: "pure_pursuit", "potential_field", "dynamic_window", and
// yours.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/core/result.h"
#include "cogrsim/core/types.h"

namespace cogrsim {

struct PlanarPoint {
  double x = 0.0, y = 0.0;  ///< [m]
};

/// Place and heading in the plane; the heading counts from +x towards +y.
struct PlanarPose {
  double x = 0.0, y = 0.0;  ///< [m]
  double heading = 0.0;     ///< [rad]
};

/// Speed along the heading [m/s] and turn rate, left positive [rad/s].
struct PlanarVelocity {
  double forward = 0.0;
  double turn = 0.0;
};

/// What the vehicle can do. Accelerations may be infinite: no bound.
struct SteeringLimits {
  double max_speed = 0.3;         ///< forward [m/s], > 0
  double max_reverse = 0.0;       ///< backward [m/s], >= 0; 0: never backward
  double max_turn = 2.0;          ///< [rad/s], > 0
  double acceleration = 1.0;      ///< also braking [m/s^2], > 0
  double turn_acceleration = 10;  ///< [rad/s^2], > 0
};

/// What a steering algorithm is told at each update. Pose, path and obstacles share one frame, that
/// of the world or any other.
struct SteeringTask {
  PlanarPose pose;
  PlanarVelocity velocity;             ///< present
  std::vector<PlanarPoint> path;       ///< through these to the last, the goal; at least one point
  std::vector<PlanarPoint> obstacles;  ///< points that belong to something solid
  double radius = 0.1;   ///< of a disc about the pose that holds the vehicle [m], >= 0
  double period = 0.05;  ///< until the next update [s], > 0
  SteeringLimits limits;
};

struct SteeringCommand {
  PlanarVelocity velocity;  ///< desired from now on; within the limits
  PlanarPoint target;       ///< what it aims at: a place on the path
  bool arrived = false;     ///< at the goal: velocity brings it to a stop
  /// It gets no further although it has not arrived: a local minimum of a field, no admissible
  /// velocity. `why` tells.
  bool stuck = false;
  std::string why;
};

/// Turns a path into velocities. One object steers one vehicle: it may remember how far along the
/// path it is.
class Steering {
 public:
  static constexpr const char* kFamily = "steering";
  virtual ~Steering() = default;

  /// Errors: an empty path; a pose, velocity, point or limit that is not a number or out of its
  /// range. The vehicle should then be stopped.
  virtual Result<SteeringCommand> steer(const SteeringTask& task) = 0;

  /// Forgets its progress. Not needed when a task brings another path.
  virtual void reset() {}
};

/// The errors in a task that every steering algorithm reports alike; empty: none.
COGRSIM_API Result<> check_task(const SteeringTask& task);

/// Ends of the rays of a range finder, as obstacles. `bearings` [rad] count from the sensor's x axis
/// towards its y axis; a range that is not finite or negative saw nothing and is left out. `sensor`
/// is the sensor's pose in the frame wanted. Precondition: both lists have the same length.
COGRSIM_API std::vector<PlanarPoint> ray_ends(const PlanarPose& sensor,
                                              const std::vector<double>& bearings,
                                              const std::vector<double>& ranges);

/// Projection of a pose onto the plane; the heading is that of its x axis.
COGRSIM_API PlanarPose planar(const Pose& X_WB);

/// The same angle within (-pi, pi].
COGRSIM_API double wrapped_angle(double angle);

}  // namespace cogrsim
