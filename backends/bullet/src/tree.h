// Bodies and joints in reduced coordinates: one btMultiBody.
#pragma once

#include <memory>
#include <vector>

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/state.h"
#include "convert.h"
#include "laws.h"
#include "options.h"

class btMultiBodyDynamicsWorld;
class btMultiBodyJointLimitConstraint;
class btMultiBodyJointMotor;

namespace cogrsim::bullet {

/// What becomes one btMultiBody.
struct TreePlan {
  int root = kWorld;        ///< body that floats; kWorld: hangs on the world or a static body
  std::vector<int> bodies;  ///< without the ground, by index
  std::vector<int> joints;  ///< each after the one of its parent
};

/// Which bodies are to be in reduced coordinates. Errors: an assembly that asks for it has joints
/// that a btMultiBody lacks, or is joined to one that asks for constraints; with the place.
Result<std::vector<TreePlan>> plan_trees(const SceneModel& model, const Options& options);

/// Also keeps apart what a btMultiBody alone would let touch: ends of universal joints and the like.
class LinkCollider final : public btMultiBodyLinkCollider {
 public:
  using btMultiBodyLinkCollider::btMultiBodyLinkCollider;
  bool checkCollideWithOverride(const btCollisionObject* other) const override {
    return btCollisionObject::checkCollideWithOverride(other) &&
           btMultiBodyLinkCollider::checkCollideWithOverride(other);
  }
};

/// Where a body is, what it is made of and how it moves, as Bullet sees it: frame G.
struct LinkBody {
  Pose X_BG, X_WB;
  btVector3 inertia;
  btCollisionShape* shape = nullptr;
  bool collides = false;
};

class Tree {
 public:
  /// `bodies`: by model index. Links get collision objects when one of them collides or a joint
  /// has a motor, friction or a limit: Bullet finds the islands of these by them.
  Tree(const SceneModelPtr& model, TreePlan plan, const std::vector<LinkBody>& bodies,
       void* user_pointer);
  ~Tree();

  const TreePlan& plan() const { return plan_; }
  btMultiBody& multibody() { return *multibody_; }
  void add_to(btMultiBodyDynamicsWorld& world, const std::vector<LinkBody>& bodies);
  void remove_from(btMultiBodyDynamicsWorld& world);
  /// Of a body; nullptr: none.
  LinkCollider* collider(int body) const;
  /// Where collider(body) was when the last step began.
  const btTransform& detected(int body) const { return detected_[at(link_of_[at(body)] + 1)]; }
  /// In the order in which add_to() adds them.
  std::vector<btMultiBodyConstraint*> constraints() const;

  /// `state` with joints' coordinates; the root's place is that of frame G.
  void set_state(const WorldState& state, const btTransform& X_WR, const btVector3& velocity,
                 const btVector3& spin);
  btTransform place(int body) const;
  void get_velocity(int body, btVector3& velocity, btVector3& spin) const;

  void apply(double dt, const std::vector<Drive>& drives);
  void get_efforts(double dt, std::vector<double>& joints, std::vector<double>& motors) const;
  /// Bodies' coordinates are finite and within bounds.
  bool is_sound() const;
  double fastest() const;

  /// All that moves, as numbers.
  void save(std::vector<double>& out) const;
  void restore(const std::vector<double>& saved);

 private:
  struct Law {
    int link;
    JointAxis law;
    int motor;  // of the model; -1: spring, damper and friction
    std::unique_ptr<btMultiBodyJointMotor> row;
    std::unique_ptr<btMultiBodyJointLimitConstraint> limit;
    double effort;
  };

  void add_link(int link, int parent, const Pose& X_PF, const Pose& X_CM, const btVector3& inertia);
  void add_laws();
  void note_places();
  void refresh() const;

  SceneModelPtr model_;
  TreePlan plan_;
  std::unique_ptr<btMultiBody> multibody_;
  std::vector<std::unique_ptr<LinkCollider>> colliders_;  // of the base, then by link
  std::vector<btTransform> detected_;
  std::vector<int> link_of_;  // by model body; -2: not here
  std::vector<Law> laws_;
  int links_ = 0;
  mutable bool fresh_ = false;  // places and velocities of links are up to date
  mutable btAlignedObjectArray<btQuaternion> turns_;
  mutable btAlignedObjectArray<btVector3> origins_, spins_, velocities_;  // in links' axes
};

}  // namespace cogrsim::bullet
