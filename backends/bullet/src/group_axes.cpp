// The free axes of a ConstraintGroup: which ones have something acting on them, how the group
// responds, and by what law.
#include <algorithm>
#include <cmath>

#include "constraint_group.h"
#include "convert.h"

namespace cogrsim::bullet {

namespace {

// Axes of one group are swept until none changes by more than this part, or so often.
constexpr double kAxisTolerance = 1e-12;
constexpr int kAxisSweeps = 30;
// Below this speed friction of a ball joint has no direction yet [rad/s].
constexpr double kAtRest = 1e-9;
// Two axes whose equations' determinant falls below this part of its diagonal are nearly one.
constexpr double kSingular = 1e-9;

/// Speed along a row when the members move with `velocities`.
template <class Row>
double speed_of(const Row& row, const std::vector<Six>& velocities) {
  Pair out = {};
  if (row.a >= 0) out += product(row.Ja, velocities[static_cast<std::size_t>(row.a)]);
  if (row.b >= 0) out += product(row.Jb, velocities[static_cast<std::size_t>(row.b)]);
  return sum(out);
}

}  // namespace

ConstraintGroup::Axis& ConstraintGroup::next_axis(const JointSlot& slot, const btTransform& X_WM,
                                                  const Direction& direction) {
  if (axis_count_ == axes_.size()) axes_.emplace_back();
  Axis& axis = axes_[axis_count_++];
  axis.slot = static_cast<int>(&slot - slots_.data());
  axis.direction = direction;
  fill_row(slot, X_WM, direction, axis.row);
  axis.law.clear();
  axis.motors.clear();
  axis.impulse = 0.0;
  axis.part = AxisPart::whole;
  return axis;
}

void ConstraintGroup::prepare_response(Axis& axis) {
  const auto n = static_cast<Eigen::Index>(rows_.size());
  axis.reaction.setZero(n);
  const Row& own = axis.row;
  for (Eigen::Index i = 0; i < n; ++i)
    axis.reaction[i] = -coupling(rows_[static_cast<std::size_t>(i)], own);
  solve(axis.reaction);
  axis.response.assign(members_.size(), Six());
  const auto spread = [&](const Row& r, double impulse) {
    if (r.a >= 0) add_scaled(axis.response[static_cast<std::size_t>(r.a)], r.Ka, impulse);
    if (r.b >= 0) add_scaled(axis.response[static_cast<std::size_t>(r.b)], r.Kb, impulse);
  };
  spread(own, 1.0);
  for (Eigen::Index i = 0; i < n; ++i) spread(rows_[static_cast<std::size_t>(i)], axis.reaction[i]);
  axis.inverse_inertia = speed_of(own, axis.response);
}

void ConstraintGroup::couple_axes() {
  between_axes_.resize(axis_count_ * axis_count_);
  axis_speeds_.resize(axis_count_);
  axis_changes_.resize(axis_count_);
  for (std::size_t i = 0; i < axis_count_; ++i) {
    const Row& own = axes_[i].row;
    for (std::size_t k = 0; k < axis_count_; ++k) {
      const Axis& other = axes_[k];
      between_axes_[i * axis_count_ + k] = speed_of(own, other.response);
    }
  }
}

bool ConstraintGroup::solve_two_axes() {
  // Of each law  impulse = offset - slope u,  or u = speed, and both speeds  u = free + B impulse:
  // two linear equations  E impulse = r.
  double E[2][2], r[2];
  for (std::size_t k = 0; k < 2; ++k) {
    const Axis& axis = axes_[k];
    if (axis.law.size() != 1 || axis.inverse_inertia <= 0.0) return false;
    const AxisElement& e = axis.law.element(0);
    const double* const B = &between_axes_[2 * k];
    const double free = axis_speeds_[k] - (B[0] * axes_[0].impulse + B[1] * axes_[1].impulse);
    const double slope = e.is_step() ? 1.0 : e.slope;
    for (std::size_t i = 0; i < 2; ++i) E[k][i] = slope * B[i];
    if (e.is_step()) {
      r[k] = e.speed - free;
    } else {
      E[k][k] += 1.0;
      r[k] = e.offset - e.slope * free;
    }
  }
  const double determinant = E[0][0] * E[1][1] - E[0][1] * E[1][0];
  if (std::abs(determinant) < kSingular * std::abs(E[0][0] * E[1][1])) return false;
  const double impulse[2] = {(r[0] * E[1][1] - r[1] * E[0][1]) / determinant,
                             (r[1] * E[0][0] - r[0] * E[1][0]) / determinant};
  for (std::size_t k = 0; k < 2; ++k) {
    const AxisElement& e = axes_[k].law.element(0);
    // Written so that a NaN fails.
    if (!(impulse[k] >= e.low && impulse[k] <= e.high)) return false;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    axis_changes_[k] = impulse[k] - axes_[k].impulse;
    axes_[k].impulse = impulse[k];
    axes_[k].law.set_only_impulse(impulse[k]);
  }
  return true;
}

void ConstraintGroup::solve_axes() {
  for (std::size_t i = 0; i < axis_count_; ++i) {
    axis_speeds_[i] = along(axes_[i].row);
    axis_changes_[i] = 0.0;
  }
  const bool solved = axis_count_ == 2 && solve_two_axes();
  for (int sweep = 0; sweep < kAxisSweeps && !solved; ++sweep) {
    bool settled = true;
    for (std::size_t k = 0; k < axis_count_; ++k) {
      Axis& axis = axes_[k];
      if (axis.inverse_inertia <= 0.0) continue;
      const double v = axis_speeds_[k] - axis.inverse_inertia * axis.impulse;
      const double impulse = axis.law.solve(v, axis.inverse_inertia);
      const double change = impulse - axis.impulse;
      if (std::abs(change) > kAxisTolerance * std::abs(impulse)) settled = false;
      axis.impulse = impulse;
      axis_changes_[k] += change;
      for (std::size_t i = 0; i < axis_count_; ++i) {
        axis_speeds_[i] += between_axes_[i * axis_count_ + k] * change;
      }
    }
    if (settled || axis_count_ < 2) break;
  }
  for (std::size_t k = 0; k < axis_count_; ++k) {
    const double change = axis_changes_[k];
    if (change == 0.0) continue;
    const Axis& axis = axes_[k];
    impulses_ += axis.reaction * change;
    for (std::size_t m = 0; m < members_.size(); ++m)
      add_scaled(members_[m].v, axis.response[m], change);
  }
}

void ConstraintGroup::gather_axes(const Joint& joint, const JointSlot& slot,
                                  const btTransform& X_WF, const btTransform& X_WM,
                                  const std::vector<Drive>& drives, const double* q) {
  if (joint.type == JointType::ball) {
    gather_ball(joint, slot, X_WF, X_WM, q);
    return;
  }
  std::array<Direction, 3> directions;
  const int n = free_directions(joint, X_WF, X_WM, directions);
  for (int k = 0; k < n; ++k) {
    const auto index = static_cast<std::size_t>(k);
    const JointAxis& model = joint.axes[index];
    const bool driven =
        std::any_of(slot.motors[index].begin(), slot.motors[index].end(),
                    [&](int m) { return acts(drives[static_cast<std::size_t>(m)]); });
    if (!driven && model.stiffness <= 0.0 && model.damping <= 0.0 && model.friction <= 0.0 &&
        !model.has_limit()) {
      continue;
    }
    Axis& axis = next_axis(slot, X_WM, directions[index]);
    axis.number = k;
    axis.q = q[k];
    axis.motors = slot.motors[index];
  }
}

void ConstraintGroup::gather_ball(const Joint& joint, const JointSlot& slot,
                                  const btTransform& X_WF, const btTransform& X_WM,
                                  const double* q) {
  const JointAxis& model = joint.axes.front();
  if (model.stiffness <= 0.0 && model.damping <= 0.0 && model.friction <= 0.0 &&
      !std::isfinite(model.upper)) {
    return;
  }
  const btMatrix3x3& F = X_WF.getBasis();
  const btVector3 turn = rotation_vector(btQuaternion(q[1], q[2], q[3], q[0]));
  // The triad: with friction one axis lies along the motion, which it opposes as a whole.
  btVector3 triad[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto rate = [&](int k) {
    Row row;
    fill_row(slot, X_WM, {{0, 0, 0}, F.getColumn(k)}, row);
    return along(row);
  };
  const btVector3 w(rate(0), rate(1), rate(2));
  if (model.friction > 0.0 && w.length() > kAtRest) {
    triad[0] = w.normalized();
    btPlaneSpace1(triad[0], triad[1], triad[2]);
  }
  if (model.stiffness > 0.0 || model.damping > 0.0 || model.friction > 0.0) {
    for (int k = 0; k < 3; ++k) {
      Axis& axis = next_axis(slot, X_WM, {{0, 0, 0}, F * triad[k]});
      axis.number = 0;
      axis.q = turn.dot(triad[k]);
      axis.in_F = triad[k];
      axis.part = AxisPart::ball_spring;
    }
  }
  const double angle = turn.length();
  if (std::isfinite(model.upper) && angle > 1e-9) {
    Axis& axis = next_axis(slot, X_WM, {{0, 0, 0}, F * (turn / angle)});
    axis.number = 0;
    axis.q = angle;
    axis.in_F = turn / angle;
    axis.part = AxisPart::ball_cone;
  }
}

void ConstraintGroup::fill_law(const SceneModel& model, Axis& axis, double dt,
                               const std::vector<Drive>& drives) {
  const Joint& joint =
      model.joints[static_cast<std::size_t>(slots_[static_cast<std::size_t>(axis.slot)].joint)];
  const JointAxis& law = joint.axes[static_cast<std::size_t>(axis.number)];
  axis.speed = joint.speed_offset + axis.number;
  const AxisState state{axis.q, along(axis.row), dt, axis.inverse_inertia};
  fill_axis_law(axis.law, axis.part, law, state, axis.motors, drives);
}

}  // namespace cogrsim::bullet
