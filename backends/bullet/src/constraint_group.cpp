#include "constraint_group.h"

#include <algorithm>
#include <cmath>

#include "convert.h"

namespace cogrsim::bullet {

namespace {

// A row whose pivot falls below this part of its diagonal says nothing new (loops that lie in a
// plane have three such) and is left out.
constexpr double kDependent = 1e-9;
// Larger gaps of a joint are closed at this rate per step; smaller ones at once [m], [rad].
constexpr double kGapAtOnce = 1e-3;
constexpr double kGapRate = 0.2;

bool same(const Six& x, const Six& y) {
  for (int i = 0; i < 3; ++i) {
    if (x.p[i][0] != y.p[i][0] || x.p[i][1] != y.p[i][1]) return false;
  }
  return true;
}

double recovered(double gap) {
  const double size = std::abs(gap);
  if (size <= kGapAtOnce) return gap;
  return std::copysign(kGapAtOnce + kGapRate * (size - kGapAtOnce), gap);
}

}  // namespace

ConstraintGroup::ConstraintGroup(const SceneModel& model, const std::vector<int>& joints,
                                 std::vector<RigidBody>& bodies) {
  joint_indices_ = joints;
  const auto member_of = [&](int body) {
    if (body == kWorld || bodies[static_cast<std::size_t>(body)].kind() == BodyKind::fixed)
      return -1;
    const auto it = std::find(body_indices_.begin(), body_indices_.end(), body);
    if (it != body_indices_.end()) return static_cast<int>(it - body_indices_.begin());
    Member member;
    member.body = &bodies[static_cast<std::size_t>(body)];
    member.moves = member.body->dynamic();
    body_indices_.push_back(body);
    members_.push_back(member);
    return static_cast<int>(members_.size()) - 1;
  };
  const auto principal = [&](int body) {
    if (body == kWorld) return Pose();
    const RigidBody& b = bodies[static_cast<std::size_t>(body)];
    // What does not move is written in world axes.
    if (b.kind() == BodyKind::fixed) return b.anchor().inverse();
    return b.X_BP();
  };
  int row = 0;
  for (const int j : joints) {
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    JointSlot slot;
    slot.joint = j;
    slot.a = member_of(joint.child);
    slot.b = member_of(joint.parent);
    slot.X_PF = to_bt(principal(joint.parent).inverse() * joint.X_PF);
    slot.X_CM = to_bt(principal(joint.child).inverse() * joint.X_CM);
    slot.first_row = slot.first_open = row;
    slot.rows = locked_count(joint.type);
    row += slot.rows;
    const auto moves = [&](int m) { return m >= 0 && members_[static_cast<std::size_t>(m)].moves; };
    for (std::size_t s = 0; s < slots_.size(); ++s) {
      const JointSlot& other = slots_[s];
      const bool shared = (moves(slot.a) && (slot.a == other.a || slot.a == other.b)) ||
                          (moves(slot.b) && (slot.b == other.a || slot.b == other.b));
      if (!shared) continue;
      slot.neighbours.push_back(static_cast<int>(s));
      slot.first_open = std::min(slot.first_open, other.first_row);
    }
    slot.motors = motors_of(model, j);
    slots_.push_back(std::move(slot));
  }
  rows_.resize(static_cast<std::size_t>(row));
  directions_.resize(static_cast<std::size_t>(row));
  first_.resize(static_cast<std::size_t>(row));
  for (const JointSlot& slot : slots_) {
    for (int r = 0; r < slot.rows; ++r)
      first_[static_cast<std::size_t>(slot.first_row + r)] = slot.first_open;
  }
  if (!small()) factor_.setZero(row, row);
  inverse_diagonal_.setZero(row);
  target_.setZero(row);
  impulses_.setZero(row);
  work_.setZero(row);
}

void ConstraintGroup::fill_row(const JointSlot& slot, const btTransform& X_WM,
                               const Direction& direction, Row& row) const {
  row.a = slot.a;
  row.b = slot.b;
  const auto fill = [&](int m, const btVector3& lin, const btVector3& turn, Six& J, Six& K) {
    if (m < 0) return;
    const Member& member = members_[static_cast<std::size_t>(m)];
    const btRigidBody& object = member.body->object();
    const btVector3 arm = X_WM.getOrigin() - object.getWorldTransform().getOrigin();
    const btVector3 ang = turn + arm.cross(lin);
    J = Six(lin, ang);
    K = member.moves ? Six(lin * object.getInvMass(), object.getInvInertiaTensorWorld() * ang)
                     : Six();
  };
  fill(row.a, direction.lin, direction.ang, row.Ja, row.Ka);
  fill(row.b, -direction.lin, -direction.ang, row.Jb, row.Kb);
}

void ConstraintGroup::join(const SceneModel& model, const std::vector<char>& sudden) {
  for (Member& member : members_) {
    const PrincipalState state = member.body->principal();
    member.v = Six(state.v, state.w);
  }
  std::array<Direction, 6> directions;
  const auto now = [&](int m) {
    return m < 0 ? btTransform::getIdentity()
                 : members_[static_cast<std::size_t>(m)].body->object().getWorldTransform();
  };
  for (const JointSlot& slot : slots_) {
    const Joint& joint = model.joints[static_cast<std::size_t>(slot.joint)];
    const btTransform X_WF = now(slot.b) * slot.X_PF, X_WM = now(slot.a) * slot.X_CM;
    const int n = locked_directions(joint, X_WF, X_WM, directions);
    for (int k = 0; k < n; ++k) {
      const auto r = static_cast<std::size_t>(slot.first_row + k);
      fill_row(slot, X_WM, directions[static_cast<std::size_t>(k)], rows_[r]);
      // The others go on as they did: their velocities belong to the middle of a step, where these
      // rows are a little different.
      const double speed = along(rows_[r]);
      work_[slot.first_row + k] = sudden[static_cast<std::size_t>(slot.joint)] ? -speed : 0.0;
    }
  }
  factorise();
  solve(work_);
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    push(rows_[r], work_[static_cast<Eigen::Index>(r)]);
  }
  for (const Member& member : members_) {
    if (!member.moves) continue;
    PrincipalState state = member.body->principal();
    state.v = member.v.lin();
    state.w = member.v.ang();
    member.body->set_principal(state);
  }
}

