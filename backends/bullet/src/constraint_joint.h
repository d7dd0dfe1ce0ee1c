// A joint between rigid bodies as constraints of Bullet's.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include <BulletDynamics/ConstraintSolver/btGeneric6DofConstraint.h>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"

class btDiscreteDynamicsWorld;

namespace cogrsim::bullet {

inline constexpr double kWidestLimits = 6.2;  ///< of an angle, apart [rad]

/// What a constraint of Bullet's did to its second body in the last step; its user pointer.
struct Load {
  btVector3 force{0, 0, 0}, torque{0, 0, 0};
};

/// | joint | constraint |
/// |---|---|
/// | hinge, fixed, ball | btHinge, btFixed, btPoint2PointConstraint |
/// | slider, universal, cylindrical, planar | btGeneric6DofConstraint |
///
/// Limits are the constraint's. The first motor of an axis is the constraint's own; further
/// motors, dry friction (a motor towards rest, bounded by the friction) and stiff springs and
/// dampers are btGeneric6DofConstraints whose one row is that motor. Soft laws are forces
/// and torques before the step, see apply_law().
class ConstraintJoint {
 public:
  /// `frame_a`, `frame_b`: the joint's F and M in Bullet's frames of the two bodies; `softness`:
  /// btContactSolverInfo::m_globalCfm.
  ConstraintJoint(const SceneModel& model, int joint, btRigidBody& a, btRigidBody& b,
                  const btTransform& frame_a, const btTransform& frame_b, double softness);

  int joint() const { return joint_; }
  void add_to(btDiscreteDynamicsWorld& world);

  /// Whether something acts along an axis, so that apply() must be called.
  bool has_laws() const { return has_laws_; }
  /// Before a step; `position` gives the joint's coordinates, and is asked where a law needs them.
  void apply(double dt, const std::vector<Drive>& drives,
             const std::function<const double*()>& position);

  /// Of the last step, on the child about M's origin, world axes; the body's place when the step
  /// began is `X_B`.
  Load get_reaction(const btTransform& X_B) const;
  void clear_loads();
  /// Efforts along the joint's speeds and of its motors (by model index) in the last step.
  void get_efforts(const btTransform& X_A, const btTransform& X_B, double* joint,
                   std::vector<double>& motors) const;

 private:
  enum class Kind { passive, friction, motor };
  /// A constraint whose rows are motors only.
  struct Extra {
    std::unique_ptr<btGeneric6DofConstraint> constraint;
    Load load;
  };
  struct Row {
    Kind kind = Kind::motor;
    int motor = -1;          // SceneModel::motors
    Extra* extra = nullptr;  // none: the main constraint's motor
    bool on = false;
    double effort = 0.0;            // explicit, in the last step
    std::array<double, 4> given{};  // what Bullet's motor has: speed, bound, dt, softness
    double bound = 0.0;
  };
  struct Axis {
    btVector3 direction{0, 0, 0};  // in the child's frame or else the parent's
    bool on_child = false, angular = true;
    int dof = 5;  // of a btGeneric6DofConstraint
    JointAxis law;
    std::vector<Row> rows;
  };

  void make_axes(const Joint& joint);
  void make_rows(const SceneModel& model);
  void set_limits();
  std::unique_ptr<btGeneric6DofConstraint> make_six() const;
  Extra* make_extra();
  void drive(const Axis& axis, Row& row, double dt, double velocity, double softness);
  void stop(const Axis& axis, Row& row);
  void apply_law(const Axis& axis, Row& row, const Drive& law, double dt, double q, double u);
  void push(const btVector3& force, const btVector3& torque);

  btVector3 direction(const Axis& axis, const btTransform& X_A, const btTransform& X_B) const;
  double speed(const Axis& axis, const btVector3& along) const;
  double inverse_mass(const Axis& axis, const btVector3& along) const;

  int joint_;
  JointType type_;
  btRigidBody &a_, &b_;
  btTransform frame_a_, frame_b_;
  std::vector<Axis> axes_;
  std::unique_ptr<btTypedConstraint> main_;
  Load load_;
  std::vector<std::unique_ptr<Extra>> extras_;
  double softness_;
  bool has_laws_ = false, collide_ = false;
  Load explicit_;  // on the child at M, last step
};

}  // namespace cogrsim::bullet
