// The scene's bodies and joints as DART's skeletons.
#pragma once

#include <algorithm>
#include <array>
#include <dart/constraint/WeldJointConstraint.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/Joint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/state.h"
#include "convert.h"

namespace cogrsim::dart_engine {

/// What holds a body: a free joint, or the scene's joint as joints of DART's. One with several axes is a
/// row of joints with one freedom each, with bodies without mass between them; where the tree comes from
/// the scene's child it is that row from its other end, the axes turned round, so that the coordinates
/// are the scene's.
struct Link {
  int body = -1;   ///< SceneModel::bodies
  int joint = -1;  ///< SceneModel::joints; -1: it moves freely
  bool reversed = false, slave = false, kinematic = false;
  dart::dynamics::BodyNode* node = nullptr;    ///< its frame is that of the scene's body
  std::vector<dart::dynamics::Joint*> joints;  ///< by axis of the scene; else the one there is

  bool same_as(const Link& other) const {
    return body == other.body && joint == other.joint && reversed == other.reversed &&
           slave == other.slave;
  }
};

/// DART's weld, with softness in every row beside its own, which is relative: along what the joints of a
/// loop hold anyway its matrix is zero. The impulses of the last step, from which the next one starts, can
/// be saved.
class LoopWeld final : public dart::constraint::WeldJointConstraint {
 public:
  using WeldJointConstraint::WeldJointConstraint;
  int joint = -1;  ///< SceneModel::joints
  std::array<double, 6> impulses{};

 private:
  void getInformation(dart::constraint::ConstraintInfo* info) override {
    WeldJointConstraint::getInformation(info);
    std::copy(impulses.begin(), impulses.end(), info->x);
  }
  void applyImpulse(double* lambda) override {
    std::copy(lambda, lambda + 6, impulses.begin());
    WeldJointConstraint::applyImpulse(lambda);
  }
  void applyUnitImpulse(std::size_t index) override {
    row_ = index;
    WeldJointConstraint::applyUnitImpulse(index);
  }
  void getVelocityChange(double* change, bool with_cfm) override {
    constexpr double kLeast = 1e-9, kRelative = 1e-8;
    WeldJointConstraint::getVelocityChange(change, with_cfm);
    if (with_cfm) change[row_] += kLeast + kRelative * change[row_];
  }
  std::size_t row_ = 0;
};

/// What DART holds of a link between steps, to the bit.
using Motion = std::vector<Eigen::VectorXd>;  ///< positions and velocities, joint by joint

class Trees {
 public:
  /// `poses` has those of static bodies. A joint that closes a loop holds a part of its body, which
  /// is welded to the rest (WeldJointConstraint).
  Trees(const SceneModel& model, const std::vector<Pose>& poses);

  const std::vector<dart::dynamics::SkeletonPtr>& skeletons() const { return skeletons_; }
  const std::vector<std::shared_ptr<LoopWeld>>& welds() const { return welds_; }
  const std::vector<Link>& links() const { return links_; }
  /// Of static bodies, too; nullptr: removed.
  dart::dynamics::BodyNode* node(int body) const { return nodes_[body]; }
  /// -1: none.
  int link_of_body(int body) const { return body_links_[body]; }
  int link_of_joint(int joint) const { return joint_links_[joint]; }

  void set_free(const Link& link, const Pose& X_WB, const Twist& V_WB) const;
  void set_joint(const Link& link, const double* q, const double* u) const;
  void get_joint(const Link& link, double* q, double* u) const;
  void set_all(const WorldState& state) const;

  static Motion motion(const Link& link);
  static void set_motion(const Link& link, const Motion& motion);

  /// A plastic impact of the trees with these bodies: of all velocities that their joints allow those
  /// with the momentum that the twists of `seen` have, by DART's mass matrix and Jacobians.
  void take_impact(const WorldState& seen, const std::vector<int>& bodies) const;

 private:
  dart::dynamics::SkeletonPtr add_skeleton(const std::string& name);
  void add_static(int body, const Pose& pose);
  void add_free(int body);
  void add_link(Link link, int inboard, const std::vector<Pose>& poses);
  void close_loop(int joint, const std::vector<Pose>& poses);
  dart::dynamics::Inertia inertia(int body) const;
  const Joint& joint_of(const Link& link) const { return model_->joints[link.joint]; }

  const SceneModel* model_;
  std::vector<dart::dynamics::SkeletonPtr> skeletons_;
  std::vector<std::shared_ptr<LoopWeld>> welds_;
  std::vector<Link> links_;
  std::vector<dart::dynamics::BodyNode*> nodes_;
  std::vector<int> body_links_, joint_links_, parts_;  ///< parts: into how many a body is cut
};

}  // namespace cogrsim::dart_engine