void ConstraintGroup::prepare(const SceneModel& model, double dt, const std::vector<Drive>& drives,
                              const std::vector<double>& q) {
  for (Member& member : members_) {
    const PrincipalState state = member.body->principal();
    member.v = Six(state.v, state.w);
    member.then = member.body->predicted(dt).X_WP;
  }
  axis_count_ = 0;
  std::array<Direction, 6> directions;
  std::array<double, 6> errors{};
  const auto now = [&](int m) {
    return m < 0 ? btTransform::getIdentity()
                 : members_[static_cast<std::size_t>(m)].body->object().getWorldTransform();
  };
  const auto then = [&](int m) {
    return m < 0 ? btTransform::getIdentity() : members_[static_cast<std::size_t>(m)].then;
  };
  for (const JointSlot& slot : slots_) {
    const Joint& joint = model.joints[static_cast<std::size_t>(slot.joint)];
    const double* q_joint = q.data() + joint.position_offset;
    const btTransform X_WF = now(slot.b) * slot.X_PF, X_WM = now(slot.a) * slot.X_CM;
    const int n = locked_directions(joint, X_WF, X_WM, directions);
    for (int k = 0; k < n; ++k) {
      const auto r = static_cast<std::size_t>(slot.first_row + k);
      directions_[r] = directions[static_cast<std::size_t>(k)];
      fill_row(slot, X_WM, directions_[r], rows_[r]);
    }
    if (n > 0) {
      // A screw's error is asked at the angle it will have.
      double q_then[7] = {};
      if (joint.type == JointType::screw) {
        const Direction turn{{0, 0, 0}, X_WF.getBasis().getColumn(2)};
        Row row;
        fill_row(slot, X_WM, turn, row);
        q_then[0] = q_joint[0] + dt * along(row);
      }
      locked_errors(joint, then(slot.b) * slot.X_PF, then(slot.a) * slot.X_CM, q_then, errors);
    }
    for (int k = 0; k < n; ++k) {
      const int r = slot.first_row + k;
      target_[r] = along(rows_[static_cast<std::size_t>(r)]) -
                   recovered(errors[static_cast<std::size_t>(k)]) / dt;
    }
    gather_axes(joint, slot, X_WF, X_WM, drives, q_joint);
  }
  factorise();
  impulses_.setZero();
  for (std::size_t i = 0; i < axis_count_; ++i) {
    prepare_response(axes_[i]);
    fill_law(model, axes_[i], dt, drives);
  }
  couple_axes();
}

