// From the text of a signal to what it means.
#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>

#include "arithmetic.h"
#include "cogrsim/signals/signal.h"
#include "node.h"
#include "parse.h"
#include "terms.h"

namespace cogrsim {
namespace {

constexpr std::size_t kMostListed = 16;      // names shown in a help
constexpr std::size_t kMostCompared = 4000;  // names compared with an unknown one

using Parsed = Result<SignalNode>;

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

template <class Words>
std::string listed(const Words& words) {
  std::string out;
  std::size_t shown = 0;
  for (const auto& word : words) {
    if (shown++ == kMostListed) return out + ", …";
    out += (out.empty() ? "" : ", ") + std::string(word);
  }
  return out;
}

template <class Words>
std::vector<std::string> strings(const Words& words) {
  return {words.begin(), words.end()};
}

template <class Words>
int index_of(const Words& words, const std::string& word) {
  const auto it = std::find(words.begin(), words.end(), word);
  return it == words.end() ? -1 : static_cast<int>(it - words.begin());
}

template <class Element>
int find_named(const std::vector<Element>& elements, const std::string& name) {
  for (std::size_t i = 0; i < elements.size(); ++i)
    if (!elements[i].removed && elements[i].name == name) return static_cast<int>(i);
  return -1;
}

// "word[12]" into "word" and 12. No bracket: no number; anything else in it: nullopt.
struct Indexed {
  std::string word;
  std::optional<int> index;
};
std::optional<Indexed> split_index(const std::string& word) {
  const auto open = word.find('[');
  if (open == std::string::npos) return Indexed{word, {}};
  int index = 0;
  const char* begin = word.data() + open + 1;
  const char* end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(begin, end, index);
  if (error != std::errc{} || index < 0 || rest + 1 != end || *rest != ']') return std::nullopt;
  return Indexed{word.substr(0, open), index};
}

class Parser {
 public:
  Parser(const SignalScope& scope, std::string text)
      : scope_(scope), model_(scope.model), text_(std::move(text)) {}

  Parsed parse() {
    if (text_.empty()) return fail("the signal is empty", "", kExamples);
    return text_.find('(') != std::string::npos ? call() : dotted();
  }

 private:
  static constexpr const char* kExamples =
      "write one such as time, robot.x, wheel.position, energy.total or distance(a, b)";

  // ---- names

  std::string resolved(const std::string& name) const {
    if (scope_.resolve) return scope_.resolve(name);
    return name;
  }

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
    return all;
  }

  // Compares with whole names and their ends, since names may be relative where they stand.
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
    // A rigid assembly and the body it is share a name.
    std::vector<std::string> shown;
    for (std::string& each : all)
      if (index_of(shown, each) < 0 && shown.size() <= kMostListed) shown.push_back(each);
    return fail(fmt::format("there is nothing named '{}'", name), "",
                near.empty() ? (all.empty() ? "the scene has no bodies, joints or sensors"
                                            : "there are " + listed(shown))
                             : fmt::format("did you mean '{}'?", near));
  }

  std::optional<SignalPlace> place(const std::string& full) const {
    if (const int body = find_body(model_, full); body >= 0) return SignalPlace{body, {}};
    if (const int frame = find_named(model_.frames, full); frame >= 0) {
      const NamedFrame& named = model_.frames[static_cast<std::size_t>(frame)];
      return SignalPlace{named.body, named.X_BF};
    }
    if (const int assembly = find_assembly(model_, full); assembly >= 0) {
      const std::vector<int> bodies = bodies_of(model_, assembly);
      if (!bodies.empty()) return SignalPlace{bodies.front(), {}};
    }
    return std::nullopt;
  }

