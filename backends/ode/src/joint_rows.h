// The rows of one joint: what it forbids, and what acts along its axes.
#pragma once

#include <vector>

#include "rows.h"

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"
#include "cogrsim/physics/state.h"

namespace cogrsim::ode {

/// What acts along one speed of a joint and is not solved for: its effort is known.
struct Push {
  int axis = 0;
  int motor = -1;  ///< SceneModel::motors; -1: springs and dampers
  double effort = 0.0;
};

/// A law along one speed that is solved as a row: speed + cfm effort = target, |effort| <= bound.
struct LawRow {
  int axis = 0;
  int motor = -1;
  double target = 0.0, cfm = 0.0, bound = kNoBound;
  bool one_sided = false;  ///< `sign` times speed >= target instead
  double sign = 1.0;
  Vec3 d = Vec3::UnitZ();
  int handle = -1;
};

/// What a joint's rows ask of the speeds that it forbids.
enum class Closing {
  position,  ///< that the joint is closed at the end of the step
  stop,      ///< that they vanish
  keep       ///< that they stay what they are
};

/// One joint during a step.
class JointStep {
 public:
  /// Reads coordinates and speeds at the start of the step. `q` are the joint's coordinates.
  void begin(const SceneModel& model, int joint, const Pose& X_WP, const Pose& X_WC,
             const Twist& V_WP, const Twist& V_WC, const double* q);
  /// Forms the laws along the axes. `motors` are those of this joint.
  void form_laws(const SceneModel& model, const std::vector<int>& motors,
                 const std::vector<Drive>& drives, double h, const RowBody& parent,
                 const RowBody& child);
  /// Force and torque about M's origin that the laws with a known effort exert on the child.
  Wrench known() const;
  /// Asks for the rows. `end_P`, `end_C` are the poses that the bodies would have at the end of the
  /// step with the speeds the RowBodies have.
  void ask(Rows& rows, const RowBody& parent, const RowBody& child, Closing closing,
           const Pose& end_P, const Pose& end_C, double h, double softness);
  bool has_rows() const { return joint_->type != JointType::free; }
  /// After the step: efforts along the speeds, of the motors, and the whole wrench on the child.
  void report(const Rows& rows, const RowBody& parent, const RowBody& child,
              std::vector<double>& joint_efforts, std::vector<double>& motor_efforts,
              Wrench& reaction) const;

  const Joint& joint() const { return *joint_; }
  const Vec3& place() const { return X_WM_.p; }

 private:
  bool angular(int axis) const { return axis_turns(joint_->type, axis); }
  Vec3 direction(int axis) const;

  const Joint* joint_ = nullptr;
  int index_ = -1;
  Pose X_WF_, X_WM_;
  double q_[7] = {}, u_[6] = {};
  Vec3 ball_[3];  ///< of a ball joint: directions its laws act along
  std::vector<Push> pushes_;
  std::vector<LawRow> laws_;
  std::vector<int> holds_;  ///< handles of what the joint forbids
};

}  // namespace cogrsim::ode