void ConstraintGroup::factorise() {
  if (small()) {
    invert();
    return;
  }
  const int n = static_cast<int>(rows_.size());
  for (const JointSlot& slot : slots_) {
    for (int i = slot.first_row; i < slot.first_row + slot.rows; ++i) {
      auto row = factor_.row(i);
      const Row& own = rows_[static_cast<std::size_t>(i)];
      for (int j = slot.first_open; j < slot.first_row; ++j) row[j] = 0.0;
      for (const int s : slot.neighbours) {
        const JointSlot& other = slots_[static_cast<std::size_t>(s)];
        for (int j = other.first_row; j < other.first_row + other.rows; ++j)
          row[j] = coupling(own, rows_[static_cast<std::size_t>(j)]);
      }
      for (int j = slot.first_row; j <= i; ++j)
        row[j] = coupling(own, rows_[static_cast<std::size_t>(j)]);
    }
  }
  // L D L^T within the envelope; row i of the lower triangle is worked on in place.
  for (int i = 0; i < n; ++i) {
    const int fi = first_[static_cast<std::size_t>(i)];
    double* own = factor_.row(i).data();
    const double diagonal = own[i];
    double d = diagonal;
    for (int j = fi; j < i; ++j) {
      const double* other = factor_.row(j).data();
      double s = own[j];
      for (int k = std::max(fi, first_[static_cast<std::size_t>(j)]); k < j; ++k)
        s -= own[k] * other[k];
      own[j] = s;  // L_ij D_j for now
    }
    for (int j = fi; j < i; ++j) {
      const double l = own[j] * inverse_diagonal_[j];
      d -= own[j] * l;
      own[j] = l;
    }
    inverse_diagonal_[i] = d > kDependent * diagonal ? 1.0 / d : 0.0;
  }
}

bool ConstraintGroup::small() const {
  return rows_.size() <= static_cast<std::size_t>(SmallMatrix::kMost);
}

void ConstraintGroup::invert() {
  inverse_.resize(static_cast<int>(rows_.size()));
  const auto couple = [&](int i, int j) {
    inverse_.at(i, j) = inverse_.at(j, i) =
        coupling(rows_[static_cast<std::size_t>(i)], rows_[static_cast<std::size_t>(j)]);
  };
  for (const JointSlot& slot : slots_) {
    for (int i = slot.first_row; i < slot.first_row + slot.rows; ++i) {
      for (const int s : slot.neighbours) {
        const JointSlot& other = slots_[static_cast<std::size_t>(s)];
        for (int j = other.first_row; j < other.first_row + other.rows; ++j) couple(i, j);
      }
      for (int j = slot.first_row; j <= i; ++j) couple(i, j);
    }
  }
  inverse_.invert(kDependent);
}

