// What can be done to a running world by name: by a scene's `<on>`, a supervisor or a program. Names
// are looked up when the action is applied, since things come and go; what is not there by then is
// refused, with an event and a message, and the run goes on.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cogrsim/core/types.h"

namespace cogrsim {

/// Adds a copy of a template (SceneModel::templates) as an assembly.
struct Spawn {
  std::string of;    ///< name of the template
  std::string name;  ///< dotted, of the new assembly; empty: the template's name and a number
  Pose pose;         ///< of its frame: in the world, or in the place chosen from `places`
  /// Not empty: one of these is drawn at random among those where there is room.
  std::vector<Pose> places;
  double clearance = 0.0;  ///< to all else, for a place to have room [m], >= 0
  double lifetime = std::numeric_limits<double>::infinity();  ///< is removed after it [s], > 0
};
/// Takes out an assembly, or a body that belongs to none, with all joints to it.
struct Remove {
  std::string name;
};
/// Makes a joint between two bodies where they are. Fixed: they move as one from now on. Hinge and
/// ball: about `point`.
struct Attach {
  enum class Type { fixed, hinge, ball };
  std::string name;    ///< of the new joint, dotted; must be free
  std::string parent;  ///< body, named frame or assembly (its base)
  std::string child;   ///< the same
  Type type = Type::fixed;
  std::optional<Vec3> point;  ///< in the parent's frame [m]; empty: the child's origin
  Vec3 axis = Vec3(0, 0, 1);  ///< hinge: in the parent's frame
  /// Refused when the surfaces (bodies), else the origins, are farther apart [m].
  double reach = std::numeric_limits<double>::infinity();
};
/// Removes a joint, with its motors.
struct Detach {
  std::string joint;
};
struct SetJointLimits {
  std::string joint;
  int axis = 0;                 ///< from 0
  std::optional<double> lower;  ///< [rad] or [m]; may be infinite; empty: stays
  std::optional<double> upper;
};
/// A body made static stays where it is; made dynamic it falls.
struct SetStatic {
  std::string body;  ///< or an assembly: all its bodies
  bool on = true;
};
/// Target of a motor, as MotorHandle::set.
struct SetMotor {
  std::string motor;
  double target = 0.0;
};
struct EnableSensor {
  std::string sensor;
  bool on = true;
};
/// Sends a door (SceneModel::doors) to its open or closed end.
struct MoveDoor {
  std::string door;
  bool open = true;
};
/// An event of the scene's own.
struct Raise {
  std::string event;  ///< becomes Event::source of an event "raised"
  std::string message;
};
struct EndRun {
  std::string reason;
};
/// A line for the user.
struct Tell {
  std::string message;
};

using Action = std::variant<Spawn, Remove, Attach, Detach, SetJointLimits, SetStatic, SetMotor,
                            EnableSensor, MoveDoor, Raise, EndRun, Tell>;

}  // namespace cogrsim
