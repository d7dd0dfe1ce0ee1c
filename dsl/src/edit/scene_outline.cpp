#include "edit/scene_outline.h"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>

#include "edit/outline_notes.h"
#include "report/diagnostics.h"
#include "syntax/edit_tree.h"
#include "syntax/element.h"
#include "syntax/xml_scan.h"

namespace cogrsim::dsl {
namespace {

bool makes_several(std::string_view tag) {
  return tag == "prototype" || tag == "repeat" || tag == "for" || tag == "scatter" ||
         tag == "template";
}

/// Ids by node and by position of the name in the start tag.
struct Ids {
  std::unordered_map<const Node*, int> by_node;
  std::map<std::pair<int, int>, int> by_place;

  explicit Ids(const Document& document) {
    int id = 0;
    for (const Node& node : document.nodes) {
      by_node.emplace(&node, id);
      by_place.emplace(std::make_pair(node.span.line, node.span.column), id);
      ++id;
    }
  }
  // Generated elements (walls, doors) have the position of the element that made them.
  int of(const Element* element) const {
    if (element == nullptr) return -1;
    const auto found = by_node.find(element->node);
    return found == by_node.end() ? -1 : found->second;
  }
  int at(const SourceSpan& span) const {
    if (span.file != 0) return -1;
    const auto found = by_place.find({span.line, span.column});
    return found == by_place.end() ? -1 : found->second;
  }
};

template <class T>
std::vector<Origin> origins_of(const std::vector<T>& items, const Ids& ids,
                               const std::vector<Analysis::Item>& elements) {
  std::vector<Origin> out;
  std::map<int, int> counts;
  for (const T& item : items) {
    out.push_back({ids.at(item.origin), false});
    ++counts[out.back().element];
  }
  for (Origin& origin : out)
    origin.own =
        origin.element >= 0 && counts[origin.element] == 1 && elements[origin.element].single;
  return out;
}

void take_notes(const OutlineNotes& notes, const Document& document, const Ids& ids,
                Analysis& out) {
  for (const OutlineNotes::ElementPoses& poses : notes.poses) {
    const int id = ids.of(poses.element);
    if (id < 0) continue;
    Analysis::Item& item = out.items[id];
    if (++item.count > 1) {
      item.single = false;
      item.path.clear();
      continue;
    }
    item.single = poses.element->trail == nullptr;
    for (const Node* up = &document.nodes[id]; up != nullptr && item.single; up = up->parent)
      item.single = !makes_several(up->name) || up == poses.element->node;
    item.parent = ids.of(poses.element->parent);
    item.reference = ids.of(poses.reference);
    item.name = poses.element->name;
    if (poses.element->path.find('(') == std::string::npos) item.path = poses.element->path;
    item.X_W = poses.X_W;
    item.X_W_start = poses.X_W_start;
    item.X_WR = poses.X_WR;
  }
  std::set<std::tuple<int, std::string, std::vector<int>>> seen;
  for (const OutlineNotes::Use& use : notes.uses) {
    Analysis::Use made{ids.of(use.from), use.span, use.text, {}};
    if (made.from < 0) continue;
    for (const Element* part : use.chain) made.chain.push_back(ids.of(part));
    // Iterations of a repeat give the same names again.
    if (seen.emplace(made.from, made.text, made.chain).second) out.uses.push_back(std::move(made));
  }
}

}  // namespace

Analysis analyse(const std::string& text, const std::string& name, const CompileOptions& options) {
  Analysis out;
  DiagnosticSink sink(options.limits);
  SourceFiles files(options, sink);
  OutlineNotes notes;
  CompileContext context{options, files, sink};
  context.outline = &notes;
  if (const Document* scene = files.open_scene_text(text, name)) {
    out.well_formed = true;
    out.items.resize(scene->nodes.size());
    if (const Element* root = expand(context, *scene))
      out.result.model = build_model(context, *root);
    if (sink.has_errors()) out.result.model = nullptr;
    const Ids ids(*scene);
    take_notes(notes, *scene, ids, out);
    out.items[0].count = 1;
    out.items[0].single = true;
    if (const SceneModel* model = out.result.model.get()) {
      const auto of = [&](const auto& items) { return origins_of(items, ids, out.items); };
      out.origins = {of(model->bodies),      of(model->assemblies), of(model->joints),
                     of(model->motors),      of(model->sensors),    of(model->controllers),
                     of(model->supervisors), of(model->lights),     of(model->views),
                     of(model->regions),     of(model->plots),      of(model->forces)};
    }
  }
  out.result.diagnostics = sink.take();
  out.result.files_read = files.read();
  return out;
}

namespace {

void add(const EditElement& e, const std::string& text, std::size_t& at, int& line, int& column,
         std::vector<OutlineElement>& out) {
  // Lines end with \n, \r\n or \r, as everywhere.
  const auto skip = [&](std::size_t bytes) {
    for (const std::size_t end = at + bytes; at < end; ++at) {
      const char c = text[at];
      if (c == '\n' || (c == '\r' && (at + 1 >= text.size() || text[at + 1] != '\n'))) {
        ++line;
        column = 1;
      } else if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) {
        ++column;
      }
    }
  };
  skip(e.lead.size());
  const std::size_t index = out.size();
  OutlineElement element;
  element.id = e.id;
  element.parent = e.parent != nullptr ? e.parent->id : -1;
  element.tag = e.tag;
  element.line = line;
  element.column = column;
  for (const EditAttribute& a : e.attributes) element.attributes.emplace_back(a.name, a.value());
  element.name = e.value(e.tag == "import" ? "as" : "name");
  out.push_back(std::move(element));
  skip(1 + e.tag.size());
  for (const EditAttribute& a : e.attributes)
    skip(a.lead.size() + a.name.size() + a.equals.size() + a.raw.size() + 2);
  skip(e.close.size() + (e.empty ? 2 : 1));
  if (!e.empty) {
    for (const auto& child : e.children) add(*child, text, at, line, column, out);
    skip(e.tail.size() + 2 + e.tag.size() + e.end.size() + 1);
  }
  out[index].end_line = line;
}

}  // namespace

std::vector<OutlineElement> outline_text(const std::string& text, const std::string& name,
                                         std::vector<Diagnostic>* diagnostics,
                                         const Limits& limits) {
  std::vector<Diagnostic> faults;
  const auto tree = EditTree::read(text, name, limits, faults);
  if (diagnostics != nullptr) *diagnostics = std::move(faults);
  std::vector<OutlineElement> out;
  if (!tree) return out;
  std::size_t at = 0;
  int line = 1, column = 1;
  add(tree->root(), text, at, line, column, out);
  return out;
}

OutlinedScene compile_outlined(const std::string& text, const std::string& name,
                               const CompileOptions& options) {
  Analysis analysis = analyse(text, name, options);
  OutlinedScene out;
  out.result = std::move(analysis.result);
  out.origins = std::move(analysis.origins);
  out.elements = outline_text(text, name, nullptr, options.limits);
  for (OutlineElement& element : out.elements) {
    const auto id = static_cast<std::size_t>(element.id);
    if (id >= analysis.items.size()) break;
    const Analysis::Item& item = analysis.items[id];
    element.single = item.single;
    element.path = item.path;
    if (element.name.empty() && item.count == 1) element.name = item.name;
  }
  return out;
}

}  // namespace cogrsim::dsl
