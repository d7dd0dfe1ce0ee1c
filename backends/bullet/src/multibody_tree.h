// The tree of bodies of an articulated group as one btMultiBody: kinematics both ways, and what the
// articulated-body algorithm (Featherstone 2008, chapter 7) gives in linear time.
//
// Vectors of speeds are laid out as Bullet does: base angular and linear velocity (zero where the
// base stands still), then the speeds of the joints. A ball's three speeds are in the axes of the
// link it carries. Joints of more than one axis are strings of links without mass.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <BulletDynamics/Featherstone/btMultiBody.h>

#include "rigid_body.h"

#include "cogrsim/model/scene_model.h"

namespace cogrsim::bullet {

/// Velocity of a link's centre of mass, or force there with the torque about it; world axes.
struct LinkVector {
  btVector3 lin{0, 0, 0};
  btVector3 ang{0, 0, 0};
};

/// One joint of the scene within the tree.
struct TreeJoint {
  int joint = -1;
  JointType type = JointType::fixed;
  bool reversed = false;     ///< the tree goes from the joint's child to its parent
  int from = -1;             ///< link, -1: base
  int to = -1;               ///< link of the body it carries
  int first = 0;             ///< first of its speeds
  int count = 0;             ///< of its speeds
  btTransform X_from, X_to;  ///< the joint's frames in the two links' principal frames
  /// Entry in the speeds of the joint's speed k, unless a ball.
  int speed(int k) const { return order[k]; }
  int order[3] = {0, 0, 0};
};

class MultibodyTree {
 public:
  /// What keeps `joints` from being one tree of joints that a btMultiBody has; "" when nothing
  /// does. `culprit`: the joint in question.
  static std::string obstacle(const SceneModel& model, const std::vector<int>& joints,
                              int& culprit);

  /// Precondition: no obstacle.
  MultibodyTree(const SceneModel& model, const std::vector<int>& joints,
                std::vector<RigidBody>& bodies);

  bool floating() const { return base_ >= 0; }
  const std::vector<TreeJoint>& joints() const { return joints_; }
  /// Scene bodies of the tree, and the link of each (-1: base).
  const std::vector<int>& bodies() const { return bodies_; }
  const std::vector<int>& links() const { return body_links_; }
  int speed_count() const { return 6 + multibody_->getNumDofs(); }
  /// Links and the base.
  std::size_t frame_count() const { return frames_.size(); }

  /// Takes over coordinates (of the whole world) and the base's place.
  void set_positions(const std::vector<double>& q, const btTransform& X_WBase);
  /// Principal frame of a link, -1: base.
  const btTransform& frame(int link) const { return frames_[static_cast<std::size_t>(link + 1)]; }
  /// M's origin.
  btVector3 origin(const TreeJoint& joint) const;
  /// Child's frame M and parent's frame F of the scene's joint.
  btTransform X_WM(const TreeJoint& joint) const;
  btTransform X_WF(const TreeJoint& joint) const;

  /// Velocities of all links (entry 0: base) that go with speeds `u`.
  void velocities(const std::vector<double>& u, std::vector<LinkVector>& out) const;
  /// The speeds that go with velocities of the bodies' links.
  void speeds(const std::vector<LinkVector>& links, std::vector<double>& out) const;
  /// Efforts along the speeds that forces on all links come to. `forces` is used up.
  void project(std::vector<LinkVector>& forces, std::vector<double>& out) const;

  /// Accelerations at speeds `u` under gravity alone; prepares respond().
  void accelerations(const std::vector<double>& u, std::vector<double>& out);
  /// Forces that keep every link on its way at speeds `u` without accelerations of the speeds
  /// (Coriolis, centrifugal, gyroscopic), as efforts along the speeds.
  void bias(const std::vector<double>& u, std::vector<double>& out);
  /// Change of speeds per impulses along them.
  void respond(const std::vector<double>& impulses, std::vector<double>& out);

  /// q + dt u, for joints (in the world's array) and the base.
  void advance(const std::vector<double>& u, double dt, std::vector<double>& q,
               btTransform& X_WBase) const;

 private:
  struct Dof {
    btVector3 lin, ang;  ///< velocity of the link's centre of mass per speed, world axes
    bool turns = true;
  };

  void add_joint(const TreeJoint& joint, const RigidBody& body, int& link);
  void update_frames();

  int base_ = -1;  ///< scene body that is the base
  std::vector<int> bodies_, body_links_;
  std::vector<TreeJoint> joints_;
  std::vector<int> position_offsets_;  ///< of joints_ in the world's coordinates
  std::unique_ptr<btMultiBody> multibody_;
  std::vector<int> parents_, first_dof_;  ///< by link; first_dof_ has one more
  std::vector<Dof> dofs_;
  std::vector<btTransform> frames_;
  bool placed_ = false;         ///< frames_ are those of the coordinates
  std::vector<double> masses_;  ///< by link, the base first
  std::vector<btVector3> moments_;
  std::vector<LinkVector> velocities_, rates_, forces_;
  btAlignedObjectArray<btScalar> scratch_r_;
  btAlignedObjectArray<btVector3> scratch_v_;
  btAlignedObjectArray<btMatrix3x3> scratch_m_;
};

}  // namespace cogrsim::bullet
