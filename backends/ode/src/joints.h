// The scene's joints as joints of ODE's, with what acts along their axes.
#pragma once

#include <ode/ode.h>

#include <deque>
#include <vector>

#include "body.h"
#include "cogrsim/core/result.h"
#include "cogrsim/physics/drive.h"
#include "options.h"

namespace cogrsim::ode {

/// Errors: joints, stops and motors that ODE does not know and capabilities cannot say.
Result<> check_joints(const SceneModel& model);

/// Mean efforts of the last step.
struct JointReport {
  double* joint_efforts = nullptr;  ///< of this joint's first speed
  double* motor_efforts = nullptr;  ///< SceneModel::motors
  Wrench* reaction = nullptr;       ///< on the child, about M's origin, world axes
};

/// One joint of the scene: a joint of ODE's (of a planar one two), whose own motor carries the first
/// speed source or the dry friction of each axis, and motor joints that carry all else.
class JointLink {
 public:
  /// Bodies are where the scene has them at its start; they are moved here and left elsewhere.
  JointLink(dWorldID world, const SceneModel& model, int joint, const JointEnd& parent,
            const JointEnd& child, const Options& options);
  JointLink(const JointLink&) = delete;
  JointLink& operator=(const JointLink&) = delete;

  /// Sets the motors for the next step of `h` and adds what no motor carries to the bodies' forces.
  /// `q`: this joint's coordinates, brought up to date if the laws need them.
  void drive(double h, const std::vector<Drive>& drives, double* q);
  /// Brings the coordinates up to date; turns are counted from what `q` was.
  void update(double* q) const;
  void velocities(const double* q, double* u) const;
  /// After a step of `h`.
  void report(double h, const JointReport& out) const;
  bool acts() const { return first_.body != nullptr; }  ///< else both ends are immovable

 private:
  /// One law along one speed: a motor of ODE's.
  struct Motor {
    int speed = 0;
    int drive = -1;    ///< SceneModel::motors; -1: the axis's own spring and damping, or friction
    bool own = false;  ///< of the joint itself
    bool limited = false;  ///< its axis has stops
    bool friction = false;
    dJointID id = nullptr;
    int group = 0;  ///< dParamGroup of the axis
    dJointFeedback feedback{};
    double velocity = 0.0, bound = 0.0, cfm = -1.0;  ///< as ODE has them
    double at_stop = 0.0;  ///< what ODE applied of it as a force, being at a stop
  };
  /// What is applied as a force.
  struct Applied {
    int speed = 0, drive = -1;
    double effort = 0.0;
  };

  void make(dWorldID world, const Options& options);
  void make_planar(dWorldID world, const Options& options);
  void set_stops();
  void add_motors(dWorldID world, const SceneModel& model, int joint, const Options& options);
  void add_ball_motors(dWorldID world);
  Motor& add_motor(dWorldID world, int speed, bool own);
  int own_group(int speed) const;  ///< -1: the joint has no motor for it
  bool turns(int speed) const;
  dJointID attached(dJointID id, dJointFeedback& feedback) const;
  int relative_to(bool parent) const;
  /// Direction of a speed, given F and M.
  Vec3 direction(int speed, const Pose& X_WF, const Pose& X_WM) const;
  void set(Motor& motor, double velocity, double bound, double cfm);
  void set_law(Motor& motor, const Drive& law, double h, double* q);
  void drive_ball(double h);
  void apply(int speed, int drive, double effort);
  double stop_effort(const Motor& motor) const;
  Wrench on_child(const dJointFeedback& feedback, const Vec3& centre, const Vec3& about) const;

  const Joint* joint_ = nullptr;
  JointEnd parent_, child_, first_, second_;  ///< second_: nothing for what is immovable
  double sign_ = 1.0;                         ///< -1: first_ is the parent
  double reference_[3] = {0.0, 0.0, 0.0};     ///< coordinates at which ODE's are zero
  double cfm_ = 0.0;
  dJointID id_ = nullptr;      ///< nullptr: both ends immovable
  dJointID normal_ = nullptr;  ///< of a planar joint
  dJointFeedback feedback_{}, normal_feedback_{};
  std::deque<Motor> motors_;
  dJointID ball_law_ = nullptr, ball_friction_ = nullptr;
  dJointFeedback law_feedback_{}, friction_feedback_{};
  std::vector<Applied> applied_;
  bool fresh_ = false;  ///< coordinates of this step are known
  Pose X_WF_, X_WM_;    ///< at the start of the step, when applied_ is not empty
};

}  // namespace cogrsim::ode
