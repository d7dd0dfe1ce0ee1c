// Doors and mazes: connects the elements that expansion made of them.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "build/build_scene.h"

namespace cogrsim::dsl {
namespace {

constexpr double kLeastForce = 40.0;  // [N]
constexpr double kPull = 20.0;        // [m/s^2]

std::string newtons(double value) {
  char text[48];
  std::snprintf(text, sizeof text, "%.3g N", value);
  return text;
}

}  // namespace

void Builder::doors() {
  std::unordered_map<std::string_view, int> motors;
  if (!context_.doors.empty())
    for (std::size_t i = 0; i < model_.motors.size(); ++i)
      motors.emplace(model_.motors[i].name, static_cast<int>(i));
  for (const DoorPlan& plan : context_.doors) {
    DoorModel door;
    door.name = plan.element->path;
    door.open = plan.travel;
    door.starts_open = plan.starts_open;
    door.assembly = note(*plan.element).assembly;
    door.origin = plan.element->span();
    const auto motor = motors.find(plan.motor->path);
    if (motor != motors.end()) {
      door.motor = motor->second;
      Motor& drive = model_.motors[door.motor];
      const Joint& slide = model_.joints[drive.joint];
      const Note& leaf = note(*plan.leaf);
      if (leaf.body != kWorld && !leaf.faulty && !note(*plan.element).faulty) {
        const Body& body = model_.bodies[leaf.body];
        // Enough to lift it, and to stop it within its time constant from half a metre a second.
        if (!plan.force_given) drive.max_effort = std::max(kLeastForce, kPull * body.mass);
        const Vec3 axis = body.X_WB.q * (slide.X_CM.q * Vec3::UnitZ());
        const double weight = body.mass * std::abs(axis.dot(model_.physics.gravity));
        if (weight >= drive.max_effort)
          fault("CG0713", *plan.element,
                "the leaf of door '" + door.name + "' weighs " + newtons(weight) +
                    " along its direction of travel, but the force of its motor is at most " +
                    newtons(drive.max_effort))
              .help(
                  "increase the force, or make the leaf lighter: use another material, or make "
                  "it thinner");
      }
    }
    model_.doors.push_back(std::move(door));
  }
}

void Builder::mazes() {
  for (const MazePlan& made : context_.mazes) {
    MazeModel maze = made.plan;
    maze.name = made.element->path;
    maze.X_WM = note(*made.element).X_W;
    const auto number = [&](int& piece) {
      if (piece >= 0) piece = made.doors[piece];
    };
    std::for_each(maze.vertical.begin(), maze.vertical.end(), number);
    std::for_each(maze.horizontal.begin(), maze.horizontal.end(), number);
    for (const MazeModel::NamedCell& cell : maze.named_cells) {
      RegionModel region;
      region.name = maze.name + "." + cell.name;
      // As deep as it is high: what stands on the floor has its origin there, or a little below.
      region.size = Vec3(maze.cell, maze.cell, 2.0 * maze.height);
      region.X_BR = maze.X_WM;
      region.X_BR.p = maze.X_WM * maze.centre(cell.row, cell.column);
      region.assembly = note(*made.element).assembly;
      region.origin = made.element->span();
      model_.regions.push_back(std::move(region));
    }
    model_.mazes.push_back(std::move(maze));
  }
}

// A door passes through what it slides into.
void Builder::door_pairs() {
  for (const DoorPlan& plan : context_.doors) {
    const int leaf = note(*plan.leaf).body;
    if (leaf == kWorld) continue;
    for (const Element* other : plan.passes)
      if (const int body = note(*other).body; body != kWorld && body != leaf)
        model_.no_collide.push_back(std::minmax(leaf, body));
    if (!plan.passes_ground) continue;
    for (std::size_t b = 0; b < model_.bodies.size(); ++b)
      if (model_.bodies[b].kind == BodyKind::static_body)
        model_.no_collide.push_back(std::minmax(leaf, static_cast<int>(b)));
  }
}

}  // namespace cogrsim::dsl
