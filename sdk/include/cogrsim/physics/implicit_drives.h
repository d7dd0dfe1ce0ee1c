// Drives on engines that take actuators explicitly and the damping of joints implicitly. For
// backends; header only.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"

namespace cogrsim {

/// What an engine's step takes implicitly.
enum class ImplicitPart { none, joint_damping, all_damping };

/// Which gains an axis can have in steps of `dt` [s]. `response` is its inverse inertia. `crowd` >=
/// 1 says how much the driven axes of its tree move each other: the sum over them of the magnitudes
/// of their correlations with this one in the inverse mass matrix. Explicit gains g on the speed
/// are stable together where crowd response dt g < 2 on each axis, by Gershgorin's circles.
class GainLimits {
 public:
  GainLimits(ImplicitPart implicit, double dt, double response, double crowd)
      : implicit_(implicit), dt_(dt), stop_(1.0 / (dt * response)), crowd_(crowd) {}

  /// Whether an explicit actuator could sway, from half of what is stable; where the engine has its
  /// damping implicit, whether it has any, as it would go on beyond the actuator's bound.
  bool is_stiff(double kp, double kd) const {
    if (implicit_ == ImplicitPart::all_damping && kd > 0.0) return true;
    return implicit_ != ImplicitPart::none && crowd_ * (kd + 0.5 * dt_ * kp) > stop_;
  }
  /// Damping that takes the law of a stiff drive at the end of the step. Where the engine takes
  /// damping of actuators implicitly, too, their stiffness stays explicit as there, unless it could
  /// sway.
  double damping(double kp, double kd) const {
    const bool as_there =
        implicit_ == ImplicitPart::all_damping && 0.5 * crowd_ * dt_ * kp <= stop_ + kd;
    return as_there ? kd : kd + dt_ * kp;
  }
  /// The share of the gains that can be held: all but what would stop the axis in less than a
  /// microsecond, and what is stiff where nothing is implicit.
  double share(double kp, double kd) const {
    if (implicit_ == ImplicitPart::none)
      return std::min(1.0, stop_ / (crowd_ * (kd + 0.5 * dt_ * kp)));
    return std::min(1.0, 1e6 * dt_ * stop_ / (kd + dt_ * kp));
  }
  /// How many times a spring is too stiff for an explicit step: stable below four times the inertia
  /// over the step squared.
  double explicit_stiffness(double stiffness) const { return 0.25 * stiffness * dt_ / stop_; }
  /// Effort of a stiff drive before damping is taken off, at most: engines refuse accelerations of
  /// 1e10. It leaves the axis speeds of a thousand a second.
  double most_effort() const { return 1e9 * dt_ * stop_; }
  bool has_implicit_sources() const { return implicit_ == ImplicitPart::all_damping; }
  /// Gain of a speed source: what stops the axis in a step, or among others three quarters of what
  /// is stable; a thousand times as much where it is implicit.
  double speed_source() const {
    if (has_implicit_sources()) return 1e3 * stop_;
    return std::min(1.0, 1.5 / crowd_) * stop_;
  }

 private:
  ImplicitPart implicit_;
  double dt_, stop_, crowd_;
};

/// Damping of a DC motor on its axis [N m s/rad]: gear^2 kt ke / R.
inline double dc_damping(const Motor& motor) {
  return motor.gear * motor.gear * motor.kt * motor.ke / motor.resistance;
}

/// What GainLimits::share() takes from the gains of servos and DC motors, and springs of joints
/// that are taken explicitly and are unstable in the steps of the scene. `limits(joint, axis)`
/// gives the limits of an axis, or none where the engine does not have it.
template <class Limits>
std::vector<Diagnostic> gain_warnings(const SceneModel& scene, const std::string& backend,
                                      const Limits& limits) {
  std::vector<Diagnostic> out;
  const auto number = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return std::string(text);
  };
  const auto warn = [&](const std::string& what, const SourceSpan& origin) {
    Diagnostic d;
    d.severity = Severity::warning;
    d.code = "CG2008";
    d.message = "backend '" + backend + "' " + what;
    d.help =
        "take a shorter step, smaller gains or a rotor inertia, or run the scene on another "
        "backend";
    d.locate(source_position(scene, origin));
    out.push_back(std::move(d));
  };
  for (const Motor& motor : scene.motors) {
    const bool dc = motor.mode == MotorMode::dc;
    if (motor.removed || (motor.mode != MotorMode::servo && !dc)) continue;
    const std::optional<GainLimits> of_axis = limits(motor.joint, motor.axis);
    const double kp = dc ? 0.0 : motor.kp, kd = dc ? dc_damping(motor) : motor.kd;
    if (const double share = of_axis ? of_axis->share(kp, kd) : 1.0; share < 1.0)
      warn("holds " + number(share) + " of the gains of motor '" + motor.name + "' on joint '" +
               scene.joints[static_cast<std::size_t>(motor.joint)].name + "' only (kp " +
               number(kp) + ", kd " + number(kd) +
               "): they are too stiff for the step and the inertia of the axis",
           motor.origin);
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    for (std::size_t i = 0; !joint.removed && i < joint.axes.size(); ++i) {
      const double stiffness = joint.axes[i].stiffness;
      if (!(stiffness > 0.0)) continue;
      const std::optional<GainLimits> of_axis = limits(static_cast<int>(j), static_cast<int>(i));
      if (const double times = of_axis ? of_axis->explicit_stiffness(stiffness) : 0.0; times >= 1.0)
        warn("takes the spring of joint '" + joint.name + "' (" + number(stiffness) +
                 ") explicitly, which is unstable: it is " + number(times) +
                 " times what the step and the inertia of the axis allow",
             joint.origin);
    }
  }
  return out;
}

