// Texts of scenes: numbers, poses, comments.
#include "import/scene_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cogrsim/core/roll_pitch_yaw.h"
#include "import/robot.h"

namespace cogrsim::dsl::import {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
  }
  return out;
}

std::string list(const Vec3& v) { return fmt::format("{} {} {}", v[0], v[1], v[2]); }

double tidy(double x) { return std::abs(x) < 1e-15 ? 0.0 : x; }
Vec3 tidy(const Vec3& v) { return {tidy(v[0]), tidy(v[1]), tidy(v[2])}; }

std::string comment(std::string text) {
  for (std::size_t i; (i = text.find("--")) != std::string::npos;) text.replace(i, 2, "- -");
  return escaped(text);
}

std::string pose_text(const Pose& X) {
  std::string out;
  const Vec3 p = tidy(X.p);
  if (p != Vec3::Zero()) out += fmt::format(" xyz=\"{}\"", list(p));
  const Quat q = X.q.w() < 0 ? Quat(-X.q.w(), -X.q.x(), -X.q.y(), -X.q.z()) : X.q;
  if (q.vec().norm() < 1e-15) return out;
  // Angles that a person would write are written in degrees.
  const Vec3 degrees = roll_pitch_yaw(q, 1e-6) * (180.0 / kPi);
  const Vec3 round = degrees.array().round();
  // To 1e-13 rad: what is written differs from what was read by less than rounding of the poses.
  if (from_rpy(round * (kPi / 180.0)).angularDistance(q) < 1e-13)
    return out +
           fmt::format(" rpy=\"{} {} {} deg\"", tidy(round[0]), tidy(round[1]), tidy(round[2]));
  return out +
         fmt::format(" quat=\"{} {} {} {}\"", tidy(q.w()), tidy(q.x()), tidy(q.y()), tidy(q.z()));
}

}  // namespace cogrsim::dsl::import
