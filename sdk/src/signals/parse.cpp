// Parser of signals.
#include <algorithm>
#include <charconv>
#include <limits>
#include <mutex>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "arithmetic.h"
#include "cogrsim/signals/signal.h"
#include "core/index.h"
#include "core/trimmed.h"
#include "geometry/surface_distance.h"
#include "node.h"
#include "parse.h"
#include "terms.h"

namespace cogrsim {

namespace {

constexpr std::size_t kMostListed = 16;      // names listed in a help text
constexpr std::size_t kMostCompared = 4000;  // names compared with an unknown one

using Parsed = Result<SignalNode>;

template <class Names>
std::string listed(const Names& names) {
  std::string out;
  std::size_t shown = 0;
  for (const auto& name : names) {
    if (shown++ == kMostListed) return out + ", …";
    out += (out.empty() ? "" : ", ") + std::string(name);
  }
  return out;
}

template <class Names>
std::vector<std::string> strings(const Names& names) {
  return {names.begin(), names.end()};
}

template <class Names>
int index_of(const Names& names, const std::string& name) {
  const auto it = std::find(names.begin(), names.end(), name);
  return it == names.end() ? -1 : static_cast<int>(it - names.begin());
}

template <class Element>
int find_named(const std::vector<Element>& elements, const std::string& name) {
  for (std::size_t i = 0; i < elements.size(); ++i)
    if (!elements[i].removed && elements[i].name == name) return static_cast<int>(i);
  return -1;
}

// Splits "name[12]" into "name" and 12. Without brackets there is no index; nullopt if the brackets
// contain anything else.
struct Indexed {
  std::string name;
  std::optional<int> index;
};
std::optional<Indexed> split_index(const std::string& name) {
  const auto open = name.find('[');
  if (open == std::string::npos) return Indexed{name, {}};
  int index = 0;
  const char* begin = name.data() + open + 1;
  const char* end = name.data() + name.size();
  const auto [rest, error] = std::from_chars(begin, end, index);
  if (error != std::errc{} || index < 0 || rest + 1 != end || *rest != ']') return std::nullopt;
  return Indexed{name.substr(0, open), index};
}

class Parser {
 public:
  Parser(const SignalScope& scope, std::string text)
      : scope_(scope), model_(scope.model), text_(std::move(text)) {}

  Parsed parse() {
    if (text_.empty()) return fail("the signal is empty", "", kExamples);
    Parsed made = text_.find('(') != std::string::npos ? call() : dotted();
    return late_ ? late(made) : made;
  }

 private:
  static constexpr const char* kExamples =
      "write one such as time, robot.x, wheel.position, energy.total or distance(a, b)";

  // ---- names

  std::string resolved(const std::string& name) const {
    std::string full = scope_.resolve ? scope_.resolve(name) : name;
    if (!scope_.may_come || !scope_.may_come(name)) return full;
    late_ = true;
    return full.empty() ? name : full;
  }

  // A signal that is resolved in every model again, because its elements may be added and removed.
  Parsed late(const Parsed& now) const;

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    const auto add = [&](const auto& elements) {
      for (const auto& element : elements)
        if (!element.removed && all.size() < kMostCompared) all.push_back(element.name);
    };
    add(model_.assemblies);
    add(model_.bodies);
    add(model_.joints);
    add(model_.motors);
    add(model_.sensors);
    add(model_.frames);
    add(model_.controllers);
    add(model_.supervisors);
    return all;
  }

  // Compares with whole names and with their ends, because names in a scene may be relative.
  std::string nearest(const std::string& name) const {
    std::vector<std::string> candidates;
    for (const std::string& full : names()) {
      candidates.push_back(full);
      if (!scope_.resolve) continue;
      for (auto dot = full.find('.'); dot != std::string::npos; dot = full.find('.', dot + 1)) {
        std::string tail = full.substr(dot + 1);
        if (scope_.resolve(tail) == full) candidates.push_back(std::move(tail));
      }
    }
    return nearest_name(name, candidates);
  }

