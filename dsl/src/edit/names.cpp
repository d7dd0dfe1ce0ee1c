// Names in the file follow their elements.
#include <algorithm>
#include <cctype>
#include <set>

#include "edit/edit_scene.h"
#include "values/number_list.h"

namespace cogrsim::dsl {
namespace {

std::vector<std::string> parts_of(const std::string& dotted) {
  std::vector<std::string> out;
  std::size_t begin = 0;
  while (true) {
    const std::size_t dot = dotted.find('.', begin);
    out.push_back(dotted.substr(begin, dot - begin));
    if (dot == std::string::npos) return out;
    begin = dot + 1;
  }
}

bool starts_word(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool in_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.';
}

/// Whether an attribute's text may contain names of elements.
bool may_name(const EditElement& element, const EditAttribute& attribute) {
  const ElementSpec* spec = spec_of(element);
  if (spec == nullptr) return false;
  const AttributeSpec* a = spec->find(attribute.name);
  if (a == nullptr) return spec->name == "set";
  if (a->kind == Kind::reference || a->kind == Kind::references) return true;
  if (a->kind != Kind::text) return false;
  static const std::set<std::string_view> kProse = {"name",     "title", "label",  "message",
                                                    "reason",   "doc",   "plugin", "backend",
                                                    "backends", "file"};
  return kProse.count(a->name) == 0;
}

/// Whether `word` is `name`, or continues after a dot.
bool begins_with(const std::string& word, const std::string& name) {
  return word.compare(0, name.size(), name) == 0 &&
         (word.size() == name.size() || word[name.size()] == '.');
}

}  // namespace

EditElement* SceneEditor::scope_of(const EditElement& element) {
  EditElement* up = element.parent;
  while (up != nullptr && up->parent != nullptr && is_flow(*up)) up = up->parent;
  return up;
}

std::string SceneEditor::name_of(const EditElement& element) const {
  const EditAttribute* written = element.find(element.tag == "import" ? "as" : "name");
  return written != nullptr ? written->value() : item(element).name;
}

std::vector<SceneEditor::Use> SceneEditor::uses() const {
  std::vector<Use> out;
  for (const Analysis::Use& use : analysis_.uses) {
    Use made;
    made.from = nodes_[use.from];
    made.text = use.text;
    for (const int id : use.chain) made.chain.push_back(id < 0 ? nullptr : nodes_[id]);
    if (made.chain.empty()) continue;
    made.follows = nests(made, made.anchored);
    out.push_back(std::move(made));
  }
  return out;
}

// A name is found in a scope around the element, then goes in from scope to scope.
bool SceneEditor::nests(const Use& use, std::size_t& anchored) const {
  anchored = 0;
  const EditElement* first = use.chain.front();
  if (first == nullptr) return false;
  const EditElement* scope = scope_of(*first);
  const bool found = scope != nullptr && use.from->is_inside(*scope);
  for (std::size_t i = 0; i < use.chain.size(); ++i) {
    if (use.chain[i] == nullptr) break;
    if (i > 0 && scope_of(*use.chain[i]) != use.chain[i - 1]) break;
    // An element made by a maze or door represents its maker, which is found once.
    if (i > 0 && use.chain[i] == use.chain[i - 1]) break;
    anchored = i + 1;
  }
  return found;
}

Result<> SceneEditor::follow(std::vector<Use> before,
                             const std::map<EditElement*, EditElement*>& successors) {
  std::map<EditElement*, std::map<std::string, std::string>> changes;
  std::map<EditElement*, std::vector<std::string>> all;
  for (Use& use : before) {
    if (!alive(*use.from)) continue;
    all[use.from].push_back(use.text);
    std::vector<std::string> words = parts_of(use.text);
    if (words.size() != use.chain.size()) continue;
    const std::string old = use.text;
    const std::size_t once_anchored = use.anchored;
    // Removed elements are left out; at the end of a chain they may have a successor.
    std::size_t gone = 0;
    for (std::size_t i = 0; i < use.chain.size();) {
      const auto successor =
          use.chain[i] != nullptr ? successors.find(use.chain[i]) : successors.end();
      if (successor == successors.end()) {
        ++i;
      } else if (i + 1 == use.chain.size()) {
        use.chain[i] = successor->second;
        words[i] = name_of(*successor->second);
        ++i;
      } else {
        use.chain.erase(use.chain.begin() + static_cast<std::ptrdiff_t>(i));
        words.erase(words.begin() + static_cast<std::ptrdiff_t>(i));
        ++gone;
      }
    }
    if (std::any_of(use.chain.begin(), use.chain.end(),
                    [&](EditElement* e) { return e != nullptr && !alive(*e); }))
      continue;
    for (std::size_t i = 0; i < use.chain.size(); ++i) {
      if (use.chain[i] == nullptr || (i > 0 && use.chain[i] == use.chain[i - 1])) continue;
      const EditAttribute* written =
          use.chain[i]->find(use.chain[i]->tag == "import" ? "as" : "name");
      if (written != nullptr && written->value().find("${") == std::string::npos)
        words[i] = written->value();
    }
    std::size_t anchored = 0;
    const bool found = nests(use, anchored);
    const std::size_t wanted = once_anchored - std::min(once_anchored, gone);
    if (use.follows && (!found || anchored < wanted) && wanted > 0) {
      // Named again, from the nearest scope around both.
      std::vector<std::string> path;
      for (EditElement* at = use.chain[wanted - 1]; at != nullptr; at = scope_of(*at)) {
        const std::string name = at == use.chain[wanted - 1] ? words[wanted - 1] : name_of(*at);
        if (name.empty() || name.find("${") != std::string::npos || at->tag == "prototype" ||
            at->tag == "template")
          return fail(called(*use.from) + " could no longer name '" + old + "'", "",
                      "change what refers to it first");
        path.insert(path.begin(), name);
        const EditElement* scope = scope_of(*at);
        if (scope == nullptr || use.from->is_inside(*scope)) break;
      }
      words.erase(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(wanted));
      words.insert(words.begin(), path.begin(), path.end());
    }
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : ".") + word;
    if (text != old) changes[use.from][old] = text;
  }
  for (auto& [from, texts] : changes)
    if (auto good = rewrite(*from, texts, all[from]); !good) return good;
  return {};
}