void ConstraintGroup::solve(Eigen::VectorXd& vector) const {
  double* const x = vector.data();
  if (small()) {
    inverse_.multiply(x);
    return;
  }
  const int n = static_cast<int>(rows_.size());
  const int* first = first_.data();
  const double* inverse = inverse_diagonal_.data();
  const double* row = factor_.data();
  for (int i = 0; i < n; ++i, row += n) {
    double s = x[i];
    for (int k = first[i]; k < i; ++k) s -= row[k] * x[k];
    x[i] = s;
  }
  for (int i = 0; i < n; ++i) x[i] *= inverse[i];
  for (int i = n - 1; i >= 0; --i) {
    row -= n;
    const double s = x[i];
    for (int k = first[i]; k < i; ++k) x[k] -= row[k] * s;
  }
}

void ConstraintGroup::bind(StepBodies& bodies) {
  solved_ = false;
  for (Member& member : members_) {
    member.index = StepBodies::index_of(member.body->object());
    bodies.hold(member.index);
    const StepBodies::Entry& entry = bodies.entry(member.index);
    member.start = Six(entry.lin, entry.ang);
  }
}

void ConstraintGroup::iterate(StepBodies& bodies) {
  // Nothing to do where no contact has touched the group since.
  bool unchanged = solved_;
  for (Member& member : members_) {
    const DeltaVelocity& now = bodies.delta(member.index);
    unchanged = unchanged && same(now, member.delta);
    member.delta = now;
    member.v = member.start + now;
  }
  if (unchanged) return;
  solved_ = true;
  const std::size_t n = rows_.size();
  double* const work = work_.data();
  const double* const target = target_.data();
  for (std::size_t i = 0; i < n; ++i) work[i] = target[i] - along(rows_[i]);
  solve(work_);
  double* const impulses = impulses_.data();
  for (std::size_t i = 0; i < n; ++i) {
    impulses[i] += work[i];
    push(rows_[i], work[i]);
  }
  if (axis_count_ > 0) solve_axes();
  for (Member& member : members_) {
    if (!member.moves) continue;
    member.delta = member.v - member.start;
    static_cast<Six&>(bodies.delta(member.index)) = member.delta;
  }
}

void ConstraintGroup::report(const SceneModel& model, double dt, JointReport& out) {
  for (const JointSlot& slot : slots_) {
    const Joint& joint = model.joints[static_cast<std::size_t>(slot.joint)];
    for (int k = 0; k < speed_count(joint.type); ++k) {
      out.joint_efforts[static_cast<std::size_t>(joint.speed_offset + k)] = 0.0;
    }
    btVector3 force(0, 0, 0), torque(0, 0, 0);
    for (int r = slot.first_row; r < slot.first_row + slot.rows; ++r) {
      const Direction& d = directions_[static_cast<std::size_t>(r)];
      force += d.lin * (impulses_[r] / dt);
      torque += d.ang * (impulses_[r] / dt);
    }
    Wrench& wrench = out.reactions[static_cast<std::size_t>(slot.joint)];
    wrench = {from_bt(force), from_bt(torque)};
  }
  for (std::size_t i = 0; i < axis_count_; ++i) {
    const Axis& axis = axes_[i];
    const double effort = axis.impulse / dt;
    const JointSlot& slot = slots_[static_cast<std::size_t>(axis.slot)];
    Wrench& wrench = out.reactions[static_cast<std::size_t>(slot.joint)];
    wrench.force += from_bt(axis.direction.lin) * effort;
    wrench.torque += from_bt(axis.direction.ang) * effort;
    const auto speed = static_cast<std::size_t>(axis.speed);
    if (axis.part != AxisPart::whole) {
      for (int k = 0; k < 3; ++k)
        out.joint_efforts[speed + static_cast<std::size_t>(k)] += axis.in_F[k] * effort;
    } else {
      out.joint_efforts[speed] += effort;
    }
    for (std::size_t m = 0; m < axis.motors.size() && axis.part == AxisPart::whole; ++m) {
      out.motor_efforts[static_cast<std::size_t>(axis.motors[m])] = axis.law.impulse(m) / dt;
    }
  }
}

}  // namespace cogrsim::bullet