  tl::unexpected<Error> unknown(const std::string& name) const {
    const std::string near = nearest(name);
    std::vector<std::string> all = names();
    // A rigid assembly and its body have the same name.
    std::vector<std::string> shown;
    for (std::string& each : all)
      if (index_of(shown, each) < 0 && shown.size() <= kMostListed) shown.push_back(each);
    return fail(fmt::format("there is nothing named '{}'", name), "",
                near.empty() ? (all.empty() ? "the scene has no bodies, joints or sensors"
                                            : "there are " + listed(shown))
                             : fmt::format("did you mean '{}'?", near));
  }

  std::optional<SignalPose> pose(const std::string& full) const {
    if (const int body = find_body(model_, full); body >= 0) return SignalPose{body, {}};
    if (const int frame = find_named(model_.frames, full); frame >= 0) {
      const NamedFrame& named = model_.frames[at(frame)];
      return SignalPose{named.body, named.X_BF};
    }
    if (const int assembly = find_assembly(model_, full); assembly >= 0) {
      const std::vector<int> bodies = bodies_of(model_, assembly);
      if (!bodies.empty()) return SignalPose{bodies.front(), {}};
    }
    return std::nullopt;
  }

  bool exists(const std::string& full) const {
    return pose(full) || find_assembly(model_, full) >= 0 || find_joint(model_, full) >= 0 ||
           find_named(model_.regions, full) >= 0 || find_named(model_.doors, full) >= 0;
  }

  /// Whether the text without an index is the name of an element.
  bool names_element() const {
    const auto parts = split_index(text_);
    const std::string full = parts ? resolved(parts->name) : std::string();
    return !full.empty() &&
           (pose(full) || find_joint(model_, full) >= 0 || find_named(model_.motors, full) >= 0 ||
            find_named(model_.sensors, full) >= 0 || find_named(model_.controllers, full) >= 0 ||
            find_named(model_.supervisors, full) >= 0);
  }

  std::vector<int> bodies(const std::string& full) const {
    if (const int body = find_body(model_, full); body >= 0) return {body};
    if (const int assembly = find_assembly(model_, full); assembly >= 0) {
      std::vector<int> all = bodies_of(model_, assembly);
      std::sort(all.begin(), all.end());
      return all;
    }
    return {};
  }

  // ---- element.quantity

  template <class Names>
  tl::unexpected<Error> no_quantity(const std::string& what, const std::string& quantity,
                                    const Names& names) const {
    const std::string near = nearest_name(quantity, strings(names));
    return fail(
        fmt::format("{} has no '{}'", what, quantity), "",
        (near.empty() ? "" : fmt::format("did you mean '{}'? ", near)) + "it has " + listed(names));
  }

  tl::unexpected<Error> bad_index() const {
    return fail(fmt::format("'{}' is not a signal", text_), "",
                "a number in brackets stands at the end and counts from 0: lidar[3]");
  }

  Parsed dotted() const {
    if (text_ == "time") return time_term();
    const auto bad = std::find_if(text_.begin(), text_.end(), [](char c) {
      return static_cast<unsigned char>(c) <= ' ' || std::string("+*/^=<>,;)").find(c) != npos;
    });
    if (bad != text_.end())
      return fail(fmt::format("'{}' is not a signal", text_), "",
                  *bad == ' ' || *bad == ',' || *bad == ';'
                      ? std::string("one attribute holds one signal; ") + kExamples
                      : kExamples);
    const auto dot = text_.rfind('.');
    const std::string owner = text_.substr(0, dot);
    const std::string quantity = dot == npos ? "" : text_.substr(dot + 1);
    if (dot != npos)
      if (const std::string full = resolved(owner); !full.empty())
        // For an assembly "robot", "robot.eye" is not a quantity but a sensor in it.
        if (auto found = of_element(full, quantity); found && (*found || !names_element()))
          return *found;
    if (owner == "energy" && dot != npos) {
      if (const int which = index_of(kEnergyQuantities, quantity); which >= 0)
        return energy_term(which);
      return no_quantity("the energy", quantity, kEnergyQuantities);
    }
    return whole_name(owner, quantity);
  }
  static constexpr auto npos = std::string::npos;

