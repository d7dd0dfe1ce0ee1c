// Rules: `<on>` and its actions.
#include <algorithm>
#include <cctype>

#include "build/build_scene.h"
#include "cogrsim/signals/condition.h"

namespace cogrsim::dsl {
namespace {

/// Where a scene defines such names; nullopt: nowhere.
std::optional<Thing> thing_of(EventParty party) {
  switch (party) {
    case EventParty::none:
    case EventParty::name:
      return std::nullopt;
    case EventParty::region:
      return Thing::region;
    case EventParty::door:
      return Thing::door;
    case EventParty::joint:
      return Thing::joint;
    case EventParty::thing:
      return Thing::owner;
    case EventParty::posed:
      return Thing::posed;
    case EventParty::a_template:
      return Thing::templates;
    case EventParty::controller:
      return Thing::controller;
  }
  return std::nullopt;
}

/// Those that rules can act on.
std::vector<std::string> event_kinds() {
  std::vector<std::string> kinds;
  for (const EventKind& kind : kEventKinds)
    if (!kind.last) kinds.emplace_back(kind.name);
  return kinds;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())) != 0)
    text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0)
    text.remove_suffix(1);
  return text;
}

bool is_word(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.';
  });
}

template <class T>
const T* find_in(const std::vector<T>& elements, const std::string& name) {
  for (const T& element : elements)
    if (element.name == name) return &element;
  return nullptr;
}

}  // namespace

// The model that has an element of that name, and its name there: this scene, or what may be added.
std::pair<const SceneModel*, std::string> Builder::home_of(const std::string& name,
                                                           Thing thing) const {
  if (has_thing(model_, name, thing)) return {&model_, name};
  for (const Coming& coming : coming_) {
    if (coming.fragment == nullptr || name.compare(0, coming.name.size(), coming.name) != 0)
      continue;
    const std::size_t dot = name.find('.', coming.name.size());
    if (dot == std::string::npos) continue;
    const std::string inner = name.substr(dot + 1);
    if (has_thing(*coming.fragment, inner, thing)) return {coming.fragment.get(), inner};
  }
  return {nullptr, ""};
}

// "a, b)" of an event that has names; `inside` is what stands behind its "(". What is wrong, if any.
static std::string event_names(std::string_view whole, std::vector<std::string>& names) {
  if (whole.back() != ')') return "'" + std::string(whole) + "' has no closing bracket at its end";
  std::string_view inside = whole.substr(0, whole.size() - 1);
  inside.remove_prefix(inside.find('(') + 1);
  while (true) {
    const std::size_t comma = inside.find(',');
    const std::string_view name = trimmed(inside.substr(0, comma));
    if (!is_word(name)) return "'" + std::string(name) + "' cannot be a name";
    names.emplace_back(name);
    if (comma == std::string_view::npos) return "";
    inside.remove_prefix(comma + 1);
  }
}

