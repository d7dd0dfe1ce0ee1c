// Everything that acts along one free axis of a joint during one step, solved exactly.
#pragma once

#include <limits>
#include <vector>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"

namespace cogrsim::bullet {

/// One non-increasing law impulse(u) of the speed u at the end of the step:
///
///     impulse(u) = clamp(offset - slope * u, low, high)
///
/// With infinite slope it is a step at `speed`: `high` below it, `low` above, anything between at
/// it.
struct AxisElement {
  double offset = 0.0;  ///< impulse at u = 0
  double slope = 0.0;   ///< impulse per speed, >= 0
  double speed = 0.0;   ///< where the step is; only with infinite slope
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  bool is_step() const { return slope == std::numeric_limits<double>::infinity(); }
};

/// The elements of one axis and the impulses they gave. The unknown u obeys
///
///     u = v + a * sum_i impulse_i(u),
///
/// v being the speed without this axis and a > 0 the inverse of the inertia felt along it. The
/// right side does not increase with u, so there is exactly one solution; between break points it
/// is linear.
class AxisLaw {
 public:
  void clear();
  void add(const AxisElement& element);
  bool empty() const { return elements_.empty(); }
  std::size_t size() const { return elements_.size(); }

  /// Solves for u and returns the sum of the impulses there.
  double solve(double v, double a);
  const AxisElement& element(std::size_t i) const { return elements_[i]; }
  /// The solution where it was found elsewhere, of a law of one element.
  void set_only_impulse(double impulse) { impulses_[0] = impulse; }
  /// Impulse of element `i` in the last solution.
  double impulse(std::size_t i) const { return impulses_[i]; }

 private:
  double total_at(double u, double v, double a, bool above) const;

  std::vector<AxisElement> elements_;
  std::vector<double> breaks_;  ///< speeds at which an element bends or jumps, sorted
  std::vector<double> impulses_;
};

/// How an axis is seen by its elements: coordinate, speed at the start of the step, step, and the
/// inverse inertia along it.
struct AxisState {
  double q = 0.0;
  double u = 0.0;
  double dt = 0.0;
  double inverse_inertia = 0.0;
};

/// A drive as an element. Where kp and kd are soft against the step the position term is taken at
/// its start and the damping term at the mean speed, which neither adds nor drains energy and is of
/// second order; where they are stiff both are taken at the end, which is stable for any gain.
AxisElement drive_element(const Drive& drive, const AxisState& axis);
/// The joint's own spring and damper, discretised the same way.
AxisElement spring_damper_element(const JointAxis& model, const AxisState& axis);
/// Coulomb friction: a step at zero speed.
AxisElement friction_element(double effort, double dt);
/// Stops the axis so that it lands on the limit at the end of the step, without bounce. A step at
/// the speed that reaches it; it only pushes back.
AxisElement lower_limit_element(double lower, const AxisState& axis);
AxisElement upper_limit_element(double upper, const AxisState& axis);

}  // namespace cogrsim::bullet
