// An articulated group in reduced coordinates: its joints' coordinates are what moves, its bodies
// follow. Joints cannot gape.
//
// Contacts see the bodies as single rigid bodies; iterate() takes the impulses they left there
// through the tree (btMultiBody's articulated-body algorithm, linear time) and gives the bodies the
// motion that the joints allow. Axes are felt through the response of the whole tree to them.
//
// In time: symplectic Euler on the coordinates. What depends on velocities (Coriolis and
// centrifugal terms) is taken at the middle of the step: taken at its start, as Bullet does, it
// feeds energy in the first order of the step, and a long chain that whips explodes. The middle is
// found from the accelerations at the start, and from what contacts and axes did in the last two
// steps: the lesser of the two, nothing where they disagree in sign, so that a blow is not taken
// for a trend.
#pragma once

#include <array>

#include "joint_group.h"
#include "joint_rows.h"
#include "multibody_tree.h"

namespace cogrsim::bullet {

class ReducedGroup final : public JointGroup {
 public:
  /// Precondition: MultibodyTree::obstacle() finds none.
  ReducedGroup(const SceneModel& model, const std::vector<int>& joints,
               std::vector<RigidBody>& bodies);

  void prepare(const SceneModel& model, double dt, const std::vector<Drive>& drives,
               const std::vector<double>& q) override;
  void bind(StepBodies& bodies) override;
  void iterate(StepBodies& bodies) override;
  void report(const SceneModel& model, double dt, JointReport& out) override;

  bool moves_bodies() const override { return true; }
  void move(double dt, const std::vector<std::pair<btVector3, btVector3>>& extra,
            std::vector<double>& q) override;
  void find_reactions(const SceneModel& model, std::vector<Wrench>& out) const override;
  std::vector<double> memory() const override;
  void set_memory(const std::vector<double>& memory) override;

 private:
  struct Member {
    RigidBody* body = nullptr;
    int link = -1;
    int index = -1;            ///< in the StepBodies
    LinkVector start;          ///< velocity the solver began with, outer forces included
    LinkVector written;        ///< change of velocity that stands in the solver's body
    LinkVector before;         ///< momentum and angular momentum at the start of the step
    LinkVector blow;           ///< impulse of contacts in this step
    btVector3 place{0, 0, 0};  ///< at the start of the step
  };
  struct JointSlot {
    std::vector<std::vector<int>> motors;  ///< by axis
    btVector3 at{0, 0, 0};                 ///< M's origin at the start of the step
  };
  /// One free axis on which something acts.
  struct Axis {
    AxisPart part = AxisPart::whole;
    int tree_joint = -1;
    int number = 0;            ///< of the joint's axes
    double q = 0.0;            ///< coordinate at the start of the step
    btVector3 in_F{0, 0, 0};   ///< of a ball
    int first = 0, count = 1;  ///< its speeds in the tree
    double weight[3] = {1.0, 0.0, 0.0};
    AxisLaw law;
    std::vector<int> motors;  ///< of the law's first elements
    double inverse_inertia = 0.0, impulse = 0.0;
    std::vector<double> response;  ///< change of all speeds per impulse
  };

  double along(const Axis& axis, const std::vector<double>& u) const;
  Axis& next_axis(int tree_joint);
  void gather_axes(const SceneModel& model, const std::vector<Drive>& drives,
                   const std::vector<double>& q);
  void gather_ball(const Joint& joint, int tree_joint, const double* q);
  void fill_law(const SceneModel& model, Axis& axis, double dt, const std::vector<Drive>& drives);
  void solve_axes();
  LinkVector momentum(const Member& member, const LinkVector& v) const;
  /// Gives a tree that floats the momentum it had and what contacts and gravity added: at its new
  /// place the old speeds would come to a little more or less.
  void keep_momentum();

  MultibodyTree tree_;
  std::vector<Member> members_;
  std::vector<JointSlot> slots_;  ///< of tree_.joints()
  std::vector<Axis> axes_;
  std::size_t axis_count_ = 0;
  std::vector<double> u_start_, u_;  ///< speeds: at the start of the step, now
  std::vector<double> free_;         ///< accelerations without contacts and axes
  /// Accelerations by contacts and axes in the last step and the one before.
  std::array<std::vector<double>, 2> past_;
  std::vector<double> impulses_, response_, work_;
  std::vector<LinkVector> links_, forces_;
  bool solved_ = false;
  double dt_ = 0.0;
  btVector3 gravity_{0, 0, 0};
};

}  // namespace cogrsim::bullet