bool Builder::event(const Element& element, RuleModel& rule) {
  const auto given = reader(element).text("event");
  if (!given.given()) return false;
  const std::string& text = *given;
  const auto wrong = [&](const std::string& what) {
    std::string kinds;
    for (const std::string& each : event_kinds()) kinds += (kinds.empty() ? "" : ", ") + each;
    fault("CG1305", element, "event", what).help("the kinds of events are " + kinds);
    return false;
  };
  const std::size_t open = text.find('(');
  const std::string_view whole = trimmed(text);
  const std::string kind(trimmed(std::string_view(text).substr(0, open)));
  if (!is_word(kind))
    return wrong("expected an event such as enter(goal, robot), found '" + text + "'");
  const auto known = std::find_if(std::begin(kEventKinds), std::end(kEventKinds),
                                  [&](const EventKind& k) { return k.name == kind; });
  if (known == std::end(kEventKinds)) {
    // Names of versions before 0.2.
    const std::string near = kind == "frozen"  ? "made-static"
                             : kind == "freed" ? "made-dynamic"
                                               : nearest_name(kind, event_kinds());
    return wrong("there is no event '" + kind + "'" +
                 (near.empty() ? "" : ", did you mean '" + near + "'?"));
  }
  if (known->last) return wrong("the run is over when '" + kind + "' occurs: no action can follow");
  std::vector<std::string> names;
  if (open != std::string::npos)
    if (const std::string bad = event_names(whole, names); !bad.empty()) return wrong(bad);
  const std::size_t most = known->subject != EventParty::none  ? 2
                           : known->source != EventParty::none ? 1
                                                               : 0;
  if (names.size() > most)
    return wrong("an event '" + kind + "' has " +
                 (most == 0   ? "no names"
                  : most == 1 ? "one name"
                              : "two names at most") +
                 ", found " + std::to_string(names.size()));
  rule.kind = kind;
  const SourceSpan at_text = element.find("event")->value_span;
  const auto take = [&](std::size_t i, std::optional<Thing> thing, std::string& into) {
    if (i >= names.size()) return true;
    if (!thing) {
      into = names[i];
      return true;
    }
    auto name = present_name(element, Word{names[i], at_text}, *thing);
    if (!name) return false;
    into = *name;
    return true;
  };
  const bool source_good = take(0, thing_of(known->source), rule.source);
  const bool subject_good = take(1, thing_of(known->subject), rule.subject);
  if (!source_good || !subject_good) return false;
  // A region that detects other objects never reports this one.
  if (known->source == EventParty::region && !rule.subject.empty() && !rule.source.empty()) {
    const RegionModel* region = find_in(model_.regions, rule.source);
    const auto concerns = [&](const std::string& who) {
      return who == rule.subject ||
             who.compare(0, rule.subject.size() + 1, rule.subject + ".") == 0;
    };
    if (region != nullptr && !region->who.empty() &&
        std::none_of(region->who.begin(), region->who.end(), concerns)) {
      std::string list;
      for (const std::string& who : region->who) list += (list.empty() ? "'" : ", '") + who + "'";
      fault("CG1302", element, "event",
            "region '" + rule.source + "' does not detect '" + rule.subject + "'")
          .note("it detects " + list, region->origin)
          .help("add it to the region's 'who'");
      return false;
    }
  }
  return true;
}

std::optional<std::string> Builder::rule_condition(const Element& element,
                                                   std::string_view attribute) {
  const auto given = reader(element).text(attribute);
  if (!given.given()) return std::nullopt;
  bool lost = false, coming = false, refused = false;
  std::string unknown;
  SignalScope scope{model_, channels(), {}};
  scope.resolve = [&](const std::string& name) -> std::string {
    const Names::Found found = names_.peek(element, name);
    lost = lost || found.lost;
    for (const Thing thing : {Thing::posed, Thing::region, Thing::joint, Thing::motor,
                              Thing::sensor, Thing::door, Thing::controller}) {
      std::string full = full_name(element, name, thing);
      if (!full.empty()) return full;
      coming = coming || may_come(name, thing);
    }
    coming = coming || is_announced(element, name);
    // Asked for with its quantity, and without.
    if (found.element == nullptr && (unknown.empty() || name.size() < unknown.size()))
      unknown = name;
    // Not in the model: it has no signals, or was refused.
    refused = refused || found.element != nullptr;
    return found.element != nullptr ? found.element->path : std::string();
  };
  const auto parsed = Condition::parse(scope, *given);
  if (parsed) return parsed->text();
  // Objects that do not exist yet are looked up when they have been added.
  if (coming) return *given;
  if (lost || (refused && sink().has_errors())) return std::nullopt;
  // A supervisor may add anything.
  if (!unknown.empty() && !model_.supervisors.empty()) {
    fault("CG2030", element, attribute, parsed.error().message)
        .help("correct the name; write added=\"" + unknown + "\" if a supervisor adds it");
    return *given;
  }
  fault("CG1308", element, attribute, parsed.error().message).help(parsed.error().hint);
  return std::nullopt;
}

