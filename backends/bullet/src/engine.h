// A dynamics world of Bullet's with all that it points to, kept in step with a scene model.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletDynamics/ConstraintSolver/btConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolverInterface.h>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/hosted_world.h"
#include "constraint_joint.h"
#include "options.h"
#include "shapes.h"

namespace cogrsim::bullet {

/// What a rigid body of Bullet's has between steps.
struct Motion {
  btTransform X = btTransform::getIdentity();
  btVector3 velocity{0, 0, 0}, spin{0, 0, 0};  ///< of frame G
};

/// The impulse of one row of a joint on its second body in a step.
struct JointRow {
  btTypedConstraint* constraint;
  btVector3 linear, angular;
};
using JointRows = btAlignedObjectArray<JointRow>;

/// What a step is given. `efforts`: along the joints' speeds, or none; `twists`: of kinematic bodies,
/// by body.
struct StepInput {
  const std::vector<Drive>& drives;
  const std::vector<double>& efforts;
  const std::vector<Twist>& twists;
  const std::vector<Wrench>& external;
  std::function<const double*(int joint)> coordinates;  ///< of a joint now, turns counted
};

/// Everything that a step depends on; see Engine::save().
struct Memory : HostedMemory {
  SceneModelPtr model;
};

class Engine {
 public:
  /// The scene as it is in `state`. Errors: what Bullet cannot take, with its source position.
  static Result<std::unique_ptr<Engine>> create(const SceneModelPtr& model,
                                                const WorldState& state);
  ~Engine();

  const SceneModelPtr& model() const { return model_; }

  /// One stepSimulation(dt, 0). Returns the first body that has left all bounds, with everything back
  /// where it was before; -1: none.
  int step(double dt, const StepInput& input);
  /// Rotors that the solver's sweeps do not hold.
  std::vector<Diagnostic> warnings() const;

  Pose pose(int body) const;
  /// Of the body's origin; kinematic bodies excepted.
  Twist twist(int body) const;
  /// A bound for all bodies in the last step [rad/s].
  double fastest_spin() const { return fastest_spin_; }
  /// Moves everything; contacts are forgotten.
  void set_state(const WorldState& state);

  // Of the last step.
  void get_efforts(std::vector<double>& joints, std::vector<double>& motors) const;
  void get_reactions(std::vector<Wrench>& out) const;
  void get_contacts(std::vector<Contact>& out) const;

  /// What continuing needs: poses and velocities, the contact points with their impulses, the
  /// broadphase's boxes and pairs, and every ordering that the solver depends on.
  std::shared_ptr<const Memory> save() const;
  /// Into an engine that create() has just made: all of it where the memory is of the same model,
  /// else the contacts between bodies that both have.
  void restore(const Memory& memory);

 private:
  struct Part {
    std::unique_ptr<BodyShape> shape;
    std::unique_ptr<btRigidBody> rigid;
    Pose X_BG;
    bool centred = true;  // X_BG is the identity
    Pose pose;            // of what forces do not move
    btVector3 inertia{0, 0, 0};
  };

  Engine(const SceneModelPtr& model, Parameters options)
      : options_(std::move(options)), model_(model), surfaces_(std::make_unique<Surfaces>(model)) {}
  Result<> build(const WorldState& state);
  void make_world();
  void add_body(int body, const WorldState& state);
  void add_joint(int joint);
  struct FullMemory;
  void restore_broadphase(const FullMemory& memory);
  void restore_contacts(const FullMemory& memory, const std::vector<char>& stays);
  void forget_contacts();
  static Motion motion(const btRigidBody& body);
  static void set_motion(btRigidBody& body, const Motion& motion);

  btTransform frame_of(int body, const Pose& X_BF) const;
  btTransform start_of(int body) const;
  Motion motion_of(const Part& part, const Pose& X, const Twist& V) const;
  void sum_rows() const;

  const Parameters options_;
  SceneModelPtr model_;
  std::unique_ptr<Surfaces> surfaces_;
  std::unique_ptr<btDefaultCollisionConfiguration> configuration_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  std::unique_ptr<btDbvtBroadphase> broadphase_;
  std::unique_ptr<btMLCPSolverInterface> mlcp_;
  std::unique_ptr<btConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;

  std::unique_ptr<btRigidBody> ground_;                   // what joints of the world hold on to
  std::vector<Part> parts_;                               // by body
  std::vector<std::unique_ptr<ConstraintJoint>> joints_;  // in the order of the model

  int sweeps_ = -1;                      // over the rows of joints; -1: as many as over all
  bool sound_ = false;                   // no exception has left Bullet's world half changed
  std::vector<int> movers_, kinematic_;  // bodies: those that forces move; the others that move
  std::vector<Motion> before_;  // the last step, by body; kinematic ones, where it put them
  double dt_ = 0.0;             // of the last step [s]
  mutable JointRows rows_;      // of the last step; none: summed up in the joints
  double fastest_spin_ = 0.0;   // in it [rad/s]
};

}  // namespace cogrsim::bullet
