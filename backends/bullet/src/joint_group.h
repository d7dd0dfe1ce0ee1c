// Articulated groups as the step sees them, whatever formulation they are in.
#pragma once

#include <vector>

#include "axis_law.h"
#include "rigid_body.h"
#include "step_bodies.h"

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"

namespace cogrsim::bullet {

/// What a step leaves to be reported about the joints of a world.
struct JointReport {
  std::vector<double> joint_efforts;  ///< SceneModel::joint_speeds
  std::vector<double> motor_efforts;  ///< one per motor
  std::vector<Wrench> reactions;      ///< on the child, about M's origin, world axes
};

/// Whether a drive does anything at all.
bool acts(const Drive& drive);

/// What of a joint's axis a scalar law stands for: all of it, or, on a ball joint, spring, damper
/// and friction along one direction, or the cone.
enum class AxisPart { whole, ball_spring, ball_cone };

/// The part's law for this step. `whole` is everything on one scalar axis: `motors` first, in
/// order, then spring and damper, friction, limits.
void fill_axis_law(AxisLaw& law, AxisPart part, const JointAxis& model, const AxisState& state,
                   const std::vector<int>& motors, const std::vector<Drive>& drives);

/// The motors of a joint, by axis.
std::vector<std::vector<int>> motors_of(const SceneModel& model, int joint);

/// One articulated group within a step: prepare(), bind(), iterate() in turn with the contacts,
/// then move() and report(). Contacts act on its bodies, one rigid body each; iterate() makes of
/// what they did the motion that the joints allow.
class JointGroup {
 public:
  JointGroup() = default;
  JointGroup(const JointGroup&) = delete;
  JointGroup& operator=(const JointGroup&) = delete;
  virtual ~JointGroup() = default;

  /// What holds for a whole step of dt. `q`: coordinates of all joints of the world.
  virtual void prepare(const SceneModel& model, double dt, const std::vector<Drive>& drives,
                       const std::vector<double>& q) = 0;
  /// Couples the group to the step's bodies.
  virtual void bind(StepBodies& bodies) = 0;
  /// Solves the group against the bodies' present velocity changes.
  virtual void iterate(StepBodies& bodies) = 0;
  /// Efforts of the step, and the reactions where the group finds them on the way.
  virtual void report(const SceneModel& model, double dt, JointReport& out) = 0;

  /// Whether the group moves its bodies and counts its joints' coordinates itself.
  virtual bool moves_bodies() const { return false; }
  /// Moves the bodies to the end of the step and writes the joints' coordinates to `q`. `extra`:
  /// what body b moves by in this step beside its velocity, both vectors zero if nothing.
  virtual void move(double dt, const std::vector<std::pair<btVector3, btVector3>>& extra,
                    std::vector<double>& q) {
    (void)dt, (void)extra, (void)q;
  }
  /// Reactions of the last step, where report() left them open.
  virtual void find_reactions(const SceneModel& model, std::vector<Wrench>& out) const {
    (void)model, (void)out;
  }
  /// What a group remembers of past steps beside the bodies and the coordinates.
  virtual std::vector<double> memory() const { return {}; }
  virtual void set_memory(const std::vector<double>& memory) { (void)memory; }

  const std::vector<int>& joints() const { return joint_indices_; }
  const std::vector<int>& bodies() const { return body_indices_; }

 protected:
  std::vector<int> joint_indices_, body_indices_;
};

}  // namespace cogrsim::bullet