  // nullopt: no element has this name.
  std::optional<Parsed> of_element(const std::string& full, const std::string& quantity) const {
    const std::string text = full + "." + quantity;
    if (const auto at = pose(full)) {
      const int which = index_of(kPoseQuantities, quantity);
      if (which >= 0) return pose_term(text, *at, which);
      return Parsed(no_quantity(fmt::format("'{}'", full), quantity, kPoseQuantities));
    }
    if (const int joint = find_joint(model_, full); joint >= 0)
      return of_joint(joint, quantity, text);
    if (const int motor = find_named(model_.motors, full); motor >= 0) {
      if (quantity == "effort" || quantity == "target")
        return motor_term(text, model_, motor, quantity == "target");
      return Parsed(no_quantity(fmt::format("motor '{}'", full), quantity,
                                std::array<const char*, 2>{"effort", "target"}));
    }
    if (const int sensor = find_named(model_.sensors, full); sensor >= 0)
      return of_sensor(sensor, quantity, text);
    if (const int controller = find_named(model_.controllers, full); controller >= 0)
      return of_controller(false, controller, quantity, text);
    if (const int controller = find_named(model_.supervisors, full); controller >= 0)
      return of_controller(true, controller, quantity, text);
    if (find_assembly(model_, full) >= 0)
      return Parsed(fail(fmt::format("assembly '{}' has no body", full)));
    return std::nullopt;
  }

  Parsed of_joint(int index, const std::string& quantity, const std::string& text) const {
    const Joint& joint = model_.joints[at(index)];
    const std::string what =
        fmt::format("joint '{}' ({})", joint.name, cogrsim::to_string(joint.type));
    const auto parts = split_index(quantity);
    if (!parts) return bad_index();
    const int which = index_of(kJointQuantities, parts->name);
    if (which < 0) return no_quantity(what, parts->name, kJointQuantities);
    const int entries = joint_entries(joint, which);
    if (entries == 0) return fail(what + " cannot move, so it has no " + parts->name);
    const int entry = parts->index.value_or(0);
    if (!parts->index && entries > 1)
      return fail(fmt::format("{} has {} entries in '{}'", what, entries, parts->name), "",
                  fmt::format("say which one: {}[0] to {}[{}]", text, text, entries - 1));
    if (entry >= entries)
      return fail(fmt::format("{} has no {}[{}]", what, parts->name, entry), "",
                  entries == 1 ? "it has one, write '" + parts->name + "'"
                               : fmt::format("they are counted from 0 to {}", entries - 1));
    return joint_term(text, joint, index, which, entry);
  }

  Parsed of_sensor(int index, const std::string& quantity, const std::string& text) const {
    const std::string& name = model_.sensors[at(index)].name;
    const std::vector<Channel>* channels = scope_.channels ? scope_.channels(index) : nullptr;
    if (channels == nullptr) return sensor_term(text, index, -1, quantity, "");
    std::vector<std::string> known;
    for (std::size_t i = 0; i < channels->size(); ++i) {
      const Channel& channel = (*channels)[i];
      if (channel.name == quantity)
        return sensor_term(text, index, static_cast<int>(i), quantity, channel.unit);
      known.push_back(channel.name);
    }
    const std::string what = fmt::format("sensor '{}'", name);
    if (known.empty()) return fail(what + " reads no numbers");
    return no_quantity(what, quantity, known);
  }

  Parsed of_controller(bool supervisor, int index, const std::string& quantity,
                       const std::string& text) const {
    const ControllerModel& controller =
        (supervisor ? model_.supervisors : model_.controllers)[at(index)];
    // Outputs are known when the plugin is loaded; until then every name is accepted.
    std::string unit;
    std::vector<std::string> known;
    for (const OutputModel& output : controller.outputs) {
      known.push_back(output.name);
      if (output.name == quantity) unit = output.unit.empty() ? "1" : output.unit;
    }
    if (!known.empty() && index_of(known, quantity) < 0)
      return no_quantity(
          fmt::format("{} '{}'", supervisor ? "supervisor" : "controller", controller.name),
          quantity, known);
    return controller_term(text, supervisor, index, quantity, unit);
  }

