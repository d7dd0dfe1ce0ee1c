#include "simulation/scene_actions.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/expression.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/sensing/sensor_models.h"
#include "core/index.h"
#include "geometry/clearance.h"
#include "geometry/surface_distance.h"
#include "model/diagnose.h"
#include "simulation/find_named.h"
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

Result<> check_name(const std::string& name) {
  const auto begins = [](char c) { return expression::is_letter(c) || c == '_'; };
  const auto goes_on = [&](char c) { return begins(c) || expression::is_digit(c) || c == '-'; };
  if (!name.empty() && begins(name.front()) && std::all_of(name.begin(), name.end(), goes_on))
    return {};
  return fail("an assembly cannot be named '" + name.substr(0, 100) + "'", "",
              "a name has letters, digits, '_' and '-', and begins with a letter or '_'");
}

}  // namespace

Result<> SceneActions::check_capacity(const std::string& what, std::size_t bodies) const {
  const auto refuse = [&](const std::string& why) {
    return fail(
        "cannot add " + what + ": " + why + "; further requests are rejected without a message", "",
        "", kTooMany);
  };
  if (events_.memory.added_in_step >= kMaxAddedPerStep) {
    return refuse(std::to_string(kMaxAddedPerStep) + " assemblies were already added in this step");
  }
  std::size_t there = 0;
  for (std::size_t i = host_.original()->bodies.size(); i < model().bodies.size(); ++i) {
    if (!model().bodies[i].removed) ++there;
  }
  if (there + bodies > static_cast<std::size_t>(kMaxAddedBodies)) {
    return refuse(std::to_string(there) + " bodies that were added during the run exist, at most " +
                  std::to_string(kMaxAddedBodies) + " are allowed");
  }
  return {};
}

Result<> SceneActions::check_supported(const SceneModel& next) const {
  const Backend& backend = host_.backend();
  for (const Diagnostic& d : check_capabilities(next, backend.name(), backend.capabilities())) {
    if (d.severity == Severity::error) return tl::unexpected(to_error(d));
  }
  return {};
}

Result<> SceneActions::add(const AddAssembly& action, const std::string& subject) {
  if (!action.fragment) return fail("cannot add assembly '" + action.name + "': it is empty");
  if (auto good = check_name(action.name); !good) return good;
  const std::size_t bodies = action.fragment->bodies.size();
  if (auto checked = check_capacity("'" + action.name + "'", bodies); !checked) {
    return checked;
  }
  auto next = with_added(model(), *action.fragment, action.name, action.pose);
  if (!next) return tl::unexpected(next.error());
  next = host_.reduced(std::move(*next));
  if (auto good = check_supported(**next); !good) return good;
  if (const auto found = unusable_delays(**next, clock_.dt()); !found.empty())
    return tl::unexpected(found.front().error);
  if (!action.fragment->controllers.empty()) {
    auto named = std::make_shared<SceneModel>(**next);
    name_outputs(*named, loader_);
    next = SceneModelPtr(std::move(named));
  }
  const DeviceManager::Counts devices_before = devices_.counts();
  const std::size_t controllers_before = controllers_.size();
  if (auto added = host_.add(*next); !added) return added;
  std::vector<Diagnostic> found = devices_.build(devices_before);
  for (Diagnostic& d : controllers_.build(controllers_before)) found.push_back(std::move(d));
  if (!found.empty()) {
    std::string why = joined(found);
    controllers_.stop(controllers_before);
    // The bodies are already in the world, so they are removed again.
    next = with_removed(**next, action.name);
    const Result<> removed = next ? host_.remove(*next) : Result<>(tl::unexpected(next.error()));
    devices_.build(devices_before);
    if (removed) {
      controllers_.build(controllers_before);
    } else {
      devices_.retire_sensors(devices_before.sensors);
      why += "; its bodies stay, without sensors and controllers: " + removed.error().message;
    }
    return fail("cannot add assembly '" + action.name + "': " + why, found.front());
  }
  ++events_.memory.added_in_step;
  events_.publish("added", action.name, "", subject);
  return {};
}

