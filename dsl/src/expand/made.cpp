// Generated elements. They point into the text that they were made for, so that later stages treat
// and report them like any other element.
#include "expand/expand_scene.h"

namespace cogrsim::dsl {

Node& Expander::made_node(std::string_view tag, const SourceSpan& at) {
  Node& node = context_.made_nodes.emplace_back();
  node.spec = find_element(tag);
  node.name = node.spec->name;
  node.span = at;
  return node;
}

void Expander::give(Node& node, std::string_view attribute, std::string text) {
  Attribute a;
  a.name = node.spec->find(attribute)->name;
  a.value = context_.made_texts.emplace_back(std::move(text));
  a.name_span = a.value_span = node.span;
  node.attributes.push_back(a);
}

void Expander::hand_down(Node& node, std::string_view attribute, const Node& from,
                         std::string_view written) {
  const Attribute* found = from.find(written);
  if (found == nullptr) return;
  Attribute a = *found;
  a.name = node.spec->find(attribute)->name;
  node.attributes.push_back(a);
}

Element* Expander::add_made(const Node& node, const InsertPoint& point, std::string name) {
  Element* element = make(node, point);
  if (element == nullptr) return nullptr;
  element->name = std::move(name);
  point.into->children.push_back(element);
  return element;
}

Element& Expander::read_only(const Node& node, const InsertPoint& point, const std::string& key) {
  Element& element = context_.elements.emplace_back();
  element.node = &node;
  element.scope = point.scope;
  element.trail = point.trail;
  element.parent = point.into;
  element.path = key;
  return element;
}

bool Expander::written_name(Element& written, const InsertPoint& point, std::string& name) {
  const auto word = Reader(context_, written).word("name");
  if (!word.given()) {
    point.into->incomplete = true;
    return false;
  }
  name = (*word).text;
  return true;
}

}  // namespace cogrsim::dsl
