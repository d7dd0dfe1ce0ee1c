// Parts of a scene's text that need the robot alone.
#pragma once

#include <string>

#include "import/robot.h"

namespace cogrsim::dsl::import {

/// <physics>, where the source says something for it.
/// The end of an element: with a `<mujoco>` in it where it has such attributes.
std::string end_text(const std::string& tag, const MujocoAttributes& of_mujoco);
std::string physics_text(const RobotModel& robot);
/// Materials, and what holds between them.
std::string materials_text(const RobotModel& robot);
/// What a shape says of its contacts, as attributes.
std::string surface_text(const RobotModel& robot, const RobotShape& s);
/// The attribute color; opaque ones have no fourth number.
std::string color_text(const Color& color);
/// The attributes file and scale.
std::string mesh_attributes(const RobotShape& s, const std::string& file);
/// Damping, friction and spring of a joint, as attributes.
std::string passive_text(const RobotJoint& j);
std::string light_text(const RobotLight& l);
/// The same law about each axis, and the angles of the start.
std::string gimbal_text(const RobotJoint& j);

}  // namespace cogrsim::dsl::import
