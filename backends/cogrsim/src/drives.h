// What acts along joint axes without being a constraint: springs, dampers, motors.
#pragma once

#include <vector>

#include "cogrsim/physics/drive.h"
#include "mechanism/mechanism.h"

namespace cogrsim::dynamics {

/// One law along one generalized speed: effort = clamp(bias + kp (position - q) + kd (velocity -
/// u)).
struct AxisLaw {
  Drive law;
  int joint = -1;
  int motor = -1;      ///< SceneModel::motors; -1: the joint's own spring and damper
  int effort = -1;     ///< entry in the flat array of speeds: where the effort is reported
  int speed = -1;      ///< global u index
  int position = -1;   ///< global q index; of a ball: its quaternion
  int ball_axis = -1;  ///< of a ball: component of the rotation vector that serves as coordinate
  int component = -1;
  int local = -1;  ///< degree of freedom within the component
  /// Solved together with the contacts, at a time theta of the step: because it is an ideal speed
  /// source, or too stiff for an explicit scheme.
  bool implicit = false;
  double theta = 0.5;

  double coordinate(const Values& q) const;
  /// The law's effort at q, u.
  double effort_at(const Values& q, const Values& u) const;
};

/// The coordinate of a ball joint as rotation vector (axis times angle, angle 0 to pi), F's axes.
Vec3 rotation_vector(const Values& q, int first);

/// All laws of a mechanism: joints' springs and dampers first, motors after, in model order.
std::vector<AxisLaw> make_laws(const Mechanism& mechanism);

/// Takes over this step's drives and decides which laws are implicit. The measure of stiffness is
/// x = (kd h + kp h^2) / m with m the effective inertia of the axis (inverse of the diagonal of
/// M^-1); up to 0.5 the explicit schemes are accurate. The offset beyond that, theta = 1/(1 -
/// exp(-x)) - 1/x, makes a single damped axis decay exactly (exponential fitting: Liniger and
/// Willoughby, SIAM J. Numer. Anal. 7, 1970) and tends to implicit Euler when stiff.
void classify_laws(Mechanism& mechanism, const std::vector<Drive>& drives, double h,
                   std::vector<AxisLaw>& laws);

/// theta of the stiffness x, see classify_laws.
double fitted_theta(double x);

}  // namespace cogrsim::dynamics
