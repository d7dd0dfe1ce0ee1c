// Actions on a running world, requested by an `<on>` rule of the scene, a supervisor or a program.
// They refer to elements by name. The names are resolved when the action is applied, because
// elements can be added and removed during the run. An action that names a missing element is
// rejected with an event and a message, and the run continues.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cogrsim/core/types.h"

namespace cogrsim {

/// Adds a copy of a template (SceneModel::templates) to the world as an assembly.
struct Spawn {
  std::string of;    ///< name of the template
  std::string name;  ///< dotted name of the new assembly; empty: the template's name and a number
  Pose pose;         ///< of the assembly frame, in the world or in the pose drawn from `candidate_poses`
  /// Candidate poses in the world. If not empty, one of those with enough free space is drawn at
  /// random.
  std::vector<Pose> candidate_poses;
  double clearance = 0.0;  ///< distance to all other bodies that a candidate needs [m], >= 0
  /// Time after which the assembly is removed again [s], > 0.
  double lifetime = std::numeric_limits<double>::infinity();
};
/// Removes an assembly, or a body that belongs to no assembly, together with all joints to it.
struct Remove {
  std::string name;  ///< dotted
};
/// Creates a joint between two bodies at their current poses. A fixed joint makes them one rigid
/// body; a hinge and a ball joint rotate about `point`.
struct Attach {
  enum class Type { fixed, hinge, ball };
  std::string name;    ///< dotted name of the new joint; must not exist yet
  std::string parent;  ///< body, named frame or assembly (its base body)
  std::string child;   ///< body, named frame or assembly (its base body)
  Type type = Type::fixed;
  std::optional<Vec3> point;  ///< in the parent's frame [m]; empty: the child's origin
  Vec3 axis = Vec3(0, 0, 1);  ///< of a hinge, in the parent's frame
  /// Largest distance at which the action is accepted [m]: between the surfaces of two bodies,
  /// otherwise between the origins.
  double reach = std::numeric_limits<double>::infinity();
};
/// Removes a joint together with its motors.
struct Detach {
  std::string joint;  ///< dotted
};
/// Changes the limits of one joint axis.
struct SetJointLimits {
  std::string joint;            ///< dotted
  int axis = 0;                 ///< index of the axis, from 0
  std::optional<double> lower;  ///< [rad] or [m]; may be infinite; empty: unchanged
  std::optional<double> upper;  ///< [rad] or [m]; may be infinite; empty: unchanged
};
/// Makes bodies static (they keep their pose) or dynamic again (forces move them).
struct SetStatic {
  std::string body;  ///< dotted name of a body, or of an assembly for all its bodies
  bool on = true;    ///< true: static, false: dynamic
};
/// Sets the target of a motor, as MotorHandle::set().
struct SetMotor {
  std::string motor;    ///< dotted
  double target = 0.0;  ///< unit: that of the motor mode, see Motor
};
/// Switches a sensor on or off.
struct EnableSensor {
  std::string sensor;  ///< dotted
  bool on = true;
};
/// Moves a door (SceneModel::doors) to its open or closed position.
struct MoveDoor {
  std::string door;  ///< dotted
  bool open = true;
};
/// Emits an event of kind "raised" that the scene defines.
struct Raise {
  std::string event;  ///< becomes Event::source
  std::string message;
};
/// Ends the run.
struct EndRun {
  std::string reason;
};
/// Writes a line to the log of the run.
struct LogMessage {
  std::string message;
};

/// Any action.
using Action = std::variant<Spawn, Remove, Attach, Detach, SetJointLimits, SetStatic, SetMotor,
                            EnableSensor, MoveDoor, Raise, EndRun, LogMessage>;

}  // namespace cogrsim
