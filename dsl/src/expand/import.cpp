#include <algorithm>

#include "expand/expand_scene.h"

namespace cogrsim::dsl {

// Whether a file imports itself through others; that is reported.
bool Expander::is_cycle(const Document& document, const SourceSpan& at, const Trail* trail) {
  const auto loop = std::find(open_documents_.begin(), open_documents_.end(), &document);
  if (loop == open_documents_.end()) return false;
  std::string cycle;
  for (auto it = loop; it != open_documents_.end(); ++it)
    cycle += context_.files.file((*it)->file).name + " -> ";
  cycle += context_.files.file(document.file).name;
  context_.sink.report("CG0302", at, trail, "files import each other in a cycle: " + cycle)
      .help("move what they share into a separate file");
  return true;
}

// Adds what an import without a prefix brings to the definitions around it.
void Expander::merge(const Definitions& from, const std::string& href, const SourceSpan& at,
                     const Trail* trail, Definitions& into) {
  for (const auto& [name, prototype] : from.prototypes) {
    const auto [there, is_new] = into.prototypes.emplace(name, prototype);
    if (!is_new && there->second.node != prototype.node)
      context_.sink
          .report("CG0401", at, trail, "'" + href + "' brings a second prototype '" + name + "'")
          .note("the other one", there->second.node->span)
          .help("give the import a prefix: as=\"parts\", then of=\"parts." + name + "\"");
  }
  for (const auto& [name, definition] : from.imports) into.imports.emplace(name, definition);
}

void Expander::import(const Node& node, const InsertPoint& point, Definitions& into) {
  // Each import is traversed again, so files that import each other twice double the work from
  // file to file, and their names with it.
  constexpr std::size_t kCostOfImport = 100;
  if (!within_limits(node, point, kCostOfImport)) return;
  Element* element = make(node, point);
  if (element == nullptr) return;
  element->path = point.key + "/import";
  Reader reader(context_, *element);
  const auto href = reader.text("href");
  const Attribute* at = node.find("href");
  const auto give_up = [&] {
    mark_failed(node, point);
    into.incomplete = true;
  };
  if (!href.given() || at == nullptr) return give_up();
  std::string prefix;
  if (reader.has("as")) {
    const auto as = reader.word("as");
    if (!as.given()) return give_up();
    prefix = (*as).text;
  }
  std::string keyframe;
  if (reader.has("keyframe")) {
    const auto name = reader.text("keyframe");
    if (!name.given()) return give_up();
    keyframe = *name;
  }
  const Document* document = context_.files.open_import(*href, keyframe, at->value_span);
  if (document == nullptr || document->root == nullptr || document->root->spec == nullptr)
    return give_up();
  if (is_cycle(*document, at->value_span, point.trail)) return give_up();

  InsertPoint inner;
  inner.into = point.into;
  inner.home = point.home;
  if (!prefix.empty()) {
    element->name = prefix;
    point.into->children.push_back(element);
    inner.into = element;
    inner.home = element;
  } else if (!merged_.emplace(point.into, document).second) {
    return;  // was imported already by another path
  }
  Definitions& definitions = definitions_.emplace_back();
  Scope& scope = context_.scopes.emplace_back(nullptr, true);
  std::vector<std::string_view> ignored;
  inner.scope = &scope;
  inner.trail = step(point, "in the import of '" + *href + "'", node.span);
  inner.key = point.key + "/" + *href;
  inner.instances = point.instances;
  inner.depth = point.depth + 1;
  inner.ignored = &ignored;
  open_documents_.push_back(document);
  define_params(*document->root, scope, inner, nullptr, false);
  children(*document->root, inner, &definitions);
  open_documents_.pop_back();

  if (!ignored.empty()) {
    std::string words;
    for (const std::string_view tag : ignored)
      words += (words.empty() ? "<" : ", <") + std::string(tag) + ">";
    context_.sink
        .report("CG2004", at->value_span, point.trail,
                "an import takes prototypes, materials and contacts; " + words + " of '" + *href +
                    "' are ignored")
        .help("to use them here, move them into a prototype");
  }
  if (definitions.incomplete) into.incomplete = true;
  if (!prefix.empty()) {
    into.imports.emplace(prefix, &definitions);  // a second one of that name is reported later
    return;
  }
  merge(definitions, *href, at->value_span, point.trail, into);
}

}  // namespace cogrsim::dsl