// Words are processed once, so that one change is never taken for the next one's old text.
Result<> SceneEditor::rewrite(EditElement& from, const std::map<std::string, std::string>& texts,
                              const std::vector<std::string>& all) {
  std::set<std::string> hit;
  for (EditAttribute& a : from.attributes) {
    if (!may_name(from, a)) continue;
    const ElementSpec* spec = spec_of(from);
    const AttributeSpec* kind = spec != nullptr ? spec->find(a.name) : nullptr;
    const bool whole_words =
        kind == nullptr || kind->kind == Kind::reference || kind->kind == Kind::references;
    std::string out;
    for (std::size_t i = 0; i < a.raw.size();) {
      if (a.raw.compare(i, 2, "${") == 0) {
        const std::size_t end = std::min(expression_end(a.raw, i), a.raw.size());
        out += a.raw.substr(i, end - i);
        i = end;
        continue;
      }
      // A word that an expression is a part of is left alone.
      if (!starts_word(a.raw[i]) || (i > 0 && (in_word(a.raw[i - 1]) || a.raw[i - 1] == '}'))) {
        out += a.raw[i++];
        continue;
      }
      std::size_t end = i;
      while (end < a.raw.size() && in_word(a.raw[end])) ++end;
      std::string word = a.raw.substr(i, end - i);
      i = end;
      const bool made = a.raw.compare(end, 2, "${") == 0;
      const std::string* best = nullptr;
      for (const std::string& one : all)
        if ((whole_words ? word == one : begins_with(word, one)) &&
            (best == nullptr || one.size() > best->size()))
          best = &one;
      if (best != nullptr && !made) {
        const auto change = texts.find(*best);
        if (change != texts.end()) {
          hit.insert(*best);
          word = change->second + word.substr(best->size());
        }
      }
      out += word;
    }
    a.raw = std::move(out);
  }
  for (const auto& [old, text] : texts)
    if (hit.count(old) == 0)
      return fail(called(from) + " names '" + old + "' through an expression",
                  "line " + std::to_string(line_of(from)), "change it there first");
  return {};
}

Result<> SceneEditor::check_meaning(const std::vector<Use>& before,
                                    const std::map<EditElement*, EditElement*>& successors) {
  std::set<std::pair<const EditElement*, const EditElement*>> now;
  for (const Use& use : uses()) now.emplace(use.from, use.target());
  for (const Use& use : before) {
    if (use.target() == nullptr || !alive(*use.from)) continue;
    const auto successor = successors.find(use.target());
    const EditElement* target = successor != successors.end() ? successor->second : use.target();
    if (!alive(*target)) continue;
    if (now.count({use.from, target}) == 0)
      return fail("then '" + use.text + "' in " + called(*use.from) + " would mean something else",
                  "line " + std::to_string(line_of(*use.from)), "choose another name or parent");
  }
  return {};
}

std::string SceneEditor::fresh_name(const EditElement& scope, const std::string& wanted,
                                    bool material, const EditElement* except) const {
  std::set<std::string> taken;
  std::vector<const EditElement*> open{&scope};
  while (!open.empty()) {
    const EditElement* at = open.back();
    open.pop_back();
    for (const auto& child : at->children) {
      if (is_flow(*child)) open.push_back(child.get());
      if (child.get() == except || (child->tag == "material") != material) continue;
      if (child->tag == "test" || child->tag == "param") continue;
      taken.insert(name_of(*child));
    }
  }
  if (scope.parent == nullptr && !material) taken.insert("world");
  if (taken.count(wanted) == 0) return wanted;
  std::string base = wanted;
  const std::size_t line = base.rfind('_');
  if (line != std::string::npos && line > 0 && line + 1 < base.size() &&
      base.find_first_not_of("0123456789", line + 1) == std::string::npos)
    base.erase(line);
  for (int number = 2;; ++number) {
    std::string name = base + "_" + std::to_string(number);
    if (taken.count(name) == 0) return name;
  }
}

}  // namespace cogrsim::dsl
