// The scene's joints as joints of ODE's, with what acts along their axes.
#pragma once

#include <ode/ode.h>

#include <array>
#include <deque>
#include <vector>

#include "body.h"

namespace cogrsim::ode {

/// Mean efforts of the last step.
struct JointReport {
  double* joint_efforts = nullptr;  ///< of this joint's first speed
  double* motor_efforts = nullptr;  ///< SceneModel::motors
  Wrench* reaction = nullptr;       ///< on the child, about M's origin, world axes
};

/// One joint of the scene: a joint of ODE's (of a planar one two). The first law of each axis
/// without stops is the joint's own motor, any other one an AMotor or LMotor beside it: at a stop
/// ODE's own motors push with all they have, whichever way they are asked to run.
///
/// The inertia I of a rotor is a motor towards the speed u of the axis when the step begins, without a
/// bound: u1 = u - cfm effort with cfm = h / I.
///
/// ODE's angles end at half a turn. Limits that are wider, and single ones, get ODE's angles before
/// each step, from the coordinate in which turns are counted.
class JointLink {
 public:
  /// Bodies are where the scene has them at its start; they are moved here and left elsewhere.
  JointLink(dWorldID world, const SceneModel& model, int joint, const JointEnd& parent,
            const JointEnd& child, double cfm);
  JointLink(const JointLink&) = delete;
  JointLink& operator=(const JointLink&) = delete;

  const Joint& joint() const { return *joint_; }
  int index() const { return index_; }
  /// Sets the motors for the next step and adds what no motor carries to the bodies' forces. Coordinates
  /// are asked for where a law needs them.
  void drive(const StepInput& input);
  /// By axis: the rotor's inertia over that of the two bodies alone.
  std::vector<double> rotor_ratios() const;
  /// Of the two bodies alone along a speed [1/(kg m^2)], [1/kg].
  double mobility(int speed) const;
  /// After a step of `h`.
  void report(double h, const JointReport& out) const;

 private:
  /// One law along one speed.
  struct Law {
    int speed = 0;
    int drive = -1;       ///< SceneModel::motors; -1: of the axis itself
    bool spring = false;  ///< of the axis; has no motor
    bool rotor = false;
    bool own = false;  ///< the motor of the joint itself
    dJointID id = nullptr;
    int group = 0;  ///< dParamGroup of the axis
    dJointFeedback feedback{};
    std::array<double, 3> motor{};  ///< as ODE has it: speed, bound (0: none), cfm
    double applied = 0.0;           ///< what is added as a force
    double least = 0.0;             ///< cfm
  };

  void make(dWorldID world, const Pose& X_WF, const Pose& X_WM);
  void make_planar(dWorldID world, const Pose& X_WF, const Pose& X_WM);
  void add_laws(dWorldID world, const SceneModel& model, int joint, const Pose& X_WF,
                const Pose& X_WM);
  Law& add_law(dWorldID world, int speed, bool own, const Vec3& direction);
  int group_of(int speed) const;
  bool turns(int speed) const;
  dJointID attached(dJointID id, dJointFeedback& feedback) const;
  int relative_to_parent() const;
  /// Direction of a speed, given F and M.
  Vec3 direction(int speed, const Pose& X_WF, const Pose& X_WM) const;
  void set(Law& law, double velocity, double bound, double cfm) const;
  void set(Law& law, const Drive& drive, const StepInput& input) const;
  void velocities(const double* q, double* u) const;
  void push(int speed, double effort) const;
  double stop_angle(int axis) const;
  void set_wide_stops(const double* q) const;

  const Joint* joint_ = nullptr;
  int index_ = -1;                            ///< SceneModel::joints
  JointEnd parent_, child_, first_, second_;  ///< second_: nothing for what is immovable
  double sign_ = 1.0;                         ///< -1: first_ is the parent
  double cfm_;                                ///< of the world
  dJointID id_ = nullptr;                     ///< nullptr: nothing that forces could move
  dJointID normal_ = nullptr;                 ///< of a planar joint
  dJointFeedback feedback_{}, normal_feedback_{};
  std::deque<Law> laws_;
  std::array<double, 6> pushed_{};  ///< efforts from outside in the last step
  bool wide_ = false, has_rotor_ = false;
};

}  // namespace cogrsim::ode