Result<> SceneActions::apply(const Remove& action) {
  const SceneModelPtr before = host_.model();
  auto next = with_removed(*before, action.name);
  if (!next) return tl::unexpected(next.error());
  if (auto removed = host_.remove(*next); !removed) return removed;
  controllers_.drop_removed();
  devices_.drop_removed(true);
  // Its joints to other assemblies are detached; its own joints are removed with it.
  for (std::size_t i = 0; i < model().joints.size(); ++i) {
    const Joint& joint = model().joints[i];
    if (!joint.removed || before->joints[i].removed) continue;
    if (joint.assembly >= 0 && model().assemblies[at(joint.assembly)].removed) continue;
    events_.publish("detached", joint.name, "",
                    joint.child == kWorld ? "" : model().bodies[at(joint.child)].name);
  }
  events_.publish("removed", action.name);
  return {};
}

Result<> SceneActions::apply(const Spawn& action) {
  const auto found = std::find_if(model().templates.begin(), model().templates.end(),
                                  [&](const TemplateModel& t) { return t.name == action.of; });
  if (found == model().templates.end()) {
    std::vector<std::string> names;
    for (const TemplateModel& t : model().templates) names.push_back(t.name);
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
    const auto last = events_.memory.numbers.find(action.of);
    number = last == events_.memory.numbers.end() ? 0 : last->second;
    do {
      name = action.of + "_" + std::to_string(++number);
    } while (find_assembly(model(), name) >= 0 || find_body(model(), name) >= 0);
  } else if (auto good = check_name(name); !good) {
    return good;
  }

  const geometry::Clearance around(model(), host_.state().poses);
  Pose pose = action.pose;
  if (action.candidate_poses.empty()) {
    const std::string in_the_way = around.in_the_way(fragment, pose, action.clearance);
    if (!in_the_way.empty()) {
      return fail("cannot add '" + name + "': '" + in_the_way + "' is in the way");
    }
  } else {
    std::vector<std::size_t> free;
    std::string in_the_way;
    for (std::size_t i = 0; i < action.candidate_poses.size(); ++i) {
      const std::string obstacle =
          around.in_the_way(fragment, action.candidate_poses[i] * action.pose, action.clearance);
      if (obstacle.empty())
        free.push_back(i);
      else if (in_the_way.empty())
        in_the_way = obstacle;
    }
    // Always drawn, even without a choice, so that obstacles do not change later random numbers.
    RandomStream random(0, "");
    random.set_state(events_.memory.random);
    const double draw = random.uniform();
    events_.memory.random = random.state();
    if (free.empty()) {
      return fail("cannot add '" + name + "': none of its " +
                  std::to_string(action.candidate_poses.size()) + " poses is free; at the first '" +
                  in_the_way + "' is in the way");
    }
    const auto chosen = static_cast<std::size_t>(draw * static_cast<double>(free.size()));
    pose = action.candidate_poses[free[std::min(chosen, free.size() - 1)]] * action.pose;
  }
  if (auto added = add({found->fragment, name, pose}, action.of); !added) return added;
  if (number > 0) events_.memory.numbers[action.of] = number;
  if (std::isfinite(action.lifetime)) {
    events_.memory.lifetimes.push_back(
        {clock_.time() + action.lifetime, find_assembly(model(), name)});
  }
  return {};
}

