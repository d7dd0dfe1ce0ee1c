#include "policy/card_draft.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

namespace cogrsim::policy {

namespace {

// The order in which a person writes the keys: as in the reference.
constexpr const char* kOrder[] = {
    "policy",           "robot",        "keyframe", "base",    "network",        "input",
    "output",           "state",        "rate",     "step",    "joints",         "default-pose",
    "observation-clip", "observations", "actions",  "command", "command-limits", "command-names",
    "fallen"};

constexpr const char* kActions[] = {
    "kind",         "scale",        "offset",        "clip",  "kp", "kd",
    "effort-limit", "stall-effort", "no-load-speed", "delay", "law"};

// Lines of at most 100 columns, broken behind spaces; those that follow are indented.
std::string wrapped(const std::string& line, std::size_t indent) {
  std::string out;
  std::size_t from = 0, width = 100;
  while (line.size() - from > width) {
    const std::size_t space = line.rfind(' ', from + width);
    if (space == std::string::npos || space <= from) break;
    out += line.substr(from, space - from) + '\n' + std::string(indent, ' ');
    from = space + 1;
    width = 100 - indent;
  }
  return out + line.substr(from) + '\n';
}

bool is_quoted(const std::string& text) { return text.find('"') != std::string::npos; }

// A line break within quotes would be read as a space, too, but not be what was said.
std::string entry(const std::string& line, std::size_t indent) {
  return is_quoted(line) ? line + '\n' : wrapped(line, indent);
}

}  // namespace

void DraftMap::set(const std::string& key, const std::string& value) {
  for (auto& [name, old] : values_) {
    if (name != key) continue;
    old = value;
    return;
  }
  values_.emplace_back(key, value);
}

void DraftMap::remove(const std::string& key) {
  values_.erase(std::remove_if(values_.begin(), values_.end(),
                               [&](const auto& each) { return each.first == key; }),
                values_.end());
}

const std::string* DraftMap::find(const std::string& key) const {
  for (const auto& [name, value] : values_)
    if (name == key) return &value;
  return nullptr;
}

void CardDraft::ask(const SourcePosition& at, const std::string& source_line,
                    const std::string& key, const std::string& reason, const std::string& answer) {
  Question q;
  q.locate(at);
  q.source_line = source_line;
  q.key = key;
  q.reason = reason;
  q.answer = answer;
  questions.push_back(std::move(q));
}

bool CardDraft::knows(const std::string& key) const {
  for (const std::string& each : answered)
    // "actions" answers "actions.kp", too.
    if (each == key || (key.size() > each.size() && key[each.size()] == '.' &&
                        key.compare(0, each.size(), each) == 0))
      return true;
  return false;
}

bool CardDraft::answer(const std::string& key, const std::string& value) {
  const auto put = [&](DraftMap& map, const std::string& name) {
    if (value == "~")
      map.remove(name);
    else
      map.set(name, value);
    answered.push_back(key);
    return true;
  };
  const std::size_t dot = key.find('.');
  const std::string first = key.substr(0, dot);
  if (std::find(std::begin(kOrder), std::end(kOrder), first) == std::end(kOrder) ||
      first == "policy")
    return false;
  if (dot == std::string::npos) return put(top, key);
  const std::string rest = key.substr(dot + 1);
  if (first == "actions" && rest.find('.') == std::string::npos && !rest.empty())
    return put(actions, rest);
  const std::size_t second = rest.find('.');
  if (first != "observations" || second == std::string::npos || second + 1 == rest.size())
    return false;
  const std::string term = rest.substr(0, second), setting = rest.substr(second + 1);
  for (std::size_t i = 0; i < observations.size(); ++i)
    if (observations[i].name == term || std::to_string(i) == term)
      return put(observations[i].settings, setting);
  return false;
}

std::string CardDraft::text() const {
  std::string out;
  for (const std::string& comment : comments) out += "# " + comment + '\n';
  const auto flow = [](const DraftMap& map) {
    std::string text;
    for (const auto& [key, value] : map.all())
      text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", key, value);
    return text;
  };
  for (const char* key : kOrder) {
    const std::string* value = top.find(key);
    if (std::string(key) == "policy") {
      out += "policy: 1\n";
    } else if (value) {
      out += entry(fmt::format("{}: {}", key, *value), 2);
    } else if (std::string(key) == "observations" && !observations.empty()) {
      out += "observations:\n";
      for (const DraftTerm& term : observations)
        out += term.settings.all().empty()
                   ? fmt::format("  - {}\n", term.name)
                   : entry(fmt::format("  - {}: {{{}}}", term.name, flow(term.settings)), 6);
    } else if (std::string(key) == "actions" && !actions.all().empty()) {
      out += "actions:\n";
      auto ordered = actions.all();
      const auto place = [](const auto& each) {
        return std::find(std::begin(kActions), std::end(kActions), each.first);
      };
      std::stable_sort(ordered.begin(), ordered.end(),
                       [&](const auto& a, const auto& b) { return place(a) < place(b); });
      for (const auto& [name, text] : ordered) out += entry(fmt::format("  {}: {}", name, text), 4);
    }
  }
  return out;
}

std::string number_text(double value) {
  const auto single = static_cast<float>(value);
  if (static_cast<double>(single) == value)
    return fmt::format("{}", single == 0.0f ? 0.0f : single);
  return fmt::format("{}", value);
}

std::string numbers_text(const std::vector<double>& values, bool shorten) {
  if (shorten && !values.empty() &&
      std::all_of(values.begin(), values.end(), [&](double v) { return v == values.front(); }))
    return number_text(values.front());
  std::string out;
  for (const double v : values) out += (out.empty() ? "" : " ") + number_text(v);
  return out;
}

std::string list_text(const std::vector<double>& values) {
  std::string out = "[";
  for (const double v : values) out += (out.size() == 1 ? "" : ", ") + number_text(v);
  return out + "]";
}

std::string value_text(const std::vector<double>& values) {
  const std::string text = numbers_text(values, true);
  return text.find(' ') == std::string::npos ? text : list_text(values);
}

std::string name_text(const std::string& name) {
  const bool plain =
      !name.empty() &&
      (std::isalpha(static_cast<unsigned char>(name.front())) || name.front() == '_') &&
      std::all_of(name.begin(), name.end(), [](unsigned char c) {
        return std::isalnum(c) || std::string("_./-+").find(char(c)) != std::string::npos;
      });
  static constexpr const char* kWords[] = {"true", "false", "null", "yes", "no",
                                           "on",   "off",   "y",    "n"};
  std::string lower = name;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (plain && std::find(std::begin(kWords), std::end(kWords), lower) == std::end(kWords))
    return name;
  std::string out = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + '"';
}

std::string names_text(const std::vector<std::string>& names) {
  std::string out = "[";
  for (const std::string& name : names) out += (out.size() == 1 ? "" : ", ") + name_text(name);
  return out + "]";
}

}  // namespace cogrsim::policy
