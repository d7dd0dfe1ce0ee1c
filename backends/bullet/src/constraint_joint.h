// A joint between rigid bodies as constraints of Bullet's.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <BulletDynamics/ConstraintSolver/btGeneric6DofConstraint.h>

#include "cogrsim/physics/engine_world.h"

class btDiscreteDynamicsWorld;

namespace cogrsim::bullet {

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
///
/// The inertia I of a rotor is a motor, too, towards the speed u of the axis when the step begins,
/// without a bound and as soft as that its effort is I (u - u+) / dt. Stiff laws of the same axis,
/// unless they may be at their bounds, are added to it: effort = sum K (v - u+) is one row.
///
/// A ball's axes are those of F on the parent, each a motor of its own.
///
/// Bullet's angles end at half a turn. Limits that are wider get their angles before each step from
/// the joint's coordinate, in which turns are counted.
class ConstraintJoint {
 public:
  /// `frame_a`, `frame_b`: the joint's F and M in Bullet's frames of the two bodies; `softness`:
  /// btContactSolverInfo::m_globalCfm.
  ConstraintJoint(const SceneModel& model, int joint, btRigidBody& a, btRigidBody& b,
                  const btTransform& frame_a, const btTransform& frame_b, double softness);

  /// Of all joints before anything else is made: Bullet's islands look through all constraints, for
  /// each of them, which is twice as fast where they lie side by side.
  void make_constraint();
  /// Axes, limits, and the rows of what acts along them.
  void make_laws(const SceneModel& model);

  int joint() const { return joint_; }
  /// `sweeps` over its rows, if more than those over all.
  void add_to(btDiscreteDynamicsWorld& world, int sweeps);

  /// Before a step. Coordinates are asked for where a law needs them.
  void apply(const StepInput& input);
  /// Of the axis: its rotor's inertia over that of the two bodies alone; 0 without a rotor.
  double rotor_ratio(std::size_t axis) const;

  /// Of the last step, on the child about M's origin, world axes; the body's place when the step
  /// began is `X_B`.
  Load get_reaction(const btTransform& X_B) const;
  void clear_loads();
  /// Efforts along the joint's speeds and of its motors (by model index) in the last step.
  void get_efforts(const btTransform& X_A, const btTransform& X_B, double* joint,
                   std::vector<double>& motors) const;

 private:
  enum class Kind { passive, friction, motor, rotor };
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
    double gain = 0.0, target = 0.0;  // K, v of what was added to the rotor's row; K = 0: nothing
  };
  struct Axis {
    btVector3 direction{0, 0, 0};  // in the child's frame or else the parent's
    bool on_child = false, angular = true;
    int dof = 5;  // of a btGeneric6DofConstraint
    JointAxis law;
    std::vector<Row> rows;  // a rotor's is the last
    bool wide = false;      // has limits beyond what Bullet's angles can be
  };

  void make_axes(const Joint& joint);
  void make_rows(const SceneModel& model);
  void set_limits();
  void set_limits(const Axis& axis, double lower, double upper);
  void set_wide_limits(const Axis& axis, double q);
  std::unique_ptr<btGeneric6DofConstraint> make_six() const;
  Extra* make_extra();
  void drive(const Axis& axis, Row& row, double dt, double velocity, double softness);
  void stop(const Axis& axis, Row& row);
  void apply_law(const Axis& axis, const btVector3& along, Row& row, const Drive& law, double dt,
                 double q, double u);
  void apply_rotor(Axis& axis, const btVector3& along, double dt, double u);
  void align_extras();
  void push(const btVector3& force, const btVector3& torque);

  btVector3 direction(const Axis& axis, const btTransform& X_A, const btTransform& X_B) const;
  double speed(const Axis& axis, const btVector3& along) const;
  double inverse_mass(const Axis& axis, const btVector3& along) const;

  int joint_, first_speed_;
  JointType type_;
  btRigidBody &a_, &b_;
  btTransform frame_a_, frame_b_;
  std::vector<Axis> axes_;
  std::unique_ptr<btTypedConstraint> main_;
  Load load_;
  std::vector<std::unique_ptr<Extra>> extras_;
  double softness_, stiff_ = 0.0;
  bool collide_, has_laws_ = false;
  Load explicit_;  // on the child at M, last step
};

}  // namespace cogrsim::bullet