  // SENSOR[3], or a name without a quantity.
  Parsed whole_name(const std::string& owner, const std::string& quantity) const {
    const auto parts = split_index(text_);
    if (!parts) return bad_index();
    const std::string full = resolved(parts->name);
    const int sensor = full.empty() ? -1 : find_named(model_.sensors, full);
    if (sensor >= 0 && parts->index) return indexed_sensor(sensor, full, *parts->index);
    if (!full.empty() &&
        (pose(full) || find_joint(model_, full) >= 0 || sensor >= 0 ||
         find_named(model_.motors, full) >= 0 || find_named(model_.controllers, full) >= 0 ||
         find_named(model_.supervisors, full) >= 0)) {
      if (parts->index) return bad_index();
      return fail(fmt::format("'{}' alone is not a number", text_), "",
                  "name one of its quantities: " + examples_of(full));
    }
    if (quantity.empty()) {
      const std::string near = nearest_name(text_, {"time"});
      if (!near.empty())
        return fail("there is no signal '" + text_ + "'", "", "did you mean 'time'?");
      return unknown(text_);
    }
    return unknown(owner);
  }

  Parsed indexed_sensor(int sensor, const std::string& full, int channel) const {
    const std::string text = fmt::format("{}[{}]", full, channel);
    const std::vector<Channel>* channels = scope_.channels ? scope_.channels(sensor) : nullptr;
    if (channels == nullptr) return sensor_term(text, sensor, channel, text, "");
    if (at(channel) >= channels->size())
      return fail(fmt::format("sensor '{}' has no value number {}", full, channel), "",
                  fmt::format("it has {}, counted from 0", channels->size()));
    const Channel& found = (*channels)[at(channel)];
    return sensor_term(text, sensor, channel, found.name, found.unit);
  }

  std::string examples_of(const std::string& full) const {
    const auto with = [&](const auto& names) {
      std::string out;
      for (const auto& name : names)
        out += (out.empty() ? "" : ", ") + (text_ + "." + std::string(name));
      return out;
    };
    if (pose(full)) return with(kPoseQuantities);
    if (find_joint(model_, full) >= 0) return with(kJointQuantities);
    for (const auto* controllers : {&model_.controllers, &model_.supervisors})
      if (const int controller = find_named(*controllers, full); controller >= 0) {
        std::vector<std::string> outputs;
        const ControllerModel& model = (*controllers)[at(controller)];
        for (const OutputModel& output : model.outputs) outputs.push_back(output.name);
        return outputs.empty() ? text_ + ".OUTPUT" : with(outputs);
      }
    const int sensor = find_named(model_.sensors, full);
    if (sensor < 0) return text_ + ".effort";
    const auto* channels = scope_.channels ? scope_.channels(sensor) : nullptr;
    if (channels == nullptr) return text_ + ".CHANNEL or " + text_ + "[0]";
    std::vector<std::string> known;
    for (const Channel& channel : *channels)
      if (known.size() < kMostListed) known.push_back(channel.name);
    return with(known);
  }

  // ---- function(name, name)

