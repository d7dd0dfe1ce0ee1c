#include <algorithm>

#include "expand_scene.h"

namespace cogrsim::dsl {

void Expander::import(const Node& node, const Place& place, Definitions& into) {
  // Each import is gone through anew, so files that import each other twice double the work from
  // file to file, and their names with it.
  constexpr std::size_t kCostOfImport = 100;
  if (!room(node, place, kCostOfImport)) return;
  Element* element = make(node, place);
  if (element == nullptr) return;
  element->path = place.key + "/import";
  Reader reader(context_, *element);
  const auto href = reader.text("href");
  const Attribute* at = node.find("href");
  const auto give_up = [&] {
    lose(node, place);
    into.incomplete = true;
  };
  if (!href.given() || at == nullptr) return give_up();
  std::string prefix;
  if (reader.has("as")) {
    const auto as = reader.word("as");
    if (!as.given()) return give_up();
    prefix = (*as).text;
  }
  const Document* document = context_.files.open_import(*href, at->value_span);
  if (document == nullptr || document->root == nullptr || document->root->spec == nullptr)
    return give_up();

  if (const auto loop = std::find(open_documents_.begin(), open_documents_.end(), document);
      loop != open_documents_.end()) {
    std::string way;
    for (auto it = loop; it != open_documents_.end(); ++it)
      way += context_.files.file((*it)->file).name + " -> ";
    way += context_.files.file(document->file).name;
    context_.sink
        .report("CG0302", at->value_span, place.trail,
                "files import each other in a circle: " + way)
        .help("move what they share into a file of its own");
    return give_up();
  }

  Place inner;
  inner.into = place.into;
  inner.home = place.home;
  if (!prefix.empty()) {
    element->name = prefix;
    place.into->children.push_back(element);
    inner.into = element;
    inner.home = element;
  } else if (!merged_.emplace(place.into, document).second) {
    return;  // came in by another way already
  }
  Definitions& definitions = definitions_.emplace_back();
  Scope& scope = context_.scopes.emplace_back(nullptr, true);
  std::vector<std::string_view> left_behind;
  inner.scope = &scope;
  inner.trail = step(place, "in the import of '" + *href + "'", node.span);
  inner.key = place.key + "/" + *href;
  inner.instances = place.instances;
  inner.depth = place.depth + 1;
  inner.left_behind = &left_behind;
  open_documents_.push_back(document);
  define_params(*document->root, scope, inner, nullptr, false);
  children(*document->root, inner, &definitions);
  open_documents_.pop_back();

  if (!left_behind.empty()) {
    std::string words;
    for (const std::string_view tag : left_behind)
      words += (words.empty() ? "<" : ", <") + std::string(tag) + ">";
    context_.sink
        .report("CG2004", at->value_span, place.trail,
                "an import takes prototypes, materials and contacts; " + words + " of '" + *href +
                    "' stay behind")
        .help("wrap what you want from there in a prototype");
  }
  if (definitions.incomplete) into.incomplete = true;
  if (!prefix.empty()) {
    into.imports.emplace(prefix, &definitions);  // a second one of that name is found out later
    return;
  }
  for (const auto& [name, prototype] : definitions.prototypes) {
    const auto [there, is_new] = into.prototypes.emplace(name, prototype);
    if (!is_new && there->second.node != prototype.node)
      context_.sink
          .report("CG0401", at->value_span, place.trail,
                  "'" + *href + "' brings a second prototype '" + name + "'")
          .note("the other one", there->second.node->span)
          .help("give the import a prefix: as=\"parts\", then of=\"parts." + name + "\"");
  }
  for (const auto& [name, definition] : definitions.imports) into.imports.emplace(name, definition);
}

}  // namespace cogrsim::dsl
