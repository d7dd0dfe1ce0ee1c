#include "policy/yaml_text.h"

#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <set>
#include <sstream>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "cogrsim/core/shown_text.h"

namespace cogrsim::policy {
namespace {

constexpr std::size_t kLongestText = 1u << 20;
constexpr int kDeepest = 16;

// Ends the parsing where a text would cost more than a card can need: aliases, of which a few lines can
// stand for more values than there is memory, and depth.
struct Bounds final : YAML::EventHandler {
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    if (aliases) return;
    throw YAML::Exception(mark, "aliases are not read: write the value again");
  }
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    deeper(mark);
  }
  void OnSequenceEnd() override { --depth; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    deeper(mark);
  }
  void OnMapEnd() override { --depth; }
  void deeper(const YAML::Mark& mark) {
    if (++depth > kDeepest)
      throw YAML::Exception(mark, fmt::format("nested deeper than {}", kDeepest));
  }
  int depth = 0;
  bool aliases = false;
};

std::string shown(const std::string& text) { return one_line(text.substr(0, 60)); }

}  // namespace

void add_source_line(Diagnostic& finding, const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  for (int i = 0; i < finding.line && std::getline(lines, line); ++i) {
  }
  if (!line.empty() && line.back() == '\r') line.pop_back();
  if (finding.line > 0 && line.size() < 1000) finding.source_line = line;
}

bool YamlText::parse() {
  Diagnostic d;
  d.file = file_;
  d.code = "CG1501";
  try {
    if (text_.size() > kLongestText)
      throw YAML::Exception(YAML::Mark::null_mark(), "it has more than 1 MB");
    std::istringstream bounded(text_);
    Bounds bounds;
    bounds.aliases = aliases_;
    YAML::Parser(bounded).HandleNextDocument(bounds);
    root_ = YAML::Load(text_);
    if (root_.IsMap()) return true;
    d.message = "the file is no YAML map of keys and values";
  } catch (const YAML::Exception& e) {
    d.message = "the file cannot be read: " + one_line(e.msg);
    if (!e.mark.is_null()) {
      d.line = e.mark.line + 1;
      d.column = e.mark.column + 1;
      d.length = 1;
    }
  }
  add_source_line(d, text_);
  found.push_back(d);
  return false;
}

namespace {

// The name of an entry of a list: "- command", or "- command: {scale: 2}".
std::string name_of(const YAML::Node& entry) {
  if (entry.IsScalar()) return entry.Scalar();
  return entry.IsMap() && entry.size() == 1 ? entry.begin()->first.Scalar() : "";
}

// False: there is no such place. Nodes are handles: a copy changes the tree.
bool put(YAML::Node in, const std::string& key, const YAML::Node& value) {
  const std::size_t dot = key.find('.');
  const std::string first = key.substr(0, dot);
  const bool last = dot == std::string::npos;
  if (first.empty() || !(in.IsMap() || in.IsSequence())) return false;
  if (in.IsMap()) {
    if (last) {
      if (value.IsNull())
        in.remove(first);
      else
        in[first] = value;
      return true;
    }
    if (!in[first].IsDefined() || in[first].IsNull()) in[first] = YAML::Node(YAML::NodeType::Map);
    return put(in[first], key.substr(dot + 1), value);
  }
  for (std::size_t i = 0; i < in.size(); ++i) {
    const bool named = !in[i].IsSequence() && name_of(in[i]) == first;
    if (!named && first != std::to_string(i)) continue;
    if (last) {
      in[i] = value;
      return true;
    }
    const std::string name = name_of(in[i]);
    if (name.empty()) return put(in[i], key.substr(dot + 1), value);
    if (!in[i].IsMap() || in[i][name].IsNull()) {
      YAML::Node entry(YAML::NodeType::Map);
      entry[name] = YAML::Node(YAML::NodeType::Map);
      in[i] = entry;
    }
    return put(in[i][name], key.substr(dot + 1), value);
  }
  return false;
}

}  // namespace

void YamlText::change(const std::string& key, const std::string& value) {
  YamlText given(file_, "value: " + value);
  if (!given.parse()) {
    found.insert(found.end(), given.found.begin(), given.found.end());
    return;
  }
  if (std::count(key.begin(), key.end(), '.') <= kDeepest && given.root().size() == 1 &&
      put(root_, key, given.root()["value"]))
    return;
  Diagnostic d;
  d.file = file_;
  d.code = "CG1502";
  d.message = fmt::format("a card has no '{}' that could be set", shown(key));
  d.help = "name a key, such as actions.delay or observations.command.scale";
  found.push_back(std::move(d));
}

SourcePosition YamlText::at(const YAML::Node& node) const {
  SourcePosition out;
  out.file = file_;
  const YAML::Mark mark = node.Mark();
  if (mark.is_null()) return out;
  out.line = mark.line + 1;
  out.column = mark.column + 1;
  out.length = node.IsScalar() ? std::max(1, static_cast<int>(node.Scalar().size())) : 1;
  return out;
}

void YamlText::error(const YAML::Node& node, const char* code, const std::string& message,
                     const std::string& help) {
  Diagnostic d;
  d.locate(at(node));
  d.code = code;
  d.message = message;
  d.help = help;
  add_source_line(d, text_);
  found.push_back(std::move(d));
}

