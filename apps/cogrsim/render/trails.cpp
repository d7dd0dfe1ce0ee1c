#include "render/trails.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace cogrsim::cli {
namespace {

constexpr Color kColors[] = {{0.85, 0.15, 0.10, 1}, {0.00, 0.35, 0.75, 1}, {0.10, 0.55, 0.20, 1},
                             {0.60, 0.25, 0.70, 1}, {0.85, 0.50, 0.00, 1}, {0.00, 0.55, 0.60, 1}};

// The body an assembly is followed by: its first one that moves.
std::string leading_body(const SceneModel& model, int assembly) {
  for (const int b : bodies_of(model, assembly)) {
    const Body& body = model.bodies[b];
    if (body.kind != BodyKind::static_body) return body.name;
  }
  return {};
}

}  // namespace

Result<Trails> Trails::of(const SceneModel& model, const std::vector<std::string>& names) {
  Trails out;
  const auto follow = [&](const std::string& body, const std::string& label) {
    MapTrail trail;
    trail.label = label;
    trail.color = kColors[out.trails_.size() % std::size(kColors)];
    out.bodies_.push_back(body);
    out.trails_.push_back(std::move(trail));
  };
  for (const std::string& name : names) {
    const int assembly = find_assembly(model, name);
    if (assembly >= 0) {
      const std::string body = leading_body(model, assembly);
      if (body.empty()) return fail("nothing in assembly '" + name + "' moves");
      follow(body, name);
    } else if (find_body(model, name) >= 0) {
      follow(name, name);
    } else {
      std::vector<std::string> known;
      for (const AssemblyInfo& a : model.assemblies) known.push_back(a.name);
      for (const Body& b : model.bodies) known.push_back(b.name);
      const std::string near = nearest_name(name, known);
      return fail("there is no body or assembly '" + name + "'", "",
                  near.empty() ? "" : "did you mean '" + near + "'?");
    }
  }
  if (!names.empty()) return out;
  std::vector<bool> followed(model.assemblies.size(), false);
  const auto consider = [&](int assembly) {
    const int top = top_level_assembly(model, assembly);
    if (top < 0 || followed[top]) return;
    followed[top] = true;
    const std::string body = leading_body(model, top);
    if (!body.empty()) follow(body, model.assemblies[top].name);
  };
  for (const ControllerModel& c : model.controllers) {
    if (!c.removed) consider(c.assembly);
  }
  // The motor of a door does not make it a robot.
  const auto moves_door = [&](std::size_t motor) {
    return std::any_of(model.doors.begin(), model.doors.end(),
                       [&](const DoorModel& d) { return d.motor == static_cast<int>(motor); });
  };
  for (std::size_t m = 0; m < model.motors.size(); ++m) {
    if (!model.motors[m].removed && !moves_door(m)) consider(model.motors[m].assembly);
  }
  return out;
}

void Trails::add(const Frame& frame) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const int body = find_body(*frame.model, bodies_[i]);
    trails_[i].points.push_back(body >= 0
                                    ? frame.state.poses[body].p
                                    : Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
}

}  // namespace cogrsim::cli
