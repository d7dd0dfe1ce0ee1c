// Actions by name: spawning and removing, attaching and detaching, static and dynamic, doors.
#include <algorithm>
#include <cmath>

#include "cogrsim/model/builder.h"
#include "core/index.h"
#include "geometry/clearance.h"
#include "geometry/surface_distance.h"
#include "simulation/impl.h"
#include "simulation/model_change.h"

namespace cogrsim {

namespace {

/// A frame on a body or in the world.
struct Anchor {
  int body = kWorld;
  Pose X_BA;
  bool is_body = false;  ///< a body and not a frame, so that distances are between surfaces
};

Result<Anchor> find_anchor(const SceneModel& model, const std::string& name) {
  if (name == "world") return Anchor{};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    if (model.bodies[i].removed) continue;
    if (model.bodies[i].name == name) return Anchor{static_cast<int>(i), {}, true};
    names.push_back(model.bodies[i].name);
  }
  for (const NamedFrame& frame : model.frames) {
    if (frame.removed) continue;
    if (frame.name == name) return Anchor{frame.body, frame.X_BF, false};
    names.push_back(frame.name);
  }
  if (const int assembly = find_assembly(model, name); assembly >= 0) {
    const std::vector<int> bodies = bodies_of(model, assembly);
    if (!bodies.empty()) return Anchor{bodies.front(), {}, true};
    return fail("assembly '" + name + "' has no bodies");
  }
  const std::string near = nearest_name(name, names);
  return fail("there is no body, frame or assembly '" + name + "'", "",
              near.empty() ? "" : "did you mean '" + near + "'?");
}

Pose pose_of(const WorldState& state, int body) {
  return body == kWorld ? Pose{} : state.poses[at(body)];
}

// The assembly that contains a dotted name; -1: none.
int assembly_around(const SceneModel& model, const std::string& name) {
  for (std::size_t dot = name.rfind('.'); dot != std::string::npos && dot > 0;
       dot = name.rfind('.', dot - 1)) {
    const int found = find_assembly(model, name.substr(0, dot));
    if (found >= 0) return found;
  }
  return -1;
}

}  // namespace

Result<> Simulation::Impl::check_capacity(const std::string& what, std::size_t bodies) {
  const auto refuse = [&](const std::string& why) {
    return fail("cannot add " + what + ": " + why +
                    "; further requests are rejected without a message",
                "", "", kTooMany);
  };
  if (event_system.memory.added_in_step >= kMaxAddedPerStep) {
    return refuse(std::to_string(kMaxAddedPerStep) + " assemblies were already added in this step");
  }
  std::size_t there = 0;
  for (std::size_t i = original->bodies.size(); i < model->bodies.size(); ++i) {
    if (!model->bodies[i].removed) ++there;
  }
  if (there + bodies > static_cast<std::size_t>(kMaxAddedBodies)) {
    return refuse(std::to_string(there) + " bodies that were added during the run exist, at most " +
                  std::to_string(kMaxAddedBodies) + " are allowed");
  }
  return {};
}

Result<> Simulation::Impl::spawn(const Spawn& action) {
  const auto found = std::find_if(model->templates.begin(), model->templates.end(),
                                  [&](const TemplateModel& t) { return t.name == action.of; });
  if (found == model->templates.end()) {
    std::vector<std::string> names;
    for (const TemplateModel& t : model->templates) names.push_back(t.name);
    const std::string near = nearest_name(action.of, names);
    return fail("there is no template '" + action.of + "'", "",
                near.empty() ? "" : "did you mean '" + near + "'?");
  }
  const SceneModel& fragment = *found->fragment;
  const std::string what = "a '" + action.of + "'";
  if (auto checked = check_capacity(what, fragment.bodies.size()); !checked) return checked;
  if (!(action.lifetime > 0.0))
    return fail("cannot add " + what + ": its lifetime must be above 0 s");
  if (!(action.clearance >= 0.0) || !std::isfinite(action.clearance)) {
    return fail("cannot add " + what + ": the clearance must be 0 m or more");
  }
  std::string name = action.name;
  int number = 0;
  if (name.empty()) {
    const auto last = event_system.memory.numbers.find(action.of);
    number = last == event_system.memory.numbers.end() ? 0 : last->second;
    do {
      name = action.of + "_" + std::to_string(++number);
    } while (find_assembly(*model, name) >= 0 || find_body(*model, name) >= 0);
  }

  const geometry::Clearance around(*model, present_state().poses);
  Pose pose = action.pose;
  if (action.places.empty()) {
    const std::string in_the_way = around.in_the_way(fragment, pose, action.clearance);
    if (!in_the_way.empty()) {
      return fail("cannot add '" + name + "': '" + in_the_way + "' is in the way");
    }
  } else {
    std::vector<std::size_t> free;
    std::string in_the_way;
    for (std::size_t i = 0; i < action.places.size(); ++i) {
      const std::string obstacle =
          around.in_the_way(fragment, action.places[i] * action.pose, action.clearance);
      if (obstacle.empty())
        free.push_back(i);
      else if (in_the_way.empty())
        in_the_way = obstacle;
    }
    // Always drawn, even without a choice, so that obstacles do not change later random numbers.
    RandomStream random(0, "");
    random.set_state(event_system.memory.random);
    const double draw = random.uniform();
    event_system.memory.random = random.state();
    if (free.empty()) {
      return fail("cannot add '" + name + "': none of its " +
                  std::to_string(action.places.size()) + " places is free; at the first '" +
                  in_the_way + "' is in the way");
    }
    const auto chosen = static_cast<std::size_t>(draw * static_cast<double>(free.size()));
    pose = action.places[free[std::min(chosen, free.size() - 1)]] * action.pose;
  }
  if (auto added = add_assembly({found->fragment, name, pose}, action.of); !added) return added;
  if (number > 0) event_system.memory.numbers[action.of] = number;
  if (std::isfinite(action.lifetime)) {
    event_system.memory.lifetimes.push_back(
        {time() + action.lifetime, find_assembly(*model, name)});
  }
  return {};
}

