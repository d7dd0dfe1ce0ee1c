#include <algorithm>
#include <cctype>
#include <unordered_map>

#include "expand/expand_scene.h"

namespace cogrsim::dsl {
namespace {

constexpr std::size_t kMaxPathBytes = std::size_t{64} << 20;

// Bodies, materials and so on have separate name spaces: a crate may be called "wood".
int name_space(std::string_view tag) { return tag == "material" ? 1 : 0; }

struct KeyHash {
  std::size_t operator()(const std::pair<int, std::string_view>& key) const {
    return std::hash<std::string_view>()(key.second) * 2 + static_cast<std::size_t>(key.first);
  }
};

bool takes_name(const Element& element) {
  const AttributeSpec* spec =
      element.node->spec != nullptr ? element.node->spec->find("name") : nullptr;
  return element.tag() == "import" || (spec != nullptr && spec->kind == Kind::name);
}

std::string base_name(const Element& element) {
  if (element.tag() == "controller" && element.find("connect") != nullptr) return "socket";
  if (element.tag() == "controller" || element.tag() == "supervisor")
    if (const Attribute* plugin = element.find("plugin"); plugin != nullptr) {
      const bool plain = std::all_of(plugin->value.begin(), plugin->value.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
      });
      if (plain && !plugin->value.empty()) return std::string(plugin->value);
    }
  return std::string(element.tag());
}

}  // namespace

// Written names first, so that a generated one never takes a name that is written further down.
void Expander::name_children(Element& parent) {
  if (full_) return;
  std::unordered_map<std::pair<int, std::string_view>, const Element*, KeyHash> taken;
  taken.reserve(parent.children.size());
  std::vector<Element*> unique;
  unique.reserve(parent.children.size());
  for (Element* child : parent.children) {
    if (!child->name.empty()) {
      if (child->name == "world" && parent.parent == nullptr && name_space(child->tag()) == 0)
        context_.sink.report("CG0403", *child, "name", "'world' is reserved for the world itself")
            .help("choose another name");
      const auto [at, is_new] = taken.try_emplace({name_space(child->tag()), child->name}, child);
      if (!is_new) {
        parent.incomplete = true;
        const Element& first = *at->second;
        const std::string where = parent.path.empty() ? "the scene" : "'" + parent.path + "'";
        auto report =
            context_.sink.report("CG0401", *child, child->tag() == "import" ? "as" : "name",
                                 "the name '" + child->name + "' is taken in " + where);
        report.note("first given to this " + std::string(first.tag()), first.span());
        if (first.node == child->node)
          report.help("make the name depend on the iteration: name=\"" + child->name + "_${i}\"");
        continue;
      }
    }
    unique.push_back(child);
  }
  parent.children = std::move(unique);

  // A template is a scope of its own.
  const std::string around = parent.tag() == "template" ? "" : parent.path;
  std::unordered_map<std::string, int> counts;
  for (Element* child : parent.children) {
    if (child->name.empty() && takes_name(*child)) {
      const std::string base = base_name(*child);
      // A controller has the name of its plugin; other elements are numbered from 1.
      const bool numbered = base == child->tag();
      int& count = counts[base];
      do {
        ++count;
        child->name = count == 1 && !numbered ? base : base + "_" + std::to_string(count);
      } while (taken.count({name_space(child->tag()), child->name}) != 0);
    }
    const std::string own =
        child->name.empty() ? "(" + std::string(child->tag()) + ")" : child->name;
    child->path = around.empty() ? own : around + "." + own;
    path_bytes_ += child->path.size();
    if (path_bytes_ > kMaxPathBytes) {
      if (!full_)
        context_.sink.report("CG0306", *child, "the names of all elements together are too long")
            .help("shorten the names of elements with much content");
      full_ = true;
      return;
    }
    child->index = context_.element_count++;
    name_children(*child);
  }
}

}  // namespace cogrsim::dsl
