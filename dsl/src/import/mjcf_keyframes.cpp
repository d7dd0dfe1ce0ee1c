// Keyframes of MJCF: states in which the robot can start.
#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "import/mjcf_reader.h"

namespace cogrsim::dsl::import {

void MjcfReader::keyframes(const XmlElement& root) {
  const std::string& wanted = context_.options.keyframe;
  std::vector<std::string> names;
  Source at = root.at;
  bool found = false;
  for (const auto& section : root.children) {
    if (section->name != "keyframe") continue;
    at = section->at;
    for (const auto& key : section->children) {
      const std::string* given = key->find("name");
      names.push_back(given != nullptr ? *given : std::to_string(names.size() + 1));
      if (names.back() == wanted && !found) {
        found = true;
        start_at(*key);
      } else {
        context_.left_out(key->at, fmt::format("key '{}'", names.back()),
                          fmt::format("the robot starts {}; --keyframe {} starts it here",
                                      wanted.empty() ? "at its zero" : "elsewhere", names.back()));
      }
    }
  }
  if (found || wanted.empty()) return;
  std::string list;
  for (std::size_t i = 0; i < names.size() && i < 20; ++i) add_to(list, "'" + names[i] + "'", ", ");
  const std::string near = nearest_name(wanted, names);
  context_.error(at, "CG1408", fmt::format("there is no keyframe '{}'", wanted),
                 names.empty() ? "the model has none"
                 : near.empty()
                     ? "its keyframes are " + list
                     : fmt::format("did you mean '{}'? Its keyframes are {}", near, list));
}

void MjcfReader::start_at(const XmlElement& key) {
  std::size_t positions = 0;
  for (const Coordinates& c : coordinates_) positions += c.count;
  const auto values = [&](const char* name, std::size_t count) {
    const std::string* text = key.find(name);
    return text == nullptr ? std::nullopt
                           : context_.numbers(key, *text, count, count, fmt::format("'{}'", name));
  };
  const auto turn = [](const double* q) {
    const Quat out(q[0], q[1], q[2], q[3]);
    return out.norm() > 1e-9 ? out.normalized() : Quat::Identity();
  };
  if (const auto q = values("qpos", positions)) {
    const double* value = q->data();
    for (const Coordinates& c : coordinates_) {
      RobotJoint& j = joint_at(c.joint);
      if (c.count == 7) {
        j.X_PC = Pose(Vec3(value[0], value[1], value[2]), turn(value + 3));
      } else if (c.count == 4) {
        j.turn = turn(value);
      } else if (c.part) {
        // Its zero may be anywhere in the plane.
        const Eigen::AngleAxisd angle(c.part->q);
        j.X_PC = j.X_PC * Pose(*value * c.part->p,
                               Quat(Eigen::AngleAxisd(*value * angle.angle(), angle.axis())));
      } else {
        j.position = *value - ref(c.joint);
      }
      value += c.count;
    }
  }
  if (const auto u = values("ctrl", controls_.size()))
    for (std::size_t i = 0; i < u->size(); ++i)
      for (const Control& c : controls_[i])
        robot_.drives[c.drive].target = c.scale * (*u)[i] + c.offset;
  std::string rest;
  for (const char* name : {"qvel", "act", "mpos", "mquat"})
    if (const std::string* text = key.find(name); text != nullptr) {
      const bool zero = text->find_first_of("123456789") == std::string::npos;
      if (!zero) add_to(rest, name, ", ");
    }
  const std::string what = quoted_name(key);
  if (rest.empty())
    context_.exact(key.at, what, "is the start");
  else
    context_.approximate(key.at, what, "is the start, without " + rest);
}

}  // namespace cogrsim::dsl::import
