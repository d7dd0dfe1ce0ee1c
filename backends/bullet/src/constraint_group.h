// An articulated group whose bodies are Bullet rigid bodies, joints being constraints between them.
//
// The forbidden directions of all joints of a group are solved together and exactly (a direct
// factorisation of J M^-1 J^T), not row by row: a joint does not gape, whatever the mass ratio, and
// loops are no special case. What acts along free axes (motors, springs, friction, limits) is
// applied through the group's response to it, the joints' reactions included, so that an axis feels
// the inertia it has in the mechanism.
//
// In time the joints are held as by SHAKE (Ryckaert, Ciccotti, Berendsen 1977): impulses along the
// directions at the start of the step such that the joints close at its end. With symplectic Euler
// this keeps the energy of a mechanism without loss.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "joint_group.h"
#include "joint_rows.h"
#include "small_matrix.h"

namespace cogrsim::bullet {

class ConstraintGroup final : public JointGroup {
 public:
  /// `joints`: those of the group, in an order in which neighbours are near each other.
  ConstraintGroup(const SceneModel& model, const std::vector<int>& joints,
                  std::vector<RigidBody>& bodies);

  /// Brings the bodies, where they are, to velocities that the joints marked in `sudden` (njoint)
  /// allow: the impulses of a perfectly plastic joining act through all joints of the group. What
  /// only the group holds keeps its momentum.
  void join(const SceneModel& model, const std::vector<char>& sudden);

  /// Rows and factorisation.
  void prepare(const SceneModel& model, double dt, const std::vector<Drive>& drives,
               const std::vector<double>& q) override;
  void bind(StepBodies& bodies) override;
  void iterate(StepBodies& bodies) override;
  /// Efforts and reactions of the step.
  void report(const SceneModel& model, double dt, JointReport& out) override;

 private:
  struct Member {
    RigidBody* body = nullptr;
    int index = -1;  ///< in the StepBodies
    Six start;       ///< velocity with this step's outer forces, without impulses
    Six delta;       ///< what impulses have changed
    Six v;           ///< velocity now
    btTransform then =
        btTransform::getIdentity();  ///< where free motion leads at the end of the step
    bool moves = false;              ///< dynamic
  };
  /// One row: on the child's (a) and the parent's (b) velocity; -1: the world.
  struct Row {
    int a = -1, b = -1;
    Six Ja, Jb;
    Six Ka, Kb;  ///< M^-1 J^T
  };
  struct JointSlot {
    int joint = -1;
    int a = -1, b = -1;      ///< members
    btTransform X_PF, X_CM;  ///< in the principal frames
    int first_row = 0, rows = 0;
    int first_open = 0;                    ///< first row this joint's rows may be coupled with
    std::vector<int> neighbours;           ///< earlier slots that share a moving body
    std::vector<std::vector<int>> motors;  ///< by axis
  };
  /// One free axis on which something acts.
  struct Axis {
    AxisPart part = AxisPart::whole;
    int slot = -1;
    int number = 0;           ///< of the joint's axes
    int speed = -1;           ///< entry in joint_speeds; of a ball: the first of three
    double q = 0.0;           ///< coordinate at the start of the step
    btVector3 in_F{0, 0, 0};  ///< of a ball: direction in F's axes
    Direction direction;
    Row row;
    AxisLaw law;
    std::vector<int> motors;  ///< of the law's first elements
    double inverse_inertia = 0.0;
    double impulse = 0.0;
    Eigen::VectorXd reaction;   ///< of the locked rows, per unit of impulse
    std::vector<Six> response;  ///< of the members' velocities, per unit of impulse
  };

  void fill_row(const JointSlot& slot, const btTransform& X_WM, const Direction& direction,
                Row& row) const;
  void factorise();
  /// Small groups have the inverse of J M^-1 J^T at hand: one step asks for about ten solutions.
  bool small() const;
  void invert();
  /// x := (J M^-1 J^T)^-1 x.
  void solve(Eigen::VectorXd& x) const;
  double along(const Row& row) const {
    Pair out = {};
    if (row.a >= 0) out += product(row.Ja, members_[static_cast<std::size_t>(row.a)].v);
    if (row.b >= 0) out += product(row.Jb, members_[static_cast<std::size_t>(row.b)].v);
    return sum(out);
  }
  /// J of one row times K of another.
  static double coupling(const Row& row, const Row& other) {
    Pair out = {};
    if (row.a >= 0) {
      if (row.a == other.a) out += product(row.Ja, other.Ka);
      if (row.a == other.b) out += product(row.Ja, other.Kb);
    }
    if (row.b >= 0) {
      if (row.b == other.a) out += product(row.Jb, other.Ka);
      if (row.b == other.b) out += product(row.Jb, other.Kb);
    }
    return sum(out);
  }
  void push(const Row& row, double impulse) {
    if (row.a >= 0) add_scaled(members_[static_cast<std::size_t>(row.a)].v, row.Ka, impulse);
    if (row.b >= 0) add_scaled(members_[static_cast<std::size_t>(row.b)].v, row.Kb, impulse);
  }
  void gather_axes(const Joint& joint, const JointSlot& slot, const btTransform& X_WF,
                   const btTransform& X_WM, const std::vector<Drive>& drives, const double* q);
  void gather_ball(const Joint& joint, const JointSlot& slot, const btTransform& X_WF,
                   const btTransform& X_WM, const double* q);
  void fill_law(const SceneModel& model, Axis& axis, double dt, const std::vector<Drive>& drives);
  Axis& next_axis(const JointSlot& slot, const btTransform& X_WM, const Direction& direction);
  void prepare_response(Axis& axis);
  void couple_axes();
  /// Brings all axes to their laws and takes what they gave through the group.
  void solve_axes();
  /// The impulses of two axes without bounds in play, at once; false: bounds or several elements are.
  bool solve_two_axes();

  std::vector<Member> members_;
  std::vector<JointSlot> slots_;
  std::vector<Row> rows_;
  std::vector<Direction> directions_;  ///< of the rows
  std::vector<int> first_;             ///< first column of each row of the factor
  /// Unit lower triangle, below the diagonal.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> factor_;
  Eigen::VectorXd inverse_diagonal_;
  SmallMatrix inverse_;     ///< of J M^-1 J^T, where the group is small
  Eigen::VectorXd target_;  ///< of J v at the end of the step
  Eigen::VectorXd impulses_, work_;
  std::vector<Axis> axes_;
  std::size_t axis_count_ = 0;
  /// What an impulse on one axis (column) changes of another's speed (row), by axis_count_.
  std::vector<double> between_axes_;
  std::vector<double> axis_speeds_, axis_changes_;  ///< of one iterate()
  bool solved_ = false;                             ///< for the velocities in `members_`
};

}  // namespace cogrsim::bullet