  struct Function {
    const char* name;
    std::size_t least, most;  // arguments
    const char* usage;
    const char* takes;
  };
  static constexpr std::array<Function, 8> kFunctions = {
      {{"distance", 2, 2, "write distance(a, b)", "the names of two things"},
       {"origin_distance", 2, 2, "write origin_distance(a, b)", "the names of two things"},
       {"contacts", 1, 2, "write contacts(a, b), or contacts(a) for what a touches",
        "the names of two things"},
       {"force", 1, 2, "write force(a, b), or force(a) for what a touches",
        "the names of two things"},
       {"mass", 1, 1, "write mass(a)", "the name of one body or assembly"},
       {"inside", 2, 2, "write inside(a, region)", "the names of a thing and a region"},
       {"event", 1, 3, "write event(enter, region, a), or fewer names to match any",
        "a kind of event, then its source and its subject"},
       {"open", 1, 1, "write open(door)", "the name of one door"}}};
  Parsed call() const {
    const auto open = text_.find('(');
    const std::string name = trimmed(text_.substr(0, open));
    const auto function = std::find_if(kFunctions.begin(), kFunctions.end(),
                                       [&](const Function& f) { return f.name == name; });
    if (function == kFunctions.end()) {
      std::vector<std::string> functions;
      for (const Function& f : kFunctions) functions.emplace_back(f.name);
      const std::string near = nearest_name(name, functions);
      return fail(fmt::format("there is no function '{}'", name), "",
                  (near.empty() ? "" : fmt::format("did you mean '{}'? ", near)) + "there are " +
                      listed(functions));
    }
    if (text_.back() != ')' || text_.find_first_of("()", open + 1) != text_.size() - 1)
      return fail(fmt::format("the brackets of '{}' do not match", text_), "", function->usage);
    std::vector<std::string> arguments;
    std::size_t start = open + 1;
    while (true) {
      const auto comma = std::min(text_.find(',', start), text_.size() - 1);
      arguments.push_back(trimmed(text_.substr(start, comma - start)));
      if (comma == text_.size() - 1) break;
      start = comma + 1;
    }
    if (arguments.size() < function->least || arguments.size() > function->most ||
        index_of(arguments, "") >= 0)
      return fail(fmt::format("'{}' takes {}", name, function->takes), "", function->usage);
    if (name == "distance" || name == "origin_distance") return distance(name, arguments);
    if (name == "mass") return mass(arguments[0]);
    if (name == "inside") return inside(arguments);
    if (name == "event") return event(arguments);
    if (name == "open") return open_door(arguments[0]);
    return contact(name, arguments);
  }

  Parsed distance(const std::string& function, const std::vector<std::string>& arguments) const {
    const bool surfaces = function == "distance";
    std::vector<SignalPose> poses;
    std::vector<geometry::SurfaceSet> sets;
    std::vector<std::vector<int>> of;
    std::vector<std::string> full;
    for (const std::string& name : arguments) {
      full.push_back(resolved(name));
      const auto at = full.back().empty() ? std::nullopt : pose(full.back());
      if (!at) return wrong_argument(name, full.back(), "body, frame or assembly");
      poses.push_back(*at);
      if (!surfaces) continue;
      of.push_back(bodies(full.back()));
      sets.push_back(of.back().empty() ? geometry::SurfaceSet::of_point(at->body, at->X_BF)
                                       : geometry::SurfaceSet::of_bodies(model_, of.back()));
    }
    std::string text = fmt::format("{}({}, {})", function, full[0], full[1]);
    if (!surfaces) return origin_distance_term(std::move(text), poses[0], poses[1]);
    if (auto checked = disjoint(arguments, of[0], of[1]); !checked)
      return tl::unexpected(checked.error());
    return surface_distance_term(std::move(text), std::move(sets[0]), std::move(sets[1]));
  }

  Parsed mass(const std::string& name) const {
    const std::string full = resolved(name);
    std::vector<int> all = full.empty() ? std::vector<int>{} : bodies(full);
    if (all.empty()) return wrong_argument(name, full, "body or assembly");
    // A static body need not have a mass.
    all.erase(std::remove_if(
                  all.begin(), all.end(),
                  [&](int body) { return model_.bodies[at(body)].kind == BodyKind::static_body; }),
              all.end());
    if (all.empty()) return fail(fmt::format("'{}' is static and has no mass", name));
    return mass_term(fmt::format("mass({})", full), std::move(all));
  }

  Parsed inside(const std::vector<std::string>& arguments) const {
    const std::string full = resolved(arguments[0]);
    const auto at = full.empty() ? std::nullopt : pose(full);
    if (!at) return wrong_argument(arguments[0], full, "body, frame or assembly");
    const std::string name = resolved(arguments[1]);
    const int region = find_named(model_.regions, name);
    if (region < 0) return no_such(model_.regions, "region", arguments[1]);
    return inside_term(fmt::format("inside({}, {})", full, name), *at, region);
  }

