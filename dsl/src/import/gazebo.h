// What Gazebo reads in robots and worlds, in SDF and in <gazebo> of URDF: sensors and plugins.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "import/robot.h"

namespace cogrsim::dsl::import {

// ---- values in the text of child elements; nothing or identity where there is no such child, and
// where its text is none, which is reported

std::string child_text(const XmlElement& in, const char* tag);
/// `otherwise`: where there is no such child.
bool child_is_true(const XmlElement& in, const char* tag, bool otherwise = false);
std::optional<double> child_number(Context& context, const XmlElement* in, const char* tag);
std::optional<Vec3> child_vector(Context& context, const XmlElement* in, const char* tag);
/// `<pose>`, without what it is relative to.
Pose child_pose(Context& context, const XmlElement& in);

// ---- sensors and plugins

/// What a sensor is on: a link with so many collisions, or a joint.
struct SensorMount {
  Pose X;  ///< in the link
  std::size_t collisions = 0;
  std::string joint;  ///< empty: a link
};

/// A <sensor> in the scene's terms; nothing: left out. Either is reported.
std::optional<RobotSensor> gazebo_sensor(Context& context, const XmlElement& e,
                                         const SensorMount& mount);

/// The system that a plugin is, such as "diffdrive": its class or file in small letters.
std::string gazebo_system(const XmlElement& plugin);

/// A plugin as the report names it.
std::string plugin_element(const XmlElement& plugin);

/// Adds the drives of the joints that a plugin names to the robot, or else reports what in a scene
/// does the same. `joint_of`: the robot's name for a joint; empty: it has none.
void add_gazebo_plugin(Context& context, const XmlElement& plugin, RobotModel& robot,
                       const std::function<std::string(const std::string&)>& joint_of);

/// Reports a plugin that makes nothing, with what in a scene does the same.
void report_gazebo_plugin(Context& context, const XmlElement& plugin);

}  // namespace cogrsim::dsl::import