  /// Whether the text, but for an index, is the name of something.
  bool names_element() const {
    const auto parts = split_index(text_);
    const std::string full = parts ? resolved(parts->word) : std::string();
    return !full.empty() &&
           (place(full) || find_joint(model_, full) >= 0 || find_named(model_.motors, full) >= 0 ||
            find_named(model_.sensors, full) >= 0);
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

  template <class Words>
  tl::unexpected<Error> no_quantity(const std::string& what, const std::string& quantity,
                                    const Words& words) const {
    const std::string near = nearest_name(quantity, strings(words));
    return fail(
        fmt::format("{} has no '{}'", what, quantity), "",
        (near.empty() ? "" : fmt::format("did you mean '{}'? ", near)) + "it has " + listed(words));
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
        // Of an assembly "robot", "robot.eye" is no quantity but a sensor in it.
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

  // nullopt: there is no element of that name.
  std::optional<Parsed> of_element(const std::string& full, const std::string& quantity) const {
    const std::string text = full + "." + quantity;
    if (const auto at = place(full)) {
      const int which = index_of(kPlaceQuantities, quantity);
      if (which >= 0) return place_term(text, *at, which);
      return Parsed(no_quantity(fmt::format("'{}'", full), quantity, kPlaceQuantities));
    }
    if (const int joint = find_joint(model_, full); joint >= 0)
      return of_joint(joint, quantity, text);
    if (const int motor = find_named(model_.motors, full); motor >= 0) {
      if (quantity == "effort") return motor_term(text, model_, motor);
      return Parsed(no_quantity(fmt::format("motor '{}'", full), quantity,
                                std::array<const char*, 1>{"effort"}));
    }
    if (const int sensor = find_named(model_.sensors, full); sensor >= 0)
      return of_sensor(sensor, quantity, text);
    if (find_assembly(model_, full) >= 0)
      return Parsed(fail(fmt::format("assembly '{}' has no body", full)));
    return std::nullopt;
  }

  Parsed of_joint(int index, const std::string& quantity, const std::string& text) const {
    const Joint& joint = model_.joints[static_cast<std::size_t>(index)];
    const std::string what =
        fmt::format("joint '{}' ({})", joint.name, cogrsim::to_string(joint.type));
    const auto parts = split_index(quantity);
    if (!parts) return bad_index();
    const int which = index_of(kJointQuantities, parts->word);
    if (which < 0) return no_quantity(what, parts->word, kJointQuantities);
    const int entries = joint_entries(joint, which);
    if (entries == 0) return fail(what + " cannot move, so it has no " + parts->word);
    const int entry = parts->index.value_or(0);
    if (!parts->index && entries > 1)
      return fail(fmt::format("{} has {} entries in '{}'", what, entries, parts->word), "",
                  fmt::format("say which one: {}[0] to {}[{}]", text, text, entries - 1));
    if (entry >= entries)
      return fail(fmt::format("{} has no {}[{}]", what, parts->word, entry), "",
                  entries == 1 ? "it has one, write '" + parts->word + "'"
                               : fmt::format("they are counted from 0 to {}", entries - 1));
    return joint_term(text, joint, index, which, entry);
  }

  Parsed of_sensor(int index, const std::string& quantity, const std::string& text) const {
    const std::string& name = model_.sensors[static_cast<std::size_t>(index)].name;
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

  // SENSOR[3], or a name without a quantity.
  Parsed whole_name(const std::string& owner, const std::string& quantity) const {
    const auto parts = split_index(text_);
    if (!parts) return bad_index();
    const std::string full = resolved(parts->word);
    const int sensor = full.empty() ? -1 : find_named(model_.sensors, full);
    if (sensor >= 0 && parts->index) return indexed_sensor(sensor, full, *parts->index);
    if (!full.empty() && (place(full) || find_joint(model_, full) >= 0 || sensor >= 0 ||
                          find_named(model_.motors, full) >= 0)) {
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
    if (static_cast<std::size_t>(channel) >= channels->size())
      return fail(fmt::format("sensor '{}' has no value number {}", full, channel), "",
                  fmt::format("it has {}, counted from 0", channels->size()));
    const Channel& found = (*channels)[static_cast<std::size_t>(channel)];
    return sensor_term(text, sensor, channel, found.name, found.unit);
  }

  std::string examples_of(const std::string& full) const {
    const auto with = [&](const auto& words) {
      std::string out;
      for (const auto& word : words)
        out += (out.empty() ? "" : ", ") + (text_ + "." + std::string(word));
      return out;
    };
    if (place(full)) return with(kPlaceQuantities);
    if (find_joint(model_, full) >= 0) return with(kJointQuantities);
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

  Parsed call() const {
    const auto open = text_.find('(');
    const std::string function = trimmed(text_.substr(0, open));
    const std::vector<std::string> functions = {"distance", "contacts", "force"};
    if (index_of(functions, function) < 0) {
      const std::string near = nearest_name(function, functions);
      return fail(fmt::format("there is no function '{}'", function), "",
                  (near.empty() ? "" : fmt::format("did you mean '{}'? ", near)) + "there are " +
                      listed(functions));
    }
    const bool far = function == "distance";
    const std::string usage =
        far ? "write distance(a, b)"
            : fmt::format("write {}(a, b), or {}(a) for what a touches", function, function);
    if (text_.back() != ')' || text_.find_first_of("()", open + 1) != text_.size() - 1)
      return fail(fmt::format("the brackets of '{}' do not match", text_), "", usage);
    std::vector<std::string> arguments;
    std::size_t start = open + 1;
    while (true) {
      const auto comma = std::min(text_.find(',', start), text_.size() - 1);
      arguments.push_back(trimmed(text_.substr(start, comma - start)));
      if (comma == text_.size() - 1) break;
      start = comma + 1;
    }
    const bool right = arguments.size() == 2 || (!far && arguments.size() == 1);
    if (!right || index_of(arguments, "") >= 0)
      return fail(fmt::format("'{}' takes the names of two things", function), "", usage);
    return far ? distance(arguments) : contact(function, arguments);
  }

  Parsed distance(const std::vector<std::string>& arguments) const {
    std::vector<SignalPlace> places;
    std::vector<std::string> full;
    for (const std::string& name : arguments) {
      full.push_back(resolved(name));
      const auto at = full.back().empty() ? std::nullopt : place(full.back());
      if (!at) return wrong_argument(name, full.back(), "body, frame or assembly");
      places.push_back(*at);
    }
    return distance_term(fmt::format("distance({}, {})", full[0], full[1]), places[0], places[1]);
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
    std::vector<int> both;
    std::set_intersection(sets[0].begin(), sets[0].end(), sets[1].begin(), sets[1].end(),
                          std::back_inserter(both));
    if (!both.empty())
      return fail(fmt::format("'{}' and '{}' have body '{}' in common", arguments[0], arguments[1],
                              model_.bodies[static_cast<std::size_t>(both.front())].name));
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
};

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