  Parsed open_door(const std::string& name) const {
    const std::string full = resolved(name);
    const int door = find_named(model_.doors, full);
    if (door < 0) return no_such(model_.doors, "door", name);
    return open_term(fmt::format("open({})", full), door);
  }

  template <class Element>
  tl::unexpected<Error> no_such(const std::vector<Element>& elements, const std::string& what,
                                const std::string& name) const {
    std::vector<std::string> all;
    for (const Element& element : elements)
      if (!element.removed) all.push_back(element.name);
    const std::string near = nearest_name(name, all);
    return fail(fmt::format("there is no {} '{}'", what, name), "",
                !near.empty() ? fmt::format("did you mean '{}'?", near)
                : all.empty() ? fmt::format("the scene has no {}s", what)
                              : fmt::format("there are {}", listed(all)));
  }

  Parsed event(const std::vector<std::string>& arguments) const {
    const std::string& kind = arguments[0];
    const auto known = std::find_if(std::begin(kEventKinds), std::end(kEventKinds),
                                    [&](const EventKind& k) { return k.name == kind; });
    if (known == std::end(kEventKinds)) {
      std::vector<std::string> kinds;
      for (const EventKind& k : kEventKinds) kinds.emplace_back(k.name);
      const std::string near = nearest_name(kind, kinds);
      return fail(fmt::format("there is no kind of event '{}'", kind), "",
                  (near.empty() ? "" : fmt::format("did you mean '{}'? ", near)) + "there are " +
                      fmt::format("{}", fmt::join(kinds, ", ")));
    }
    std::vector<std::string> names;
    for (std::size_t i = 1; i < arguments.size(); ++i) {
      const std::string& name = arguments[i];
      const EventParty party = i == 1 ? known->source : known->subject;
      // Names that an event defines itself are used unchanged; templates have no signals.
      const std::string full = party == EventParty::name ? name : resolved(name);
      if (party == EventParty::region && find_named(model_.regions, full) < 0)
        return no_such(model_.regions, "region", name);
      if (party == EventParty::door && find_named(model_.doors, full) < 0)
        return no_such(model_.doors, "door", name);
      names.push_back(full.empty() ? name : full);
    }
    std::string text = "event(" + kind;
    for (const std::string& name : names) text += ", " + name;
    names.resize(2);
    return event_term(text + ")", kind, names[0], names[1]);
  }

  Result<> disjoint(const std::vector<std::string>& names, const std::vector<int>& a,
                    const std::vector<int>& b) const {
    std::vector<int> both;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    if (both.empty()) return {};
    return fail(fmt::format("'{}' and '{}' have body '{}' in common", names[0], names[1],
                            model_.bodies[at(both.front())].name));
  }

  Parsed contact(const std::string& function, const std::vector<std::string>& arguments) const {
    std::vector<std::vector<int>> sets;
    std::string text;
    for (const std::string& name : arguments) {
      const std::string full = resolved(name);
      sets.push_back(full.empty() ? std::vector<int>{} : bodies(full));
      if (sets.back().empty()) return wrong_argument(name, full, "body or assembly");
      text += (text.empty() ? "" : ", ") + full;
    }
    if (sets.size() == 1) sets.emplace_back();
    if (!sets[1].empty())
      if (auto checked = disjoint(arguments, sets[0], sets[1]); !checked)
        return tl::unexpected(checked.error());
    return contact_term(fmt::format("{}({})", function, text), sets[0], sets[1],
                        function == "force");
  }

  tl::unexpected<Error> wrong_argument(const std::string& name, const std::string& full,
                                       const std::string& wanted) const {
    const bool there =
        !full.empty() &&
        (find_joint(model_, full) >= 0 || find_assembly(model_, full) >= 0 ||
         find_named(model_.motors, full) >= 0 || find_named(model_.sensors, full) >= 0 ||
         find_named(model_.frames, full) >= 0);
    if (there) return fail(fmt::format("'{}' is no {}", name, wanted));
    return unknown(name);
  }

