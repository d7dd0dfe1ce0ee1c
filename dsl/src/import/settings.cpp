#include "import/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

namespace cogrsim::dsl::import {

namespace {

void for_each_word(std::string_view words, const std::function<void(std::string_view)>& use) {
  while (!words.empty()) {
    const std::size_t end = std::min(words.find(' '), words.size());
    use(words.substr(0, end));
    words.remove_prefix(std::min(end + 1, words.size()));
  }
}

using Key = std::pair<std::string_view, std::string_view>;  // element, setting

struct Found {
  const Settings* kind = nullptr;
  Source at;
  std::size_t count = 0;
};

void count(const XmlElement& e, std::map<Key, Found>& all, int depth) {
  if (depth > 200) return;  // a reader refuses it
  const auto note = [&](const std::string& name, const std::string& value, const Source& at) {
    const auto known = all.find({e.name, name});
    if (known == all.end() || value.empty() || value == known->second.kind->plain) return;
    if (known->second.count++ == 0) known->second.at = at;
  };
  for (const auto& [name, value] : e.attributes) note(name, value, e.at);
  for (const auto& c : e.children) {
    note(c->name, c->text, c->at);
    count(*c, all, depth + 1);
  }
}

}  // namespace

void report_settings(Context& context, const XmlElement& root,
                     std::initializer_list<Settings> kinds) {
  std::map<Key, Found> all;
  for (const Settings& kind : kinds)
    for_each_word(kind.elements, [&](std::string_view element) {
      for_each_word(kind.names, [&](std::string_view name) { all[{element, name}].kind = &kind; });
    });
  count(root, all, 0);
  for (const auto& [key, found] : all)
    if (found.count > 0)
      context.left_out(found.at,
                       found.count == 1
                           ? fmt::format("{} of <{}>", key.second, key.first)
                           : fmt::format("{} of {} <{}>", key.second, found.count, key.first),
                       std::string(found.kind->reason));
}

}  // namespace cogrsim::dsl::import
