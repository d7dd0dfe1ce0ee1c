#include "build/resolve_names.h"

#include "edit/outline_notes.h"
#include "language/vocabulary.h"

namespace cogrsim::dsl {
namespace {

constexpr int kMaxExports = 16;                // one export may name another
constexpr std::size_t kMaxSuggestions = 4000;  // names compared with an unknown one
constexpr std::size_t kMaxHelped = 50;         // unknown names that get such help

bool is_matter(std::string_view tag) {
  return is_shape(tag) || tag == "body" || tag == "assembly" || tag == "instance";
}

bool matches(const Element& element, Wanted wanted) {
  switch (wanted) {
    case Wanted::posed:
      return is_matter(element.tag()) || element.tag() == "frame";
    case Wanted::matter:
      return is_matter(element.tag());
    case Wanted::joint:
      return is_joint(element.tag());
    case Wanted::material:
      return element.tag() == "material";
    case Wanted::any:
      return true;
  }
  return false;
}

const char* describe(Wanted wanted) {
  switch (wanted) {
    case Wanted::posed:
      return "body, assembly or frame";
    case Wanted::matter:
      return "body or assembly";
    case Wanted::joint:
      return "joint";
    case Wanted::material:
      return "material";
    case Wanted::any:
      return "element";
  }
  return "";
}

}  // namespace

std::string kind_of(const Element& element) {
  const std::string tag(element.tag());
  const bool vowel = tag.find_first_of("aeio") == 0;
  return (vowel ? "an " : "a ") + tag;
}

Names::Names(CompileContext& context, const Element& root) : context_(context) {
  index(root);
  // A template sees the materials around it.
  for (const Element* around = root.parent; around != nullptr; around = around->parent)
    for (const Element* c : around->children)
      if (c->tag() == "material" || c->tag() == "import") {
        materials_[around].emplace(c->name, c);
        if (c->tag() == "import") index(*c);
      }
}

void Names::index(const Element& element) {
  for (const Element* c : element.children) {
    if (!c->name.empty()) {
      (c->tag() == "material" ? materials_ : things_)[&element].emplace(c->name, c);
      all_.push_back(c);
    }
    // An import gives access to materials only.
    if (c->tag() == "import") materials_[&element].emplace(c->name, c);
    // The content of a template is not in the scene yet, and has its own names.
    if (c->tag() != "template") index(*c);
  }
}

const Element* Names::child(const Element& scope, std::string_view name, bool materials) const {
  const auto& table = materials ? materials_ : things_;
  if (const auto s = table.find(&scope); s != table.end())
    if (const auto it = s->second.find(name); it != s->second.end()) return it->second;
  return nullptr;
}

bool Names::may_be_lost(const Element& scope, std::string_view name) const {
  if (scope.incomplete) return true;
  const auto it = context_.lost_names.find(&scope);
  return it != context_.lost_names.end() && it->second.count(name) != 0;
}

Names::Walk Names::walk(const Element& scope, std::string_view dotted, bool materials, int depth,
                        Chain* chain) const {
  const Element* at = &scope;
  while (true) {
    const std::size_t dot = dotted.find('.');
    const std::string_view first = dotted.substr(0, dot);
    const bool last = dot == std::string_view::npos;
    const Element* next = child(*at, first, materials);
    // A material may be inside an assembly.
    if (next == nullptr && materials && !last) next = child(*at, first, false);
    if (next == nullptr) return {nullptr, may_be_lost(*at, first)};
    if (chain != nullptr) chain->push_back(next);
    if (next->tag() == "export" && depth < kMaxExports) {
      const Attribute* of = next->find("of");
      if (of == nullptr) return {nullptr, true};
      const Walk inside = walk(*at, of->value, materials, depth + 1);
      if (inside.found == nullptr) return {nullptr, true};  // reported at the export
      next = inside.found;
    }
    if (last) return {next, false};
    at = next;
    dotted.remove_prefix(dot + 1);
  }
}

// The walk is repeated here, so that compilations without editing do not pay for it.
void Names::note_use(const Element& from, const SourceSpan& span, std::string_view text,
                     const Element& scope, bool materials) const {
  OutlineNotes::Use use{&from, span, std::string(text), {}};
  walk(scope, text, materials, 0, &use.chain);
  context_.outline->uses.push_back(std::move(use));
}

std::vector<std::string> Names::known(const Element& from, Wanted wanted) const {
  std::vector<std::string> names;
  for (const Element* level = from.parent; level != nullptr; level = level->parent) {
    for (const Element* c : level->children) {
      if (names.size() >= kMaxSuggestions) return names;
      if (!c->name.empty() && matches(*c, wanted)) names.push_back(c->name);
    }
  }
  for (const Element* c : all_) {
    if (names.size() >= kMaxSuggestions) break;
    if (matches(*c, wanted) && c->path.find('.') != std::string::npos) names.push_back(c->path);
  }
  return names;
}

/// The help for a name whose last part is that of something further inside, as a frame in a body of an
/// instance; empty: there is none.
std::string Names::deeper(const Element& from, std::string_view name, Wanted wanted) const {
  constexpr std::size_t kMostListed = 4;
  const std::string first(
      name.substr(0, name.find('.') + 1));  // "arm." of "arm.tip"; empty: no dot
  const std::string_view last = name.substr(name.rfind('.') + 1);
  std::vector<std::string> found;
  const Element* one = nullptr;
  for (const Element* c : all_) {
    if (c->name != last || !matches(*c, wanted) || found.size() > kMostListed) continue;
    // As it is written here: from the nearest scope around both.
    std::string written = c->path;
    for (const Element* level = from.parent; level != nullptr && !level->path.empty();
         level = level->parent)
      if (c->path.rfind(level->path + ".", 0) == 0) {
        written = c->path.substr(level->path.size() + 1);
        break;
      }
    if (written.rfind(first, 0) != 0 || written == name) continue;
    found.push_back(written);
    one = c;
  }
  if (found.empty() || found.size() > kMostListed) return {};
  std::string out;
  for (const std::string& each : found) out += (out.empty() ? "\"" : ", \"") + each + "\"";
  if (found.size() > 1) return "names are written with all scopes around them: one of " + out;
  return "it is inside " + std::string(one->parent->tag()) + " '" + one->parent->name +
         "', whose name comes before its own: write " + out;
}

Names::Found Names::peek(const Element& from, std::string_view name) const {
  Found out;
  for (const Element* level = &from; level != nullptr; level = level->parent) {
    for (const Element* scope : {level, level->home}) {
      if (scope == nullptr) continue;
      const Walk result = walk(*scope, name, false, 0);
      out.lost = out.lost || result.lost;
      if (result.found == nullptr || result.found == &from) continue;
      out.element = result.found;
      if (context_.outline != nullptr) note_use(from, {}, name, *scope, false);
      return out;
    }
  }
  return out;
}

const Element* Names::find(const Element& from, const Word& word, Wanted wanted) {
  const bool materials = wanted == Wanted::material;
  bool lost = false;
  const Element* of_another_kind = nullptr;
  // Names of the element's own children come before those around it only for scopes, which ask
  // through their children.
  for (const Element* level = from.parent != nullptr ? from.parent : &from; level != nullptr;
       level = level->parent) {
    for (const Element* scope : {level, level->home}) {
      if (scope == nullptr) continue;
      const Walk result = walk(*scope, word.text, materials, 0);
      lost = lost || result.lost;
      if (result.found == nullptr || result.found == &from) continue;
      if (matches(*result.found, wanted)) {
        if (context_.outline != nullptr) note_use(from, word.span, word.text, *scope, materials);
        return result.found;
      }
      if (of_another_kind == nullptr) of_another_kind = result.found;
    }
  }
  if (lost || !failed_.emplace(&from, word.span.line, word.span.column).second) return nullptr;
  if (of_another_kind != nullptr) {
    context_.sink
        .report("CG0404", word.span, from.trail,
                "'" + word.text + "' is " + kind_of(*of_another_kind) + ", expected a " +
                    describe(wanted))
        .note("it is defined here", of_another_kind->span());
    return nullptr;
  }
  if (word.text == from.name) {
    context_.sink.report("CG0402", word.span, from.trail,
                         "there is no other " + std::string(describe(wanted)) + " '" + word.text +
                             "' here, and it cannot refer to itself");
    return nullptr;
  }
  // Comparing with all names is for typing mistakes, of which there are never thousands.
  const std::vector<std::string> names =
      failed_.size() > kMaxHelped ? std::vector<std::string>{} : known(from, wanted);
  std::string help = names.empty() ? std::string() : deeper(from, word.text, wanted);
  if (help.empty() && !names.empty()) help = suggest(word.text, names);
  context_.sink
      .report("CG0402", word.span, from.trail,
              "there is no " + std::string(describe(wanted)) + " '" + word.text + "' here")
      .help(std::move(help));
  return nullptr;
}

}  // namespace cogrsim::dsl
