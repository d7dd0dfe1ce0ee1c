#include "axis_law.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"

namespace cogrsim::bullet {

namespace {

// Stands for an unbounded impulse, so that opposing unbounded elements do not make a NaN.
constexpr double kUnbounded = 1e12;
// A coordinate found beyond its limit is brought back by this part of the way per step.
constexpr double kLimitRecovery = 0.2;
// ... but no faster than this: a limit may be moved to far behind it [rad/s], [m/s].
constexpr double kRecoverySpeed = 1.0;
// Up to these products of gain, step and inverse inertia an axis counts as soft. Symplectic Euler
// is stable up to 4 for the spring; damping at the mean speed never changes sign up to 2.
constexpr double kSoftSpring = 0.25;
constexpr double kSoftDamper = 1.0;

/// clamp(dt (bias + kp (position - q) + kd (velocity - u))) with the terms placed in time.
AxisElement linear_element(double bias, double kp, double position, double kd, double velocity,
                           double max_effort, const AxisState& axis) {
  const double dt = axis.dt, a = axis.inverse_inertia;
  const bool soft = dt * dt * kp * a <= kSoftSpring && dt * kd * a <= kSoftDamper;
  AxisElement e;
  if (soft) {
    e.slope = 0.5 * dt * kd;
    e.offset = dt * (bias + kp * (position - axis.q) + kd * (velocity - 0.5 * axis.u));
  } else {
    e.slope = dt * (kd + dt * kp);
    e.offset = dt * (bias + kp * (position - axis.q) + kd * velocity);
  }
  e.low = -max_effort * dt;
  e.high = max_effort * dt;
  return e;
}

/// Impulse of one element at speed u; `above` decides which side of a step exactly at u is meant.
double impulse_at(const AxisElement& e, double u, bool above) {
  if (e.is_step()) return u > e.speed || (u == e.speed && above) ? e.low : e.high;
  return std::clamp(e.offset - e.slope * u, e.low, e.high);
}

}  // namespace

void AxisLaw::clear() {
  elements_.clear();
  breaks_.clear();
  impulses_.clear();
}

void AxisLaw::add(const AxisElement& given) {
  AxisElement element = given;
  element.low = std::max(element.low, -kUnbounded);
  element.high = std::min(element.high, kUnbounded);
  elements_.push_back(element);
  impulses_.push_back(0.0);
  if (element.is_step()) {
    breaks_.push_back(element.speed);
  } else if (element.slope > 0.0) {
    if (element.high < kUnbounded) {
      breaks_.push_back((element.offset - element.high) / element.slope);
    }
    if (element.low > -kUnbounded) {
      breaks_.push_back((element.offset - element.low) / element.slope);
    }
  }
  std::sort(breaks_.begin(), breaks_.end());
}

double AxisLaw::total_at(double u, double v, double a, bool above) const {
  double sum = 0.0;
  for (const AxisElement& e : elements_) sum += impulse_at(e, u, above);
  return u - v - a * sum;
}

double AxisLaw::solve(double v, double a) {
  if (elements_.size() == 1) {
    const AxisElement& e = elements_.front();
    const double wanted =
        e.is_step() ? (e.speed - v) / a : (e.offset - e.slope * v) / (1.0 + e.slope * a);
    return impulses_[0] = std::clamp(wanted, e.low, e.high);
  }
  // The balance u - v - a * sum rises with u. Find the first break point it has passed zero at:
  // the root lies in the piece before it, or within the jump at it.
  std::size_t k = 0;
  double below = 0.0, above = 0.0;
  for (; k < breaks_.size(); ++k) {
    below = total_at(breaks_[k], v, a, false);
    above = total_at(breaks_[k], v, a, true);
    if (above >= 0.0) break;
  }
  double sum = 0.0;
  if (k < breaks_.size() && below <= 0.0) {
    // At the break itself: jumping elements share what the others leave open.
    const double u = breaks_[k];
    double fixed = 0.0, high = 0.0, low = 0.0;
    for (const AxisElement& e : elements_) {
      if (e.is_step() && e.speed == u) {
        high += e.high;
        low += e.low;
      } else {
        fixed += impulse_at(e, u, false);
      }
    }
    const double wanted = (u - v) / a - fixed;
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      const AxisElement& e = elements_[i];
      if (!(e.is_step() && e.speed == u)) {
        impulses_[i] = impulse_at(e, u, false);
        continue;
      }
      // In proportion to what each could give.
      const double span = wanted >= 0.0 ? high : low;
      const double own = wanted >= 0.0 ? e.high : e.low;
      impulses_[i] = span == 0.0 ? 0.0 : wanted * (own / span);
    }
    return (u - v) / a;
  }
  // Inside a linear piece (before the first, between two, after the last break): take its slope.
  double offset = 0.0, slope = 0.0;
  for (const AxisElement& e : elements_) {
    double probe;
    if (breaks_.empty()) {
      probe = 0.0;
    } else if (k == 0) {
      probe = breaks_.front() - 1.0;
    } else if (k == breaks_.size()) {
      probe = breaks_.back() + 1.0;
    } else {
      probe = 0.5 * (breaks_[k - 1] + breaks_[k]);
    }
    const double free = e.offset - e.slope * probe;
    if (e.is_step() || free <= e.low || free >= e.high) {
      offset += impulse_at(e, probe, true);
    } else {
      offset += e.offset;
      slope += e.slope;
    }
  }
  const double u = (v + a * offset) / (1.0 + a * slope);
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    impulses_[i] = impulse_at(elements_[i], u, true);
    sum += impulses_[i];
  }
  return sum;
}

AxisElement drive_element(const Drive& drive, const AxisState& axis) {
  if (drive.is_speed_source()) {
    AxisElement e;
    e.slope = kInfinity;
    e.speed = drive.velocity;
    e.low = -drive.max_effort * axis.dt;
    e.high = drive.max_effort * axis.dt;
    return e;
  }
  return linear_element(drive.bias, drive.kp, drive.position, drive.kd, drive.velocity,
                        drive.max_effort, axis);
}

AxisElement spring_damper_element(const JointAxis& model, const AxisState& axis) {
  return linear_element(0.0, model.stiffness, model.rest, model.damping, 0.0, kInfinity, axis);
}

AxisElement friction_element(double effort, double dt) {
  AxisElement e;
  e.slope = kInfinity;
  e.low = -effort * dt;
  e.high = effort * dt;
  return e;
}

AxisElement lower_limit_element(double lower, const AxisState& axis) {
  AxisElement e;
  e.slope = kInfinity;
  e.speed = (lower - axis.q) / axis.dt;
  if (axis.q < lower) e.speed = std::min(kLimitRecovery * e.speed, kRecoverySpeed);
  e.low = 0.0;
  return e;
}

AxisElement upper_limit_element(double upper, const AxisState& axis) {
  AxisElement e;
  e.slope = kInfinity;
  e.speed = (upper - axis.q) / axis.dt;
  if (axis.q > upper) e.speed = std::max(kLimitRecovery * e.speed, -kRecoverySpeed);
  e.high = 0.0;
  return e;
}

}  // namespace cogrsim::bullet
