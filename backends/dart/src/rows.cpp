#include "rows.h"

#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/Skeleton.hpp>

namespace cogrsim::dart_engine {

namespace {

// DART's own of its joints' constraints, relative to the diagonal.
constexpr double kForceMixing = 1e-9;

}  // namespace

const std::string& AxisRow::getType() const {
  static const std::string name = "AxisRow";
  return name;
}

double AxisRow::speed() const {
  double out = 0.0;
  for (const Term& term : terms_) out += term.factor * term.joint->getVelocity(0);
  return out;
}

void AxisRow::update() {
  impulse_ = 0.0;
  free_ = speed();
}

void AxisRow::getInformation(dart::constraint::ConstraintInfo* info) {
  info->lo[0] = -bound_;
  info->hi[0] = bound_;
  info->b[0] = target_ - free_;
  info->x[0] = 0.0;
}

void AxisRow::applyUnitImpulse(std::size_t) {
  for (const Term& term : terms_) term.joint->getSkeleton()->clearConstraintImpulses();
  for (const Term& term : terms_) term.joint->setConstraintImpulse(0, term.factor);
  // From each towards its root: what two have in common is found again with both.
  for (const Term& term : terms_)
    term.joint->getSkeleton()->updateBiasImpulse(term.joint->getChildBodyNode());
  for (const Term& term : terms_) term.joint->getSkeleton()->updateVelocityChange();
  for (const Term& term : terms_) term.joint->setConstraintImpulse(0, 0.0);
}

void AxisRow::getVelocityChange(double* change, bool with_cfm) {
  change[0] = 0.0;
  for (const Term& term : terms_)
    if (term.joint->getSkeleton()->isImpulseApplied())
      change[0] += term.factor * term.joint->getVelocityChange(0);
  if (with_cfm) change[0] += softness_ > 0.0 ? softness_ : kForceMixing * change[0];
}

void AxisRow::applyImpulse(double* impulse) {
  impulse_ = impulse[0];
  for (const Term& term : terms_)
    term.joint->setConstraintImpulse(0,
                                     term.joint->getConstraintImpulse(0) + term.factor * impulse_);
}

void AxisRow::set_applied(bool value) {
  for (const Term& term : terms_) term.joint->getSkeleton()->setImpulseApplied(value);
}

dart::dynamics::SkeletonPtr AxisRow::getRootSkeleton() const {
  return ConstraintBase::getRootSkeleton(terms_[0].joint->getSkeleton());
}

void AxisRow::uniteSkeletons() {
  for (std::size_t i = 1; i < terms_.size(); ++i) {
    const auto a = compressPath(terms_[0].joint->getSkeleton());
    const auto b = compressPath(terms_[i].joint->getSkeleton());
    if (a == b) continue;
    const bool larger = a->mUnionSize >= b->mUnionSize;
    const auto &root = larger ? a : b, &other = larger ? b : a;
    other->mUnionRootSkeleton = root;
    root->mUnionSize += other->mUnionSize;
  }
}

}  // namespace cogrsim::dart_engine
