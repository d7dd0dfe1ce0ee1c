#include "simulation/snapshot/events.h"
#include "core/index.h"

#include <map>

namespace cogrsim::snapshots {
namespace {

template <class Element>
int index_of(const std::vector<Element>& elements, const std::string& name) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (elements[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

const char* kind_word(Visitor::Kind kind) {
  return kind == Visitor::Kind::body ? "body" : kind == Visitor::Kind::frame ? "frame" : "assembly";
}

std::string name_of(const SceneModel& model, const Visitor& visitor) {
  const auto i = static_cast<std::size_t>(visitor.index);
  switch (visitor.kind) {
    case Visitor::Kind::body:
      return model.bodies[i].name;
    case Visitor::Kind::frame:
      return model.frames[i].name;
    case Visitor::Kind::assembly:
      break;
  }
  return model.assemblies[i].name;
}

Visitor visitor_from(const SceneModel& model, const std::string& kind, const std::string& name) {
  if (kind == "body") return {Visitor::Kind::body, index_of(model.bodies, name)};
  if (kind == "frame") return {Visitor::Kind::frame, index_of(model.frames, name)};
  return {Visitor::Kind::assembly, index_of(model.assemblies, name)};
}

Json causes_json(const SceneModel& model, const Causes& causes) {
  Json out = Json::array();
  for (const int rule : causes) out.push_back(model.rules[at(rule)].name);
  return out;
}

}  // namespace

Json event_state_json(const SceneModel& model, const EventState& memory) {
  Json rules = Json::object(), doors = Json::object(), inside = Json::object();
  for (std::size_t i = 0; i < memory.rules.size(); ++i) {
    const RuleMemory& rule = memory.rules[i];
    rules[model.rules[i].name] = {{"fired", rule.fired},
                                  {"rounds", rule.rounds},
                                  {"held", rule.held},
                                  {"off", rule.off},
                                  {"limit_reported", rule.limit_reported}};
  }
  for (std::size_t i = 0; i < memory.doors.size(); ++i) {
    doors[model.doors[i].name] = {{"open", memory.doors[i].open},
                                  {"arrived", memory.doors[i].arrived}};
  }
  for (std::size_t i = 0; i < memory.inside.size(); ++i) {
    Json who = Json::array();
    for (const Visitor& visitor : memory.inside[i]) {
      who.push_back({{"kind", kind_word(visitor.kind)}, {"name", name_of(model, visitor)}});
    }
    inside[model.regions[i].name] = std::move(who);
  }
  Json pending = Json::array(), lifetimes = Json::array(), numbers = Json::object();
  for (const PendingActions& actions : memory.pending) {
    pending.push_back({{"due", number(actions.due)},
                       {"rule", model.rules[at(actions.rule)].name},
                       {"causes", causes_json(model, actions.causes)}});
  }
  for (const Lifetime& lifetime : memory.lifetimes) {
    lifetimes.push_back({{"due", number(lifetime.due)},
                         {"assembly", model.assemblies[at(lifetime.assembly)].name}});
  }
  for (const auto& [name, last] : memory.numbers) numbers[name] = last;
  return {{"started", memory.started}, {"rules", rules},         {"doors", doors},
          {"inside", inside},          {"pending", pending},     {"lifetimes", lifetimes},
          {"numbers", numbers},        {"random", memory.random}};
}

void event_state_from(const Json& json, const SceneModel& model, EventState& memory) {
  memory.started = json.at("started").get<bool>();
  for (const auto& [name, value] : json.at("rules").items()) {
    const int index = index_of(model.rules, name);
    if (index < 0 || at(index) >= memory.rules.size()) continue;
    RuleMemory& rule = memory.rules[at(index)];
    rule.fired = whole_from<int>(value.at("fired"));
    rule.rounds = whole_from<std::uint64_t>(value.at("rounds"));
    rule.held = value.at("held").get<bool>();
    rule.off = value.at("off").get<bool>();
    rule.limit_reported = value.at("limit_reported").get<bool>();
  }
  for (const auto& [name, value] : json.at("doors").items()) {
    const int index = index_of(model.doors, name);
    if (index < 0 || at(index) >= memory.doors.size()) continue;
    memory.doors[at(index)] = {value.at("open").get<bool>(), value.at("arrived").get<bool>()};
  }
  for (const auto& [name, value] : json.at("inside").items()) {
    const int index = index_of(model.regions, name);
    if (index < 0 || at(index) >= memory.inside.size()) continue;
    auto& inside = memory.inside[at(index)];
    inside.clear();
    for (const Json& who : value) {
      const Visitor visitor =
          visitor_from(model, who.at("kind").get<std::string>(), who.at("name").get<std::string>());
      if (visitor.index >= 0) inside.push_back(visitor);
    }
  }
  memory.pending.clear();
  for (const Json& value : json.at("pending")) {
    PendingActions actions;
    actions.due = number_from(value.at("due"));
    actions.rule = index_of(model.rules, value.at("rule").get<std::string>());
    if (actions.rule < 0) continue;
    for (const Json& cause : value.at("causes")) {
      const int rule = index_of(model.rules, cause.get<std::string>());
      if (rule >= 0) actions.causes.push_back(rule);
    }
    memory.pending.push_back(std::move(actions));
  }
  memory.lifetimes.clear();
  for (const Json& value : json.at("lifetimes")) {
    const int assembly = index_of(model.assemblies, value.at("assembly").get<std::string>());
    if (assembly >= 0) memory.lifetimes.push_back({number_from(value.at("due")), assembly});
  }
  memory.numbers.clear();
  for (const auto& [name, last] : json.at("numbers").items())
    memory.numbers[name] = whole_from<int>(last);
  memory.random = whole_from<std::uint64_t>(json.at("random"));
}

}  // namespace cogrsim::snapshots
