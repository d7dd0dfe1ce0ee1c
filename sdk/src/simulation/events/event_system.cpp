#include "simulation/events/event_system.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/random.h"
#include "core/index.h"

namespace cogrsim {

namespace {

bool is_part(const std::string& whole, const std::string& name) {
  return name.size() > whole.size() && name[whole.size()] == '.' &&
         name.compare(0, whole.size(), whole) == 0;
}

bool fits(const std::string& wanted, const std::string& name) {
  return wanted.empty() || wanted == name || is_part(wanted, name);
}

bool contains(const RegionModel& region, const Pose& X_WR, const Vec3& p_W) {
  const Vec3 p_R = X_WR.inverse() * p_W;
  if (region.type == RegionModel::Type::sphere) return p_R.norm() <= region.radius;
  return (p_R.cwiseAbs().array() <= 0.5 * region.size.array()).all();
}

// The base of an assembly: its first body.
int base_of(const SceneModel& model, int assembly) {
  const std::vector<int> bodies = bodies_of(model, assembly);
  return bodies.empty() ? kWorld : bodies.front();
}

const std::string& name_of(const SceneModel& model, const Visitor& who) {
  switch (who.kind) {
    case Visitor::Kind::frame:
      return model.frames[at(who.index)].name;
    case Visitor::Kind::assembly:
      return model.assemblies[at(who.index)].name;
    case Visitor::Kind::body:
      break;
  }
  return model.bodies[at(who.index)].name;
}

// All objects that a region detects by default: movable top-level assemblies and bodies without an
// assembly.
std::vector<Visitor> default_visitors(const SceneModel& model) {
  std::vector<char> moves(model.assemblies.size(), 0);
  std::vector<Visitor> out;
  for (const Body& body : model.bodies) {
    if (body.removed || body.kind == BodyKind::static_body || body.assembly < 0) continue;
    moves[at(top_level_assembly(model, body.assembly))] = 1;
  }
  for (std::size_t i = 0; i < model.assemblies.size(); ++i) {
    if (moves[i]) out.push_back({Visitor::Kind::assembly, static_cast<int>(i)});
  }
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    if (body.removed || body.kind == BodyKind::static_body || body.assembly >= 0) continue;
    out.push_back({Visitor::Kind::body, static_cast<int>(i)});
  }
  return out;
}

std::vector<Visitor> named(const SceneModel& model, const std::vector<std::string>& names) {
  std::vector<Visitor> out;
  const auto add = [&](const auto& elements, const std::string& name, Visitor::Kind kind) {
    for (std::size_t i = 0; i < elements.size(); ++i) {
      if (elements[i].removed || elements[i].name != name) continue;
      out.push_back({kind, static_cast<int>(i)});
      return true;
    }
    return false;
  };
  for (const std::string& name : names) {
    // An object that does not exist yet may be added later.
    add(model.assemblies, name, Visitor::Kind::assembly) ||
        add(model.bodies, name, Visitor::Kind::body) ||
        add(model.frames, name, Visitor::Kind::frame);
  }
  return out;
}

}  // namespace

bool matches(const RuleModel& rule, const Event& event) {
  return !rule.kind.empty() && rule.kind == event.kind && fits(rule.source, event.source) &&
         fits(rule.subject, event.subject);
}

std::optional<Vec3> position_of(const SceneModel& model, const WorldState& state,
                                const Visitor& who) {
  switch (who.kind) {
    case Visitor::Kind::frame: {
      const NamedFrame& frame = model.frames[at(who.index)];
      if (frame.removed) return std::nullopt;
      return frame.body == kWorld ? frame.X_BF.p : state.poses[at(frame.body)] * frame.X_BF.p;
    }
    case Visitor::Kind::assembly: {
      if (model.assemblies[at(who.index)].removed) return std::nullopt;
      const int base = base_of(model, who.index);
      if (base == kWorld) return std::nullopt;
      return state.poses[at(base)].p;
    }
    case Visitor::Kind::body:
      break;
  }
  if (model.bodies[at(who.index)].removed) return std::nullopt;
  return state.poses[at(who.index)].p;
}

void EventSystem::reset(const SceneModel& model, std::uint64_t seed) {
  memory = EventState{};
  memory.rules.resize(model.rules.size());
  memory.random = RandomStream(seed, "spawn").state();
  clear();
  model_.reset();
  conditions_model_.reset();
}