Result<> SceneActions::apply(const Attach& action) {
  const std::string what = "cannot attach '" + action.child + "' to '" + action.parent + "': ";
  const auto parent = find_anchor(model(), action.parent);
  if (!parent) return fail(what + parent.error().message, "", parent.error().hint);
  const auto child = find_anchor(model(), action.child);
  if (!child) return fail(what + child.error().message, "", child.error().hint);
  if (child->body == kWorld) return fail(what + "the child must be a body");
  const WorldState& now = host_.state();
  const Pose X_WA = pose_of(now, parent->body) * parent->X_BA;  // of the parent frame
  const Pose X_WC = pose_of(now, child->body) * child->X_BA;    // of the child frame
  if (std::isfinite(action.reach)) {
    double distance = (X_WA.p - X_WC.p).norm();
    if (parent->is_body && child->is_body) {
      const auto solid = [&](int body) { return geometry::SurfaceSet::of_bodies(model(), {body}); };
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
  joint.assembly = assembly_around(model(), action.name);
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
  auto next = with_joint(model(), std::move(joint));
  if (!next) return tl::unexpected(next.error());
  if (auto good = check_supported(**next); !good) return good;
  if (auto added = host_.add(*next); !added) return added;
  events_.publish("attached", action.name, "", model().bodies[at(child->body)].name);
  return {};
}

Result<> SceneActions::apply(const Detach& action) {
  const auto found = find_named(model().joints, "joint", action.joint);
  if (!found) return tl::unexpected(found.error());
  const int child = model().joints[at(*found)].child;
  auto next = with_joint_removed(model(), action.joint);
  if (!next) return tl::unexpected(next.error());
  if (auto removed = host_.remove(*next); !removed) return removed;
  devices_.drop_removed(false);
  events_.publish("detached", action.joint, "",
                  child == kWorld ? "" : model().bodies[at(child)].name);
  return {};
}

Result<> SceneActions::apply(const SetJointLimits& action) {
  auto next = with_limits(model(), action.joint, action.axis, action.lower, action.upper);
  if (!next) return tl::unexpected(next.error());
  return host_.change(*next);
}

Result<> SceneActions::apply(const SetStatic& action) {
  auto next = with_static(model(), action.body, action.on);
  if (!next) return tl::unexpected(next.error());
  if (auto changed = host_.change(*next); !changed) return changed;
  events_.publish(action.on ? "made-static" : "made-dynamic", action.body);
  return {};
}

Result<> SceneActions::apply(const MoveDoor& action) {
  const auto found = find_named(model().doors, "door", action.door);
  if (!found) return tl::unexpected(found.error());
  const DoorModel& door = model().doors[at(*found)];
  if (door.motor < 0) return fail("door '" + door.name + "' has no motor");
  events_.update_model(host_.model());
  DoorMemory& memory = events_.memory.doors[at(*found)];
  const double end = action.open ? door.open : door.closed;
  // Another command may have moved its motor since.
  const bool aims_there = devices_.motor(door.motor).target == end;
  if (memory.open == action.open && aims_there) return {};  // it is there or moving there
  if (auto set = apply(SetMotor{model().motors[at(door.motor)].name, end}); !set) return set;
  memory = {action.open, false};
  events_.publish(action.open ? "opening" : "closing", door.name);
  return {};
}

Result<> SceneActions::apply(const SetMotor& action) {
  const auto found = find_named(model().motors, "motor", action.motor);
  if (!found) return tl::unexpected(found.error());
  if (!std::isfinite(action.target))
    return fail("motor '" + action.motor + "': the target is not a finite number");
  devices_.set_target(*found, action.target);
  return {};
}

Result<> SceneActions::apply(const EnableSensor& action) {
  const auto found = find_named(model().sensors, "sensor", action.sensor);
  if (!found) return tl::unexpected(found.error());
  devices_.sensors().enable(at(*found), action.on);
  return {};
}

Result<> SceneActions::apply(const SetKinematicTwist& action) {
  const auto found = find_named(model().bodies, "body", action.body);
  if (!found) return tl::unexpected(found.error());
  auto* drive = host_.world().extension<KinematicDrive>();
  if (!drive) {
    return fail("backend '" + std::string(host_.backend().name()) +
                "' cannot move kinematic bodies while running");
  }
  return drive->set_kinematic_twist(*found, action.twist);
}

Result<> SceneActions::apply(const SetState& action) {
  return host_.world().set_state(action.state);
}

}  // namespace cogrsim