void YamlText::check_keys(const YAML::Node& map, const std::vector<std::string>& known,
                          const std::string& of) {
  std::set<std::string> seen;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) {
      error(entry.first, "CG1502", "a key of " + of + " is no word");
      continue;
    }
    const std::string key = entry.first.Scalar();
    if (!seen.insert(key).second)
      error(entry.first, "CG1502", fmt::format("'{}' stands twice", shown(key)));
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string near = nearest_name(key, known);
    std::string all;
    for (const std::string& name : known) all += (all.empty() ? "" : ", ") + name;
    error(entry.first, "CG1502", fmt::format("{} has no '{}'", of, shown(key)),
          near.empty() ? "it has " + all : fmt::format("did you mean '{}'?", near));
  }
}

YAML::Node YamlText::required(const YAML::Node& map, const std::string& key,
                              const std::string& help) {
  const YAML::Node node = map[key];
  if (node.IsDefined()) return node;
  error(map, "CG1504", fmt::format("'{}' is missing", key), help);
  return YAML::Node(YAML::NodeType::Undefined);
}

std::optional<std::string> YamlText::word(const YAML::Node& node, const std::string& what) {
  if (!node.IsDefined()) return std::nullopt;
  if (node.IsScalar() && !node.Scalar().empty()) return node.Scalar();
  error(node, "CG1503", what + " is one word or text");
  return std::nullopt;
}

std::optional<std::vector<std::string>> YamlText::words(const YAML::Node& node,
                                                        const std::string& what) {
  if (!node.IsDefined()) return std::nullopt;
  std::vector<std::string> out;
  if (node.IsSequence() && node.size() <= 10000) {
    for (const auto& each : node) {
      const auto name = word(each, what);
      if (!name) return std::nullopt;
      out.push_back(*name);
    }
    return out;
  }
  error(node, "CG1503", what + " is a list" + (node.IsSequence() ? " of at most 10000" : ""));
  return std::nullopt;
}

std::optional<bool> YamlText::truth(const YAML::Node& node, const std::string& what) {
  if (!node.IsDefined()) return std::nullopt;
  if (node.IsScalar() && (node.Scalar() == "true" || node.Scalar() == "false"))
    return node.Scalar() == "true";
  error(node, "CG1503", what + " is true or false");
  return std::nullopt;
}

std::optional<std::vector<double>> YamlText::quantities(
    const YAML::Node& node, const std::vector<units::Dimension>& allowed, const std::string& what) {
  if (!node.IsDefined()) return std::nullopt;
  std::string wanted;
  for (const units::Dimension& d : allowed)
    wanted += (wanted.empty() ? "" : " or ") + units::describe(d);
  std::vector<YAML::Node> parts;
  if (node.IsSequence())
    for (const auto& each : node) parts.push_back(each);
  else
    parts.push_back(node);
  std::vector<double> out;
  for (const YAML::Node& part : parts) {
    if (!part.IsScalar()) {
      error(part, "CG1503", fmt::format("{} is a list of numbers", what));
      return std::nullopt;
    }
    std::istringstream tokens(part.Scalar());
    std::vector<double> numbers;
    std::string token;
    std::optional<units::Unit> unit;
    while (tokens >> token) {
      if (const auto number = units::parse_number(token); number && !unit) {
        numbers.push_back(*number);
      } else if (!unit && !numbers.empty() && (unit = units::parse_unit(token))) {
      } else {
        const std::string near = units::nearest_unit(token);
        error(
            part, "CG1503",
            fmt::format("'{}' is no number{}", shown(token), numbers.empty() ? "" : " and no unit"),
            near.empty() || numbers.empty() ? fmt::format("{} is {}", what, wanted)
                                            : fmt::format("did you mean '{}'?", near));
        return std::nullopt;
      }
    }
    if (numbers.empty()) {
      error(part, "CG1503", fmt::format("{} is {}", what, wanted));
      return std::nullopt;
    }
    const bool angle = std::any_of(allowed.begin(), allowed.end(), [](const units::Dimension& d) {
      return units::unit_of(d) == "rad";
    });
    const bool zero =
        std::all_of(numbers.begin(), numbers.end(), [](double x) { return x == 0.0; });
    if (!unit && angle && !zero) {
      error(part, "CG1503", fmt::format("{}: an angle needs its unit", what),
            fmt::format("write \"{} rad\" or \"{} deg\"", part.Scalar(), part.Scalar()));
      return std::nullopt;
    }
    if (unit && std::none_of(allowed.begin(), allowed.end(), [&](const units::Dimension& d) {
          return units::fits(unit->dimension, d);
        })) {
      error(
          part, "CG1503",
          fmt::format("{} is {}, and this is {}", what, wanted, units::describe(unit->dimension)));
      return std::nullopt;
    }
    for (const double number : numbers) out.push_back(unit ? unit->to_si(number) : number);
    if (out.size() > 10000) {
      error(part, "CG1503", fmt::format("{} has over 10000 numbers", what));
      return std::nullopt;
    }
  }
  return out;
}

std::optional<double> YamlText::quantity(const YAML::Node& node, const units::Dimension& dimension,
                                         const std::string& what) {
  const auto all = quantities(node, {dimension}, what);
  if (!all) return std::nullopt;
  if (all->size() == 1) return all->front();
  error(node, "CG1503", fmt::format("{} is one number", what));
  return std::nullopt;
}

}  // namespace cogrsim::policy
