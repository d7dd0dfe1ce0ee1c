// Where the joints and links of an imported robot start: positions within limits, couplings, loops.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "import/robot.h"

namespace cogrsim::dsl::import {

/// Pose of the child in its own frame at zero, where the joint is at q, or a ball turned.
Pose travel(const RobotJoint& j, double q, const Quat& turn_of_ball);

/// Refers to the robot. Reports what differs from the source.
class RobotStart {
 public:
  RobotStart(Context& context, const RobotModel& robot);

  /// Poses of all links in the robot's frame.
  const std::vector<Pose>& poses() const { return poses_; }
  /// With all joints where their springs have no effect.
  std::vector<Pose> poses_at_rest() const;
  /// Where its coupling puts it; else its position, or the limit nearest to it.
  double position(const RobotJoint& j) const;
  bool follows(const RobotJoint& j) const { return followers_.count(&j) != 0; }
  /// The joints that follow others, each before those that follow it.
  const std::vector<const RobotJoint*>& coupled() const { return coupled_; }
  /// The joints whose couplings are left out, and why.
  const std::map<const RobotJoint*, std::string>& uncoupled() const { return uncoupled_; }
  /// Whether a loop has an effect, and is closed where the robot starts: a loop is defined at the
  /// joints' zeros, which limits may exclude. Once for each loop, in their order.
  bool closes(const RobotJoint& j);

 private:
  /// The joint nearest above a link that a coupling moves at the start, or null.
  const RobotJoint* coupled_above(int link) const;
  /// Poses of all links in the robot's frame, with the joints moved from their zeros by this.
  std::vector<Pose> find_poses(const std::function<Pose(const RobotJoint&)>& moved_by) const;
  /// Finds which couplings the scene can have, and where they put their joints at the start: a joint
  /// that others follow before those. The rest form a cycle.
  void find_couplings();
  void couple(const RobotJoint& j, const std::unordered_map<std::string, const RobotJoint*>& named);

  Context& context_;
  const RobotModel& robot_;
  std::map<const RobotJoint*, double> followers_;  // where they start
  std::map<const RobotJoint*, std::string> uncoupled_;
  std::vector<const RobotJoint*> coupled_;
  std::vector<const RobotJoint*> inboard_;  // of each link
  std::vector<Pose> poses_, zero_poses_;
  bool moved_ = false;           // joints away from their zeros
  std::map<int, int> attached_;  // the root of a free tree, and what a loop's joint attaches it to
};

}  // namespace cogrsim::dsl::import
