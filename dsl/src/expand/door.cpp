// Doors: a leaf on a slider, driven to one of two ends.
#include <algorithm>
#include <cmath>

#include "expand/expand_scene.h"

namespace cogrsim::dsl {
namespace {

// The motor comes to rest exactly at the ends; a leaf that is moved beyond an end hits the stop
// here.
constexpr double kStop = 1e-3;  // [m]
// A door is heavy and its motor weak: it slows down over this time instead of banging [s].
constexpr const char* kResponse = "0.05";

}  // namespace

int Expander::door_drive(const Node& node, const InsertPoint& inside, const DoorDrive& drive) {
  Node& slider = made_node("slider", drive.at);
  hand_down(slider, "parent", node, "parent");
  give(slider, "child", drive.leaf->name);
  give(slider, "axis", drive.axis);
  give(slider, "lower", number_text(-kStop));
  give(slider, "upper", number_text(drive.travel + kStop));
  if (drive.open) give(slider, "position", number_text(drive.travel));
  add_made(slider, inside, "slide");
  Node& motor = made_node("motor", drive.at);
  give(motor, "joint", "slide");
  give(motor, "mode", "position");
  give(motor, "response", kResponse);
  give(motor, "target", number_text(drive.open ? drive.travel : 0.0));
  if (drive.force) give(motor, "max-force", number_text(*drive.force));
  give(motor, "max-speed", number_text(drive.speed));
  DoorPlan plan;
  plan.element = drive.door;
  plan.leaf = drive.leaf;
  plan.motor = add_made(motor, inside, "drive");
  plan.travel = drive.travel;
  plan.starts_open = drive.open;
  plan.force_given = drive.force.has_value();
  if (plan.motor == nullptr) return -1;
  context_.doors.push_back(std::move(plan));
  return static_cast<int>(context_.doors.size()) - 1;
}

void Expander::door(const Node& node, const InsertPoint& point, const std::string& key) {
  Element& written = read_only(node, point, key);
  Reader r(context_, written);
  std::string name;
  if (!written_name(written, point, name)) return;
  const auto size = r.vec3("size");
  const auto travel = r.number("travel");
  const auto direction = r.text("direction");
  const auto force = r.number("force"), speed = r.number("speed");
  const auto open = r.boolean("open");
  if (!size.given() || travel.failed() || direction.failed() || force.failed() || speed.failed() ||
      open.failed())
    return mark_failed(node, point);
  const bool vertical = *direction != "side";
  double distance = travel.given() ? *travel : vertical ? (*size).z() : (*size).x();
  if (distance == 0.0) {
    context_.sink.report("CG0507", written, "travel", "a door that travels 0 m never opens")
        .help("leave 'travel' out to let it open by its own width");
    return mark_failed(node, point);
  }
  if (*direction == "down") distance = -distance;

  Node& assembly = made_node("assembly", node.span);
  for (const std::string_view attribute : {"name", "xyz", "rpy", "quat", "frame"})
    hand_down(assembly, attribute, node, attribute);
  Element* door = add_made(assembly, point, name);
  if (door == nullptr) return;
  InsertPoint inside = point;
  inside.into = door;
  ++inside.depth;
  Node& leaf = made_node("box", node.span);
  for (const AttributeSpec& a : node.spec->attributes)
    if (leaf.spec->find(a.name) != nullptr && assembly.find(a.name) == nullptr && a.name != "name")
      hand_down(leaf, a.name, node, a.name);
  DoorDrive drive;
  drive.door = door;
  drive.leaf = add_made(leaf, inside, "leaf");
  if (drive.leaf == nullptr) return;
  drive.at = node.span;
  drive.axis = vertical ? (distance > 0 ? "0 0 1" : "0 0 -1") : (distance > 0 ? "1 0 0" : "-1 0 0");
  drive.travel = std::abs(distance);
  if (force.given()) drive.force = *force;
  drive.speed = *speed;
  drive.open = *open;
  door_drive(node, inside, drive);
}

}  // namespace cogrsim::dsl
