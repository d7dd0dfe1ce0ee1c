#include "import/scene_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "import/scene_text.h"
#include "syntax/text.h"

namespace cogrsim::dsl::import {

namespace {

/// Attributes of a shape, a material or a pair of materials.
std::string frictions(double friction, double rolling, double spinning, bool all) {
  std::string out = fmt::format(" friction=\"{}\"", friction);
  if (rolling > 0.0 || all) out += fmt::format(" rolling-friction=\"{}\"", rolling);
  if (spinning > 0.0 || all) out += fmt::format(" spinning-friction=\"{}\"", spinning);
  return out;
}
std::string rule(const char* of, CombineRule rule) {
  return rule == CombineRule::usual
             ? ""
             : fmt::format(" {}-combine=\"{}\"", of, kCombineRuleNames[static_cast<int>(rule)]);
}

std::string mujoco_text(const MujocoAttributes& of_mujoco) {
  std::string out = "<mujoco";
  for (const auto& [key, value] : of_mujoco) out += fmt::format(" {}=\"{}\"", key, value);
  return out + "/>";
}

}  // namespace

std::string end_text(const std::string& tag, const MujocoAttributes& of_mujoco) {
  return of_mujoco.empty() ? "/>\n" : fmt::format(">{}</{}>\n", mujoco_text(of_mujoco), tag);
}

std::string physics_text(const RobotModel& robot) {
  if (!robot.step && !robot.gravity && robot.of_mujoco.empty()) return "";
  std::string out = "  <physics";
  if (robot.step) out += fmt::format(" step=\"{} s\"", *robot.step);
  if (robot.gravity) out += fmt::format(" gravity=\"{}\"", list(*robot.gravity));
  if (robot.of_mujoco.empty()) return out + "/>\n";
  return out + ">\n    " + mujoco_text(robot.of_mujoco) + "\n  </physics>\n";
}

std::string materials_text(const RobotModel& robot) {
  std::string out;
  for (const RobotMaterial& m : robot.materials)
    out += fmt::format("  <material name=\"{}\"{}{}{}", m.name,
                       frictions(m.friction, m.rolling_friction, m.spinning_friction, false),
                       rule("friction", m.friction_combine), end_text("material", m.of_mujoco));
  for (const RobotContact& c : robot.contacts)
    out += fmt::format("  <contact between=\"{} {}\"{}/>\n", robot.materials[c.a].name,
                       robot.materials[c.b].name,
                       frictions(c.friction, c.rolling_friction, c.spinning_friction, true));
  return out;
}

std::string surface_text(const RobotModel& robot, const RobotShape& s) {
  if (s.material >= 0)
    return fmt::format(" material=\"{}\"", robot.materials[std::size_t(s.material)].name);
  std::string out;
  if (s.friction) out += fmt::format(" friction=\"{}\"", *s.friction);
  if (s.friction) out += rule("friction", s.friction_combine);
  if (s.restitution > 0.0) out += fmt::format(" restitution=\"{}\"", s.restitution);
  if (s.restitution > 0.0) out += rule("restitution", s.restitution_combine);
  if (s.rolling_friction > 0.0) out += fmt::format(" rolling-friction=\"{}\"", s.rolling_friction);
  if (s.spinning_friction > 0.0)
    out += fmt::format(" spinning-friction=\"{}\"", s.spinning_friction);
  return out;
}

std::string color_text(const Color& color) {
  const auto byte = [](double x) {
    return static_cast<int>(std::lround(255.0 * std::clamp(x, 0.0, 1.0)));
  };
  return fmt::format(" color=\"#{:02x}{:02x}{:02x}{}\"", byte(color.r), byte(color.g),
                     byte(color.b), color.a < 1.0 ? fmt::format("{:02x}", byte(color.a)) : "");
}

std::string mesh_attributes(const RobotShape& s, const std::string& file) {
  const Vec3& scale = s.geometry.scale;
  std::string out = fmt::format(" file=\"{}\"", escaped(file));
  if (scale != Vec3::Ones())
    out += scale[0] == scale[1] && scale[1] == scale[2] ? fmt::format(" scale=\"{}\"", scale[0])
                                                        : fmt::format(" scale=\"{}\"", list(scale));
  return out;
}

std::string light_text(const RobotLight& l) {
  std::string out = fmt::format("    <light name=\"{}\" type=\"{}\"", l.name, l.type);
  if (l.type != "directional") out += fmt::format(" xyz=\"{}\"", list(tidy(l.position)));
  if (l.type != "point") out += fmt::format(" direction=\"{}\"", list(tidy(l.direction)));
  out += color_text({l.color.r, l.color.g, l.color.b, 1.0});
  if (l.intensity != 1.0) out += fmt::format(" intensity=\"{}\"", l.intensity);
  if (l.type == "spot" && l.cone) out += fmt::format(" cone=\"{} rad\"", *l.cone);
  return out + (l.shadows ? "/>\n" : " shadows=\"false\"/>\n");
}

std::string passive_text(const RobotJoint& j) {
  const bool slides = j.type == RobotJoint::Type::slider;
  std::string out;
  const char* effort = slides ? "N" : "N*m";
  if (j.damping > 0.0)
    out += fmt::format(" damping=\"{} {}\"", j.damping, slides ? "N*s/m" : "N*m*s/rad");
  if (j.friction > 0.0) out += fmt::format(" friction=\"{} {}\"", j.friction, effort);
  if (j.stiffness <= 0.0) return out;
  out += fmt::format(" stiffness=\"{} {}\"", j.stiffness, slides ? "N/m" : "N*m/rad");
  if (j.rest != 0.0 && j.type != RobotJoint::Type::ball)
    out += fmt::format(" rest=\"{} {}\"", j.rest, slides ? "m" : "rad");
  return out;
}

// The rotation at the start is R(a, q1) R(b, q2) R(c, q3) about the axes a, b and c.
std::string gimbal_text(const RobotJoint& j) {
  std::string out;
  const auto all = [&](const char* name, double v, const char* unit) {
    if (v > 0.0) out += fmt::format(" {0}=\"{1} {1} {1} {2}\"", name, v, unit);
  };
  all("damping", j.damping, "N*m*s/rad");
  all("friction", j.friction, "N*m");
  all("stiffness", j.stiffness, "N*m/rad");
  all("rotor-inertia", j.rotor_inertia, "kg*m^2");
  if (j.turn.vec().norm() == 0.0) return out;
  Mat3 axes;
  axes << j.axis, j.axis2, j.axis.cross(j.axis2);
  const Mat3 R = axes.transpose() * j.turn.toRotationMatrix() * axes;
  out += fmt::format(" position=\"{} {} {} rad\"", std::atan2(-R(1, 2), R(2, 2)),
                     std::asin(std::clamp(R(0, 2), -1.0, 1.0)), std::atan2(-R(0, 1), R(0, 0)));
  return out;
}

std::string scene_name(std::string name) {
  if (name.empty()) name = "robot";
  for (char& c : name)
    if (!is_letter(c) && !is_digit(c) && c != '-') c = '_';
  if (!is_letter(name.front())) name.insert(0, "_");
  name.resize(std::min<std::size_t>(name.size(), 60));
  if (name == "world" || name == "floor") name += "_model";  // names that the scene has
  return name;
}

}  // namespace cogrsim::dsl::import