/// Whether a motor can have a gain: all but torque motors without a limit of the speed.
inline bool may_have_gain(const SceneModel& scene, const Motor& motor) {
  const JointAxis& axis = scene.joints[static_cast<std::size_t>(motor.joint)]
                              .axes[static_cast<std::size_t>(motor.axis)];
  return motor.mode != MotorMode::torque ||
         std::isfinite(std::min(motor.max_speed, axis.max_speed));
}

/// An actuator with the effort `effort - kp q - kd u` at the start of a step, within `max_effort`,
/// and damping of its joint beside it.
struct ActuatorLaw {
  double effort = 0.0, kp = 0.0, kd = 0.0, max_effort = 0.0, damping = 0.0;
};

/// The drives of a world in a step. A stiff one (see GainLimits) is taken at the end of the step:
///
///     effort = clamp(bias + kp (position - q - dt u') + kd (velocity - u'), +-max_effort)
///
/// with the speed u' after it, by damping the joint with kd + dt kp (see GainLimits::damping()).
/// Damping has no bound, so that a drive beyond its bound gets the bound as a constant effort and
/// no damping. Which ones are is tried: as in the last step, and again where a step shows
/// otherwise.
class ImplicitDrives {
 public:
  void reset(std::size_t count) {
    stiff_.assign(count, {});
    at_bound.assign(count, 0);
  }

  /// The law for a step that starts at the coordinate `q`.
  ActuatorLaw law(std::size_t k, const Drive& drive, const GainLimits& limits, double q) {
    const bool source = drive.is_speed_source();
    const double share = source ? 1.0 : limits.share(drive.kp, drive.kd);
    const double kp = source ? 0.0 : share * drive.kp;
    const double kd = source ? limits.speed_source() : share * drive.kd;
    const double bias = source ? 0.0 : share * drive.bias;
    const double effort = bias + kp * drive.position + kd * drive.velocity;
    stiff_[k] = {};
    if (source ? !limits.has_implicit_sources() : !limits.is_stiff(kp, kd)) {
      at_bound[k] = 0;
      return {effort, kp, kd, drive.max_effort, 0.0};
    }
    const double wanted = effort - kp * q, most = limits.most_effort();
    const double start = std::clamp(wanted, -most, most);
    stiff_[k] = {start, limits.damping(kp, kd), drive.max_effort};
    if (at_bound[k] != 0) return {at_bound[k] * drive.max_effort, 0.0, 0.0, drive.max_effort, 0.0};
    return {effort + (start - wanted), kp, 0.0, std::numeric_limits<double>::infinity(),
            stiff_[k].damping};
  }

  /// Whether the effort is not that of the actuator alone, but effort(): damping has part in it.
  bool is_damped(std::size_t k) const { return stiff_[k].damping > 0.0 && at_bound[k] == 0; }
  /// By the speed `u` at the end of the step.
  double effort(std::size_t k, double u) const { return stiff_[k].start - stiff_[k].damping * u; }
  /// Whether drive k was taken to be within its bound and is beyond it, or with `release` the other
  /// way round, by the speed `u` at the end of the step; corrects this for a repetition of the
  /// step.
  bool correct(std::size_t k, double u, bool release) {
    if (stiff_[k].damping == 0.0 || (at_bound[k] != 0 && !release)) return false;
    const double wanted = effort(k, u), most = stiff_[k].max_effort;
    const int beyond = std::abs(wanted) < most ? 0 : wanted < 0.0 ? -1 : 1;
    // From its bound a drive comes within it before it is tried at the other one.
    const int now = at_bound[k] != 0 && beyond != at_bound[k] ? 0 : beyond;
    return std::exchange(at_bound[k], now) != now;
  }

  std::vector<int> at_bound;  ///< by drive, its sign if stiff and at its bound; part of snapshots

 private:
  struct Stiff {
    double start = 0.0, damping = 0.0, max_effort = 0.0;
  };
  std::vector<Stiff> stiff_;
};

}  // namespace cogrsim
