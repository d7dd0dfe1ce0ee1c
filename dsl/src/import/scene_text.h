// Texts of scenes: numbers, poses, comments.
#pragma once

#include <string>

#include "cogrsim/core/types.h"

namespace cogrsim::dsl::import {

/// In an attribute or a text of XML; control characters are left out.
std::string escaped(const std::string& text);
/// In a comment of XML.
std::string comment(std::string text);
std::string list(const Vec3& v);
/// -0 becomes 0, and what is zero but for rounding too.
double tidy(double x);
Vec3 tidy(const Vec3& v);
/// The attributes xyz, and rpy or quat, each with a space before it; what is zero is left out.
std::string pose_text(const Pose& X);

}  // namespace cogrsim::dsl::import
