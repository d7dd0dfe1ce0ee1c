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

#include "cogrsim/physics/engine_world.h"
#include "constraint_joint.h"
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

class Engine final : public SceneEngine {
 public:
  static constexpr const char *kName = "bullet", *kTitle = "Bullet";
  static constexpr bool kLacksCouplings = true, kHoldsTwists = false, kRestoresInPlace = false;
  /// By Bullet's names and with its defaults.
  static const ParameterTable& options();

  /// Errors: a shape that Bullet cannot take, with its source position.
  static Result<std::unique_ptr<Engine>> make(const SceneModelPtr& model, const Parameters& options,
                                              const WorldState& begin, const Engine* old);
  /// The contacts between bodies that both have.
  void take_over(const Engine& old, const WorldState&, const SceneChange&) { restore(*old.save()); }
  ~Engine();

  /// One stepSimulation(dt, 0).
  void step(const StepInput& input);
  int find_lost() const;
  bool undo();
  /// Rotors that the solver's sweeps do not hold.
  std::vector<Diagnostic> warnings() const;

  Pose pose(int body) const;
  Twist twist(int body) const;
  double fastest_spin() const;
  void write(const WorldState& state);
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const;
  void read_reactions(std::vector<Wrench>& out) const;
  void read_contacts(std::vector<Contact>& out) const;

  /// What continuing needs: poses and velocities, the contact points with their impulses, the
  /// broadphase's boxes and pairs, and every ordering that the solver depends on.
  std::shared_ptr<const HostedMemory> save() const;
  /// Into an engine that has just been made: all of it where the memory is of the same model, else the
  /// contacts between bodies that both have.
  void restore(const HostedMemory& memory);

 private:
  struct Part {
    std::unique_ptr<BodyShape> shape;
    std::unique_ptr<btRigidBody> rigid;
    Pose X_BG;
    bool centred = true;  // X_BG is the identity
    Pose pose;            // of what forces do not move
    Pose before;          // the same of kinematic ones, before the last step
    btVector3 inertia{0, 0, 0};
  };

  explicit Engine(const SceneModelPtr& model)
      : model_(model), surfaces_(std::make_unique<Surfaces>(model)) {}
  Result<> build(const Parameters& options, const WorldState& state);
  void make_world(const Parameters& options);
  void make_body(int body, const WorldState& state);
  void add_body(int body);
  void make_joint(int joint, double cfm);
  struct Memory;
  void restore_broadphase(const Memory& memory);
  void restore_contacts(const Memory& memory, const std::vector<char>& stays);
  void forget_contacts();
  static Motion motion(const btRigidBody& body);
  static void set_motion(btRigidBody& body, const Motion& motion);

  btTransform frame_of(int body, const Pose& X_BF) const;
  btTransform start_of(int body) const;
  Motion motion_of(const Part& part, const Pose& X, const Twist& V) const;
  void sum_rows() const;

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
  double driven_spin_ = 0.0;    // of kinematic bodies in it [rad/s]
};

}  // namespace cogrsim::bullet
