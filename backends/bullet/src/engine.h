// A dynamics world of Bullet's with all that it points to, kept in step with a scene model.
#pragma once

#include <memory>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolverInterface.h>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"
#include "cogrsim/physics/state.h"
#include "constraint_joint.h"
#include "options.h"
#include "shapes.h"
#include "tree.h"

class btMultiBodyDynamicsWorld;

namespace cogrsim::bullet {

/// What a rigid body of Bullet's has between steps.
struct Motion {
  btTransform X = btTransform::getIdentity();
  btVector3 velocity{0, 0, 0}, spin{0, 0, 0};  ///< of frame G
};

/// Everything that a step depends on, in the order of the model; see Engine::save().
struct Memory;

/// Where a scene begins.
WorldState initial_state(const SceneModel& model);

class Engine {
 public:
  /// The scene as it is in `state`. Errors: what Bullet cannot take, with its place.
  static Result<std::unique_ptr<Engine>> create(const SceneModelPtr& model, const Options& options,
                                                const WorldState& state);
  ~Engine();

  const SceneModelPtr& model() const { return model_; }

  /// One stepSimulation(dt, 0). `twists`: of kinematic bodies, by body. Returns the first body that
  /// has left all bounds, with everything back where it was before; -1: none.
  int step(double dt, const std::vector<Drive>& drives, const std::vector<Twist>& twists);

  Pose pose(int body) const;
  /// Of the body's origin; kinematic bodies excepted.
  Twist twist(int body) const;
  void get_joints(WorldState& out) const;
  /// Moves everything; contacts are forgotten.
  void set_state(const WorldState& state);

  // Of the last step, of length dt.
  void get_efforts(double dt, std::vector<double>& joints, std::vector<double>& motors) const;
  void get_reactions(std::vector<Wrench>& out) const;
  void get_contacts(double dt, std::vector<Contact>& out) const;

  /// What running on needs: places and velocities, the contact points with their impulses, the
  /// broadphase's boxes and pairs, and all orders that its solver goes by.
  std::shared_ptr<const Memory> save() const;
  /// Into an engine that create() has just made: all of it where the memory is of the same model,
  /// else the contacts between bodies that both have.
  void restore(const Memory& memory);

 private:
  struct Part {
    std::unique_ptr<BodyShape> shape;
    std::unique_ptr<btRigidBody> rigid;
    Tree* tree = nullptr;
    Pose X_BG;
    bool centred = true;  // X_BG is the identity
    Pose place;           // of what forces do not move
    btVector3 inertia{0, 0, 0};
  };

  Engine(const SceneModelPtr& model, const Options& options)
      : options_(options), model_(model), surfaces_(std::make_unique<Surfaces>(model)) {}
  Result<> build(const WorldState& state);
  void make_world(bool reduced);
  void add_body(int body, const WorldState& state);
  void add_tree(const TreePlan& plan, const WorldState& state);
  void add_joint(int joint);
  void set_ignored_pairs();
  void restore_broadphase(const Memory& memory);
  void restore_contacts(const Memory& memory);
  void list_movers();
  void forget_contacts();
  void set_motion(btRigidBody& body, const Motion& motion);

  btCollisionObject* object(int body) const;
  btTransform frame_of(int body, const Pose& X_BF) const;
  btTransform start_of(int body) const;
  Motion motion_of(const Part& part, const Pose& X, const Twist& V) const;
  void count_turns(int joint) const;
  void apply_joints(double dt, const std::vector<Drive>& drives);
  int find_diverged();

  Options options_;
  SceneModelPtr model_;
  std::unique_ptr<Surfaces> surfaces_;
  std::unique_ptr<btDefaultCollisionConfiguration> configuration_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  std::unique_ptr<btDbvtBroadphase> broadphase_;
  std::unique_ptr<btMLCPSolverInterface> mlcp_;
  std::unique_ptr<btConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  btMultiBodyDynamicsWorld* reduced_world_ = nullptr;  // the same, when there are trees

  std::unique_ptr<btRigidBody> ground_;  // what joints of the world hold on to
  std::vector<Part> parts_;              // by body
  std::vector<std::unique_ptr<Tree>> trees_;
  std::vector<std::unique_ptr<ConstraintJoint>> joints_;  // in the order of the model

  std::vector<int> movers_;  // rigid bodies that forces move
  std::vector<Motion> now_, before_;
  std::vector<std::vector<double>> trees_before_;
  mutable std::vector<double> positions_;  // of joints, turns counted
  mutable double turned_ = 0.0;            // bound of what has not been counted [rad]
};

}  // namespace cogrsim::bullet
