// The engine: rigid bodies in free flight under gravity. It does not depend on CogRSim. To connect
// an existing engine, replace this file and flight.cpp by its library.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace flight {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

enum class Motion {
  still,    ///< never moves
  carried,  ///< moves with its prescribed velocities
  free      ///< moves under gravity
};

/// As in most engines, position and velocity are those of the centre of mass, in world axes.
struct Body {
  Motion motion = Motion::free;
  double mass = 1.0;                    ///< [kg]
  Mat3 inertia = Mat3::Identity();      ///< about the centre of mass, body axes [kg m^2]
  Vec3 position = Vec3::Zero();  ///< [m]
  Quat orientation = Quat(1, 0, 0, 0);  ///< body to world
  Vec3 velocity = Vec3::Zero();  ///< [m/s]
  Vec3 angular_velocity = Vec3::Zero();  ///< [rad/s]
  Vec3 angular_momentum = Vec3::Zero();  ///< of a free body, about its centre [kg m^2/s]
};

/// Sets the angular velocity, and for a free body also its angular momentum.
void set_spin(Body& body, const Vec3& angular_velocity);

/// Advances one body by `dt` [s] under `gravity` [m/s^2].
///
/// Position and velocity are exact: v' = v + g dt, p' = p + v dt + g dt^2 / 2. Orientation q obeys
///
///     dq/dt = (0, w) q / 2,   w = R(q) I^-1 R(q)^T L,   L constant,
///
/// integrated by the classical Runge-Kutta method of fourth order; the angular momentum L is stored
/// and does not drift.
void advance(Body& body, const Vec3& gravity, double dt);

}  // namespace flight