// Replaces the model by one with the same elements; the world applies the differences.
Result<> Simulation::Impl::change_to(Result<SceneModelPtr> next) {
  if (!next) return tl::unexpected(next.error());
  if (auto changed = world->change(*next); !changed) return changed;
  model = *next;
  return {};
}

Result<> Simulation::Impl::attach(const Attach& action) {
  const std::string what = "cannot attach '" + action.child + "' to '" + action.parent + "': ";
  const auto parent = find_anchor(*model, action.parent);
  if (!parent) return fail(what + parent.error().message, "", parent.error().hint);
  const auto child = find_anchor(*model, action.child);
  if (!child) return fail(what + child.error().message, "", child.error().hint);
  if (child->body == kWorld) return fail(what + "the child must be a body");
  const WorldState& now = present_state();
  const Pose X_WA = pose_of(now, parent->body) * parent->X_BA;  // of the parent frame
  const Pose X_WC = pose_of(now, child->body) * child->X_BA;    // of the child frame
  if (std::isfinite(action.reach)) {
    double distance = (X_WA.p - X_WC.p).norm();
    if (parent->is_body && child->is_body) {
      const auto solid = [&](int body) { return geometry::SurfaceSet::of_bodies(*model, {body}); };
      distance = geometry::surface_distance(solid(parent->body), solid(child->body), now.poses,
                                            std::vector<bool>(now.poses.size()));
    }
    if (distance > action.reach) {
      return fail(what + "they are " + std::to_string(distance) + " m apart, the reach is " +
                  std::to_string(action.reach) + " m");
    }
  }
  Joint joint;
  joint.name = action.name;
  joint.parent = parent->body;
  joint.child = child->body;
  joint.assembly = assembly_around(*model, action.name);
  Pose X_WF(action.point ? X_WA * *action.point : X_WC.p, X_WA.q);
  switch (action.type) {
    case Attach::Type::fixed:
      joint.type = JointType::fixed;
      break;
    case Attach::Type::hinge:
      joint.type = JointType::hinge;
      if (!(action.axis.norm() > 1e-9)) return fail(what + "the axis has no length");
      X_WF.q = (X_WA.q * z_to(action.axis.normalized())).normalized();
      break;
    case Attach::Type::ball:
      joint.type = JointType::ball;
      break;
  }
  if (action.type != Attach::Type::fixed) joint.axes.resize(1);
  joint.X_PF = pose_of(now, joint.parent).inverse() * X_WF;
  joint.X_CM = pose_of(now, joint.child).inverse() * X_WF;
  auto next = with_joint(*model, std::move(joint));
  if (!next) return tl::unexpected(next.error());
  for (const Diagnostic& d : check_capabilities(**next, backend->name(), backend->capabilities())) {
    if (d.severity == Severity::error) return fail(d.message, "", d.help, d.code);
  }
  if (auto added = world->add(*next); !added) return added;
  model = *next;
  publish_event({time(), "attached", action.name, "", model->bodies[at(child->body)].name});
  return {};
}

Result<> Simulation::Impl::detach(const Detach& action) {
  const auto found = find_named(model->joints, "joint", action.joint);
  if (!found) return tl::unexpected(found.error());
  const int child = model->joints[at(*found)].child;
  auto next = with_joint_removed(*model, action.joint);
  if (!next) return tl::unexpected(next.error());
  if (auto removed = world->remove(*next); !removed) return removed;
  model = *next;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (model->sensors[i].removed) sensors.enable(i, false);
  }
  publish_event(
      {time(), "detached", action.joint, "", child == kWorld ? "" : model->bodies[at(child)].name});
  return {};
}

Result<> Simulation::Impl::set_limits(const SetJointLimits& action) {
  return change_to(with_limits(*model, action.joint, action.axis, action.lower, action.upper));
}

Result<> Simulation::Impl::set_static(const SetStatic& action) {
  if (auto done = change_to(with_static(*model, action.body, action.on)); !done) return done;
  publish_event({time(), action.on ? "made-static" : "made-dynamic", action.body, "", ""});
  return {};
}

Result<> Simulation::Impl::move_door(const MoveDoor& action) {
  const auto found = find_named(model->doors, "door", action.door);
  if (!found) return tl::unexpected(found.error());
  const DoorModel& door = model->doors[at(*found)];
  if (door.motor < 0) return fail("door '" + door.name + "' has no motor");
  event_system.update_model(model);
  DoorMemory& memory = event_system.memory.doors[at(*found)];
  const double end = action.open ? door.open : door.closed;
  // Another command may have moved its motor since.
  const bool aims_there = motors[at(door.motor)].target == end;
  if (memory.open == action.open && aims_there) return {};  // it is there or moving there
  const std::string motor = model->motors[at(door.motor)].name;
  if (auto set = set_motor(motor, end); !set) return set;
  memory = {action.open, false};
  publish_event({time(), action.open ? "opening" : "closing", door.name, "", ""});
  return {};
}

}  // namespace cogrsim
