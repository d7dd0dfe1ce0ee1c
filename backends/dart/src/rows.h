// Rows of DART's boxed LCP along joints: motors, rotors and couplings, which its own joints have not or
// not as the scene language says.
#pragma once

#include <dart/constraint/ConstraintBase.hpp>
#include <dart/dynamics/Joint.hpp>
#include <limits>
#include <string>
#include <vector>

namespace cogrsim::dart_engine {

/// One row over speeds u of joints with one freedom each: the impulse x within +-bound brings
///
///     sum factor u = target - softness x
///
/// at the end of DART's constraint solve, which solves it together with contacts, limits and dry friction. A
/// value of `softness` says what the row is: 0 a speed source, 1 / (h (kd + h kp)) a servo taken at the
/// end of the step, 1 / I the inertia I of a rotor that had the speed `target`.
class AxisRow final : public dart::constraint::ConstraintBase {
 public:
  struct Term {
    dart::dynamics::Joint* joint = nullptr;
    double factor = 1.0;
  };
  explicit AxisRow(std::vector<Term> terms) : terms_(std::move(terms)) { mDim = 1; }

  /// For the next step. Without `set` a row does nothing but look.
  void set(double target, double softness, double bound) {
    target_ = target;
    softness_ = softness;
    bound_ = bound;
    active_ = bound > 0.0;
  }
  void clear() { active_ = false; }
  /// Of the last step [N m s], [N s].
  double impulse() const { return impulse_; }
  /// sum factor u of the last step before any constraint.
  double free_speed() const { return free_; }
  double speed() const;
  const std::vector<Term>& terms() const { return terms_; }

  const std::string& getType() const override;
  void update() override;
  void getInformation(dart::constraint::ConstraintInfo* info) override;
  void applyUnitImpulse(std::size_t index) override;
  void getVelocityChange(double* change, bool with_cfm) override;
  void excite() override { set_applied(true); }
  void unexcite() override { set_applied(false); }
  void applyImpulse(double* impulse) override;
  bool isActive() const override { return active_; }
  dart::dynamics::SkeletonPtr getRootSkeleton() const override;
  void uniteSkeletons() override;

 private:
  void set_applied(bool value);

  std::vector<Term> terms_;
  double target_ = 0.0, softness_ = 0.0, bound_ = 0.0, impulse_ = 0.0, free_ = 0.0;
  bool active_ = false;
};

}  // namespace cogrsim::dart_engine