void Builder::rules() {
  for_each(scene_, [&](const Element& element) {
    if (element.tag() == "on") rule(element);
  });
}

void Builder::rule(const Element& element) {
  RuleModel rule;
  rule.name = element.path;
  rule.origin = element.span();
  Reader r = reader(element);
  const bool on_event = r.has("event"), at_time = r.has("time") || r.has("every");
  const bool on_condition = r.has("when");
  const int triggers = int(on_event) + int(at_time) + int(on_condition);
  if (triggers == 0)
    fault("CG1303", element, "this rule never fires: it has no event, time or condition")
        .help("add event=\"…\", time=\"…\", every=\"…\" or when=\"…\"");
  if (triggers > 1) {
    const std::string_view first = on_event ? "event" : "when";
    fault("CG1303", element, first,
          std::string("a rule has one trigger, this one has ") +
              (on_event ? "an event" : "a condition") + " and " +
              (at_time ? "a time" : "a condition"))
        .help(on_condition ? "write the condition that must hold at that time as if=\"…\""
                           : "write two rules, or if=\"time ge …\" beside the event");
  }
  if (on_event) event(element, rule);
  const auto time = r.number("time");
  const auto every = r.number("every");
  if (time.given()) rule.time = *time;
  if (every.given()) rule.every = *every;
  if (on_condition && r.has("if"))
    fault("CG1303", element, "if", "'if' is for an event or a time, not for 'when'")
        .help("join the two conditions in 'when' with 'and'");
  const std::string_view attribute = on_condition ? "when" : "if";
  if (r.has(attribute))
    if (auto condition = rule_condition(element, attribute)) rule.when = std::move(*condition);
  rule.after = *r.number("after");
  rule.limit = static_cast<int>(std::min<std::int64_t>(*r.integer("limit"), 1'000'000'000));
  int actions = 0;
  for (const Element* child : element.children) {
    if (child->node->spec == nullptr) continue;
    ++actions;
    if (auto made = action(*child)) rule.actions.push_back(std::move(*made));
  }
  if (actions == 0 && !element.incomplete)
    fault("CG1304", element, "this rule has no action")
        .help("write one inside, for example <log message=\"…\"/>");
  model_.rules.push_back(std::move(rule));
}

std::optional<std::string> Builder::named_thing(const Element& element, std::string_view attribute,
                                                Thing thing) {
  const auto word = reader(element).word(attribute);
  if (!word.given()) return std::nullopt;
  return present_name(element, *word, thing);
}

std::optional<Action> Builder::action(const Element& element) {
  const std::string_view tag = element.tag();
  Reader r = reader(element);
  const auto name = [&](std::string_view attribute, Thing thing) {
    return named_thing(element, attribute, thing);
  };
  if (tag == "open" || tag == "close") {
    const auto door = name("door", Thing::door);
    if (!door) return std::nullopt;
    return MoveDoor{*door, tag == "open"};
  }
  if (tag == "spawn") return spawn(element);
  if (tag == "remove") {
    const auto what = name("name", Thing::owner);
    if (!what) return std::nullopt;
    return Remove{*what};
  }
  if (tag == "attach") return attach(element);
  if (tag == "detach") {
    const auto joint = name("joint", Thing::joint);
    if (!joint) return std::nullopt;
    return Detach{*joint};
  }
  if (tag == "limit") return limit(element);
  if (tag == "make-static" || tag == "make-dynamic") {
    const auto body = name("name", Thing::owner);
    if (!body) return std::nullopt;
    return SetStatic{*body, tag == "make-static"};
  }
  if (tag == "drive") {
    const auto motor = name("motor", Thing::motor);
    if (!motor) return std::nullopt;
    const auto [model, inner] = home_of(*motor, Thing::motor);
    const auto target = r.number(
        "target",
        model != nullptr ? target_dimension(*model, *find_in(model->motors, inner)) : dim::kNone);
    if (!target.given()) return std::nullopt;
    return SetMotor{*motor, *target};
  }
  if (tag == "switch") {
    const auto sensor = name("sensor", Thing::sensor);
    if (!sensor) return std::nullopt;
    return EnableSensor{*sensor, *r.boolean("on")};
  }
  if (tag == "raise") {
    const auto event = r.word("event");
    if (!event.given()) return std::nullopt;
    return Raise{(*event).text, *r.text("message")};
  }
  if (tag == "log") {
    const auto message = r.text("message");
    if (!message.given()) return std::nullopt;
    return LogMessage{*message};
  }
  return EndRun{*r.text("reason")};
}

// Initial pose of a named frame or maze cell; nullopt: reported.
std::optional<Pose> Builder::named_pose(const Element& element, const Word& word) {
  const std::string full = full_name(element, word.text, Thing::posed);
  const Names::Found found = names_.peek(element, word.text);
  if (found.element != nullptr && (full.empty() || found.element->path == full) &&
      note(*found.element).placing == Note::Placing::done)
    return note(*found.element).X_W;
  if (const NamedFrame* frame = find_in(model_.frames, full))
    return frame->body == kWorld ? frame->X_BF : model_.bodies[frame->body].X_WB * frame->X_BF;
  present_name(element, word, Thing::posed);
  return std::nullopt;
}

bool Builder::spawn_poses(const Element& element, const Word& word, std::vector<Pose>& poses) {
  const MazeModel* maze = nullptr;
  std::string_view name = word.text;
  const bool only_free = name.size() > 5 && name.substr(name.size() - 5) == ".free";
  if (only_free) name.remove_suffix(5);
  for (const Element* level = element.parent; level != nullptr && maze == nullptr;
       level = level->parent)
    maze = find_in(model_.mazes,
                   level->path.empty() ? std::string(name) : level->path + "." + std::string(name));
  if (maze == nullptr) {
    const auto pose = named_pose(element, word);
    if (pose) poses.push_back(*pose);
    return pose.has_value();
  }
  for (int row = 0; row < maze->rows; ++row)
    for (int column = 0; column < maze->columns; ++column) {
      const bool named =
          std::any_of(maze->named_cells.begin(), maze->named_cells.end(),
                      [&](const auto& p) { return p.row == row && p.column == column; });
      if (only_free && named) continue;
      poses.push_back(maze->X_WM * Pose(maze->centre(row, column), Quat(1, 0, 0, 0)));
    }
  if (!poses.empty()) return true;
  fault("CG1307", element, "in", "maze '" + maze->name + "' has no cell without a name");
  return false;
}

std::optional<Action> Builder::spawn(const Element& element) {
  Reader r = reader(element);
  Spawn spawn;
  const auto of = named_thing(element, "of", Thing::templates);
  const auto own = r.pose();
  const auto name = r.word("name");
  bool good = of.has_value() && !own.failed() && !name.failed();
  const bool placed_itself = r.has("xyz") || r.has("frame");
  const int positions = int(r.has("at")) + int(r.has("in")) + int(r.has("frame"));
  if (positions > 1) {
    fault("CG1307", element, r.has("at") ? "at" : "in",
          "'at', 'in' and 'frame' each set the pose, and this spawn has several of them")
        .help("keep one of them; xyz and rpy may be added to each");
    good = false;
  }
  if (positions == 0 && !placed_itself) {
    fault("CG1307", element, "the spawn has no position")
        .help("add xyz=\"…\", at=\"FRAME\" or in=\"MAZE.free\"");
    good = false;
  }
  spawn.pose = *own;
  for (const std::string_view attribute : {"at", "frame"}) {
    if (!r.has(attribute)) continue;
    const auto word = r.word(attribute);
    const auto pose = !word.given()             ? std::nullopt
                      : (*word).text == "world" ? std::optional<Pose>(Pose{})
                                                : named_pose(element, *word);
    good = good && pose.has_value();
    if (pose) spawn.pose = *pose * *own;
  }
  if (r.has("in")) {
    const auto words = r.words("in");
    if (words.failed()) return std::nullopt;
    for (const Word& word : *words)
      good = spawn_poses(element, word, spawn.candidate_poses) && good;
  }
  const auto clearance = r.number("clearance");
  const auto lifetime = r.number("lifetime");
  if (!good || clearance.failed() || lifetime.failed()) return std::nullopt;
  spawn.of = *of;
  if (name.given()) spawn.name = (*name).text;
  spawn.clearance = *clearance;
  if (lifetime.given()) spawn.lifetime = *lifetime;
  return spawn;
}

std::optional<Action> Builder::attach(const Element& element) {
  Reader r = reader(element);
  Attach attach;
  const auto name = r.word("name");
  const auto parent = r.word("parent");
  const bool to_world = parent.given() && (*parent).text == "world";
  const auto carrier =
      to_world ? std::optional<std::string>("world") : named_thing(element, "parent", Thing::posed);
  const auto child = named_thing(element, "child", Thing::posed);
  const auto type = r.text("type");
  const auto point = r.vec3("point");
  const auto axis = r.vec3("axis");
  const auto reach = r.number("reach");
  if (type.failed() || point.failed() || axis.failed() || reach.failed()) return std::nullopt;
  attach.type = *type == "hinge"  ? Attach::Type::hinge
                : *type == "ball" ? Attach::Type::ball
                                  : Attach::Type::fixed;
  if (r.has("axis") && attach.type != Attach::Type::hinge)
    fault("CG1307", element, "axis", "a " + *type + " joint has no axis")
        .help("make it type=\"hinge\", or leave the axis out");
  if (attach.type == Attach::Type::hinge && !((*axis).norm() > 1e-9))
    fault("CG1307", element, "axis", "the axis has zero length");
  if (!name.given() || !carrier || !child) return std::nullopt;
  attach.name = (*name).text;
  attach.parent = *carrier;
  attach.child = *child;
  if (point.given()) attach.point = *point;
  attach.axis = *axis;
  if (reach.given()) attach.reach = *reach;
  return attach;
}

std::optional<Action> Builder::limit(const Element& element) {
  Reader r = reader(element);
  const auto name = named_thing(element, "joint", Thing::joint);
  const auto axis = r.integer("axis");
  if (!name || axis.failed()) return std::nullopt;
  SetJointLimits limits;
  limits.joint = *name;
  limits.axis = static_cast<int>(*axis) - 1;
  if (!r.has("lower") && !r.has("upper")) {
    fault("CG1307", element, "a limit without 'lower' and 'upper' changes nothing")
        .help("add one of them, or both; \"none\" removes a limit");
    return std::nullopt;
  }
  const auto [model, inner] = home_of(*name, Thing::joint);
  bool turns = true;
  if (model != nullptr) {
    const Joint& joint = *find_in(model->joints, inner);
    const int axes = static_cast<int>(joint.axes.size());
    if (limits.axis >= axes) {
      fault("CG1307", element, "axis",
            "joint '" + *name + "' has " + std::to_string(axes) + (axes == 1 ? " axis" : " axes") +
                "; it has no axis " + std::to_string(*axis));
      return std::nullopt;
    }
    turns = joint.type == JointType::ball || axis_turns(joint.type, limits.axis);
  }
  bool good = true;
  const auto take = [&](std::string_view attribute, double none, std::optional<double>& into) {
    if (!r.has(attribute)) return;
    if (trimmed(element.find(attribute)->value) == "none") {
      into = none;
      return;
    }
    const auto value = r.number(attribute, turns ? dim::kAngle : dim::kLength);
    good = good && value.given();
    into = *value;
  };
  const double infinity = std::numeric_limits<double>::infinity();
  take("lower", -infinity, limits.lower);
  take("upper", infinity, limits.upper);
  if (good && limits.lower && limits.upper && *limits.lower >= *limits.upper) {
    fault("CG1307", element, "upper", "the upper limit is not above the lower one");
    good = false;
  }
  if (!good) return std::nullopt;
  return limits;
}

}  // namespace cogrsim::dsl