void EventSystem::update_model(const SceneModelPtr& model) {
  if (model_ == model) return;
  model_ = model;
  visitors_.clear();
  for (const RegionModel& region : model->regions) {
    visitors_.push_back(region.removed       ? std::vector<Visitor>()
                        : region.who.empty() ? default_visitors(*model)
                                             : named(*model, region.who));
  }
  // Doors are at their initial position, including those of added assemblies.
  for (std::size_t i = memory.doors.size(); i < model->doors.size(); ++i) {
    memory.doors.push_back({model->doors[i].starts_open, true});
  }
}

void EventSystem::detect(const SceneModelPtr& model, const WorldState& state, double time,
                         std::vector<Event>& events) {
  if (!model->regions.empty() || !model->doors.empty()) {
    update_model(model);
    detect_in_regions(*model, state, time, events);
    detect_at_doors(*model, state, time, events);
  }
  memory.started = true;
}

void EventSystem::detect_in_regions(const SceneModel& model, const WorldState& state, double time,
                                    std::vector<Event>& events) {
  const std::size_t known = memory.inside.size();
  memory.inside.resize(model.regions.size());
  for (std::size_t r = 0; r < model.regions.size(); ++r) {
    const RegionModel& region = model.regions[r];
    std::vector<Visitor>& before = memory.inside[r];
    if (region.removed) {
      before.clear();
      continue;
    }
    const Pose X_WR =
        region.body == kWorld ? region.X_BR : state.poses[at(region.body)] * region.X_BR;
    std::vector<Visitor> now;
    for (const Visitor& who : visitors_[r]) {
      const auto position = position_of(model, state, who);
      if (position && contains(region, X_WR, *position)) now.push_back(who);
    }
    // An object that was made static inside the region has not left it.
    for (const Visitor& who : before) {
      if (std::find(visitors_[r].begin(), visitors_[r].end(), who) != visitors_[r].end()) continue;
      const auto position = position_of(model, state, who);
      if (position && contains(region, X_WR, *position)) now.push_back(who);
    }
    if (now == before) continue;
    const auto publish = [&](const std::vector<Visitor>& these,
                             const std::vector<Visitor>& not_those, const char* kind) {
      for (const Visitor& who : these) {
        if (std::find(not_those.begin(), not_those.end(), who) != not_those.end()) continue;
        events.push_back({time, kind, region.name, "", name_of(model, who)});
      }
    };
    // There are no enter events at the start of a run or when a region is added.
    if (memory.started && r < known) {
      publish(before, now, "leave");
      publish(now, before, "enter");
    }
    before = std::move(now);
  }
}

void EventSystem::detect_at_doors(const SceneModel& model, const WorldState& state, double time,
                                  std::vector<Event>& events) {
  for (std::size_t d = 0; d < model.doors.size(); ++d) {
    const DoorModel& door = model.doors[d];
    DoorMemory& now = memory.doors[d];
    if (now.arrived || door.removed || door.motor < 0) continue;
    const Motor& motor = model.motors[at(door.motor)];
    const Joint& joint = model.joints[at(motor.joint)];
    const double q = state.joint_positions[at(joint.position_offset + motor.axis)];
    const double end = now.open ? door.open : door.closed;
    if (!(std::abs(q - end) <= kDoorArrived * std::abs(door.open - door.closed))) continue;
    now.arrived = true;
    events.push_back({time, now.open ? "opened" : "closed", door.name, "", ""});
  }
}

const std::vector<std::optional<Condition>>& EventSystem::conditions(
    const SceneModelPtr& model, const ChannelLookup& channels) {
  if (conditions_model_ == model) return conditions_;
  conditions_model_ = model;
  conditions_.resize(model->rules.size());
  const SignalScope scope{*model, channels, {}};
  for (std::size_t i = 0; i < conditions_.size(); ++i) {
    if (model->rules[i].when.empty()) continue;
    // Names that cannot be resolved yet are tried again in every new model.
    auto parsed = Condition::parse(scope, model->rules[i].when);
    if (parsed) conditions_[i] = std::move(*parsed);
  }
  return conditions_;
}

}  // namespace cogrsim
