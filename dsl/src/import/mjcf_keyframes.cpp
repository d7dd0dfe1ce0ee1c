// Keyframes of MJCF: states in which the robot can start.
#include <fmt/format.h>

#include <algorithm>

#include "cogrsim/core/parameter.h"
#include "import/mjcf_reader.h"
#include "import/robot_start.h"

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
        context_.left_aside(
            key->at, fmt::format("key '{}'", names.back()),
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
        const double travel = *value - c.ref;
        j.X_PC = j.X_PC * Pose(travel * c.part->p,
                               Quat(Eigen::AngleAxisd(travel * angle.angle(), angle.axis())));
      } else {
        j.position = *value - c.ref;
      }
      value += c.count;
    }
  }
  const bool driven = disabled_.count("actuation") == 0;
  if (const auto u = driven ? values("ctrl", controls_.size()) : std::nullopt)
    for (std::size_t i = 0; i < u->size(); ++i)
      for (const Control& c : controls_[i]) robot_.drives[c.drive].target = c.of((*u)[i]);
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

Pose MjcfReader::start_of(int link) const {
  for (const RobotJoint& j : robot_.joints)
    if (j.child == link)
      return (j.parent < 0 ? Pose() : start_of(j.parent)) * j.X_PC *
             travel(j, std::clamp(j.position, j.lower, j.upper), j.turn);
  return link < 0 ? Pose() : robot_.links[link].X;
}

void MjcfReader::start_at_welds() {
  // The joint of the free body that carries a link; nullptr: none does.
  const auto root = [&](int link) -> RobotJoint* {
    for (bool found = true; found;) {
      found = false;
      for (RobotJoint& j : robot_.joints) {
        if (j.child != link) continue;
        if (j.type == RobotJoint::Type::free) return &j;
        link = j.parent;
        found = true;
        break;
      }
    }
    return nullptr;
  };
  std::set<const RobotJoint*> placed;
  for (const Weld& w : welds_) {
    RobotJoint *one = root(w.body1), *two = root(w.body2);
    const Pose X_1 = start_of(w.body1), X_2 = start_of(w.body2), wanted = X_1 * w.X_12;
    const double gap = (wanted.p - X_2.p).norm(), turn = wanted.q.angularDistance(X_2.q);
    const bool second = two != nullptr && two != one && placed.count(two) == 0;
    const bool first = one != nullptr && two != one && placed.count(one) == 0;
    if (gap > 1e-6 || turn > 1e-6) {
      if (!second && !first) {
        const auto of_weld = [&](const RobotJoint& j) { return j.name == w.name; };
        robot_.loops.erase(std::remove_if(robot_.loops.begin(), robot_.loops.end(), of_weld),
                           robot_.loops.end());
        context_.left_out(w.at, fmt::format("weld '{}'", w.name),
                          fmt::format("its relpose is {:.3g} m and {:.3g} rad away from the start, "
                                      "and neither body is free to start there",
                                      gap, turn));
        continue;
      }
      if (second)
        two->X_PC = wanted * X_2.inverse() * two->X_PC;
      else
        one->X_PC = X_2 * w.X_12.inverse() * X_1.inverse() * one->X_PC;
    }
    context_.approximate(w.at, fmt::format("weld '{}'", w.name),
                         gap > 1e-6 || turn > 1e-6
                             ? "is rigid, and the bodies start where its relpose holds them, to "
                               "which MuJoCo's pulls them softly"
                             : "is rigid, where MuJoCo's is soft");
    placed.insert({one, two});
  }
}

}  // namespace cogrsim::dsl::import