  const SignalScope& scope_;
  const SceneModel& model_;
  std::string text_;
  mutable bool late_ = false;  // the text has a name that may be added during the run
};

/// The channels of the frame, which include those of plugins, or else those of the built-in
/// sensors.
ChannelLookup channels_of(const Frame& frame) {
  if (!frame.channels) return built_in_channels(*frame.model);
  return [all = frame.channels](int sensor) -> const std::vector<Channel>* {
    const auto index = static_cast<std::size_t>(sensor);
    return index < all->size() ? (*all)[index].get() : nullptr;
  };
}

/// A signal whose text is resolved again in every model of the run.
struct LateTerm final : Signal::Node {
  double value(const Frame& frame) const override {
    const SignalNode node = in(frame);
    return node ? node->value(frame) : std::numeric_limits<double>::quiet_NaN();
  }

  SignalNode in(const Frame& frame) const {
    const std::lock_guard lock(mutex_);
    if (frame.model != known_) {
      const SignalScope scope{*frame.model, channels_of(frame), {}};
      const auto made = Parser(scope, text).parse();
      node_ = made ? *made : nullptr;
      known_ = frame.model;
    }
    return node_;
  }

 private:
  mutable std::mutex mutex_;
  mutable SceneModelPtr known_;
  mutable SignalNode node_;
};

Parsed Parser::late(const Parsed& now) const {
  auto term = std::make_shared<LateTerm>();
  if (now) {
    term->text = (*now)->text;
    term->unit = (*now)->unit;
    term->quantity = (*now)->quantity;
    term->needs = (*now)->needs;
    return SignalNode(std::move(term));
  }
  const auto open = text_.find('(');
  if (open != npos) {
    const std::string function = trimmed(text_.substr(0, open));
    const auto known = std::find_if(kFunctions.begin(), kFunctions.end(),
                                    [&](const Function& f) { return f.name == function; });
    if (known == kFunctions.end() || text_.back() != ')') return now;
    std::size_t arguments = 0;
    for (std::size_t start = open + 1; start < text_.size(); ++arguments) {
      const auto comma = std::min(text_.find(',', start), text_.size() - 1);
      const std::string name = trimmed(text_.substr(start, comma - start));
      const std::string full = name.empty() ? name : resolved(name);
      // A name that cannot be added during the run must exist.
      if (full.empty() || (!scope_.may_come(name) && !exists(full))) return now;
      term->text += (arguments == 0 ? function + "(" : ", ") + full;
      start = comma + 1;
    }
    if (arguments < known->least || arguments > known->most) return now;
    term->text += ")";
    term->quantity = function;
    term->unit = function == "mass" ? "kg" : function == "force" ? "N" : "1";
    if (function == "distance" || function == "origin_distance") term->unit = "m";
    term->needs.contacts = function == "contacts" || function == "force";
    return SignalNode(std::move(term));
  }
  const auto dot = text_.rfind('.');
  const std::string owner = text_.substr(0, dot);
  if (dot == npos || !scope_.may_come(owner)) return now;
  term->quantity = text_.substr(dot + 1);
  term->text = resolved(owner) + "." + term->quantity;
  const int which = index_of(kPoseQuantities, term->quantity);
  // Otherwise it is a joint or a sensor, whose unit is unknown until it exists.
  if (which >= 0) term->unit = pose_unit(which);
  return SignalNode(std::move(term));
}

}  // namespace

Result<SignalNode> parse_signal(const SignalScope& scope, const std::string& text) {
  return parse_arithmetic(
      trimmed(text), [&](const std::string& part) { return Parser(scope, trimmed(part)).parse(); });
}

Result<Signal> Signal::parse(const SignalScope& scope, const std::string& text) {
  if (text.size() > kLongestSignal)
    return fail(fmt::format("a signal of {} characters is too long", text.size()), "",
                fmt::format("the limit is {}", kLongestSignal));
  auto node = parse_signal(scope, text);
  if (!node) return tl::unexpected(node.error());
  return Signal(std::move(*node));
}

}  // namespace cogrsim
