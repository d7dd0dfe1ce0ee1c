// What stands around a robot: floors, walls and furniture of its file are apart from it, so that
// placing the robot does not move them, and a scene with a floor of its own can have the robot alone.
#include <algorithm>
#include <set>

#include "import/robot.h"

namespace cogrsim::dsl::import {

void set_scenery_apart(Context& context, RobotModel& robot) {
  const auto stands = [](const RobotLink& l) { return l.is_static; };
  if (std::all_of(robot.links.begin(), robot.links.end(), stands)) return;
  std::set<int> held;  // what joints hold on to is a base
  for (const std::vector<RobotJoint>* list : {&robot.joints, &robot.loops})
    for (const RobotJoint& j : *list) held.insert({j.parent, j.child});
  std::set<std::string> ends;
  for (const RobotSpring& s : robot.springs) ends.insert({s.ends[0], s.ends[1]});

  std::vector<RobotLink> split;
  std::size_t count = 0;
  Source at;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    RobotLink& l = robot.links[i];
    if (!l.is_static || l.shapes.empty() || held.count(static_cast<int>(i)) != 0) continue;
    const bool serves =
        !l.sensors.empty() || std::any_of(l.frames.begin(), l.frames.end(),
                                          [&](const auto& f) { return ends.count(f.name) != 0; });
    if (serves && !l.is_ground) continue;
    if (serves) {
      // The world's sites and cameras are the robot's.
      RobotLink& places = split.emplace_back();
      places.name = l.name + "_places";
      places.is_static = true;
      places.at = l.at;
      places.frames = std::move(l.frames);
      places.sensors = std::move(l.sensors);
      l.frames.clear();
      l.sensors.clear();
    }
    l.is_scenery = true;
    if (++count == 1) at = l.at.file >= 0 ? l.at : l.shapes.front().at;
  }
  for (RobotLink& l : split) robot.links.push_back(std::move(l));
  if (count > 0)
    context.exact(at, "what stands around the robot",
                  "is a prototype of its own: placing the robot does not move it");
}

}  // namespace cogrsim::dsl::import
