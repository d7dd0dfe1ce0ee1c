// A joint between rigid bodies as constraints of Bullet's.
#pragma once

#include <memory>
#include <vector>

#include <BulletDynamics/ConstraintSolver/btGeneric6DofSpring2Constraint.h>

#include "cogrsim/model/scene_model.h"
#include "laws.h"

class btDiscreteDynamicsWorld;

namespace cogrsim::bullet {

/// | joint | constraint |
/// |---|---|
/// | hinge, fixed, ball | btHinge, btFixed, btPoint2PointConstraint |
/// | slider, universal, cylindrical, planar | btGeneric6DofSpring2Constraint, order ZYX |
///
/// Limits are the constraint's. The first motor of an axis is the constraint's own; further
/// motors, dry friction (a motor towards rest, bounded by the friction) and stiff springs and
/// dampers are btGeneric6DofSpring2Constraints whose one row is that motor. Soft laws are forces
/// and torques before the step, see AxisLaw.
class ConstraintJoint {
 public:
  /// `frame_a`, `frame_b`: of the joint's F and M in Bullet's frames of the two bodies.
  ConstraintJoint(const SceneModel& model, int joint, btRigidBody& a, btRigidBody& b,
                  const btTransform& frame_a, const btTransform& frame_b);
  ~ConstraintJoint();

  int joint() const { return joint_; }
  void add_to(btDiscreteDynamicsWorld& world);
  void remove_from(btDiscreteDynamicsWorld& world);
  /// In the order in which add_to() adds them.
  std::vector<btTypedConstraint*> constraints() const;

  /// Whether something acts along an axis, so that apply() must be called.
  bool has_laws() const { return has_laws_; }
  /// Whether apply() reads the joint's coordinates.
  bool needs_position(const std::vector<Drive>& drives) const;
  /// Before a step; `q` (position_count) are the joint's coordinates.
  void apply(double dt, const std::vector<Drive>& drives, const double* q);

  /// Of the last step, on the child about M's origin, world axes; the body's place when the step
  /// began is `X_B`.
  void get_reaction(const btTransform& X_B, btVector3& force, btVector3& torque) const;
  /// Efforts along the joint's speeds and of its motors (by model index) in the last step.
  void get_efforts(const btTransform& X_A, const btTransform& X_B, double* joint,
                   std::vector<double>& motors) const;

 private:
  enum class Kind { passive, friction, motor };
  /// A constraint whose rows are motors only.
  struct Extra {
    std::unique_ptr<btGeneric6DofSpring2Constraint> constraint;
    btJointFeedback feedback;
  };
  struct Row {
    Kind kind = Kind::motor;
    int motor = -1;          // SceneModel::motors
    Extra* extra = nullptr;  // none: the main constraint's motor
    bool on = false;
    double effort = 0.0;  // explicit, in the last step
    double bound = 0.0;
  };
  struct Axis {
    btVector3 direction{0, 0, 0};  // in the child's frame or else the parent's
    bool on_child = false, angular = true;
    int dof = 5;  // of a btGeneric6DofSpring2Constraint
    JointAxis law;
    std::vector<Row> rows;
  };

  void make_axes(const Joint& joint);
  void make_rows(const SceneModel& model);
  void set_limits(const double* q);
  void set_window(const Axis& axis, double lower, double upper);
  Extra* make_extra();
  void drive(const Axis& axis, Row& row, double dt, double velocity, double softness);
  void stop(const Axis& axis, Row& row);
  void apply_law(const Axis& axis, Row& row, const AxisLaw& law, double dt, double q, double u);
  void push(const btVector3& force, const btVector3& torque);

  btVector3 direction(const Axis& axis, const btTransform& X_A, const btTransform& X_B) const;
  double speed(const Axis& axis, const btVector3& along) const;
  double inverse_mass(const Axis& axis, const btVector3& along) const;
  double slant(const Axis& axis) const;

  int joint_;
  JointType type_;
  btRigidBody &a_, &b_;
  btTransform frame_a_, frame_b_;
  std::vector<Axis> axes_;
  std::unique_ptr<btTypedConstraint> main_;
  btJointFeedback feedback_;
  std::vector<std::unique_ptr<Extra>> extras_;
  bool has_laws_ = false, turning_limits_ = false, collide_ = false;
  btVector3 force_{0, 0, 0}, torque_{0, 0, 0};  // explicit, on the child at M, last step
};

}  // namespace cogrsim::bullet
