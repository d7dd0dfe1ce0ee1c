// Scattered objects: like a repeat, but each iteration is stored, to be placed later.
#include "expand/expand_scene.h"

namespace cogrsim::dsl {

void Expander::scatter(const Node& node, const InsertPoint& point, const std::string& key) {
  Element* element = make(node, point);
  if (element == nullptr) return;
  point.into->children.push_back(element);
  element->path = key;
  Reader reader(context_, *element);
  if (reader.has("name") && !written_name(*element, point, element->name)) return;
  const auto count = reader.integer("count");
  const auto var = reader.has("var") ? reader.word("var") : Read<Word>{};
  if (!count.given() || var.failed()) {
    element->incomplete = true;
    return;
  }
  ScatterPlan plan;
  plan.element = element;
  for (std::int64_t i = 0; i < *count; ++i) {
    const std::size_t texts = element->name.size() + (var.given() ? (*var).text.size() : 0);
    if (!within_limits(node, point) || !spend(node, point, 4 * texts)) return;
    const std::string number = std::to_string(i);
    Scope& scope = context_.scopes.emplace_back(point.scope);
    if (var.given()) scope.set((*var).text, Value::number(static_cast<double>(i)));
    InsertPoint inner = point;
    inner.into = element;
    inner.scope = &scope;
    inner.trail = step(point, "in iteration " + number + " of a scatter", node.span);
    inner.key = key + "[" + number + "]";
    const std::size_t before = element->children.size();
    children(node, inner);
    ScatterGroup group;
    for (std::size_t k = before; k < element->children.size(); ++k) {
      Element& member = *element->children[k];
      // A name that depends on the iteration is numbered already.
      const Attribute* name = member.find("name");
      if (name != nullptr && !member.name.empty() &&
          name->value.find("${") == std::string_view::npos)
        member.name += "_" + number;
      group.members.push_back(&member);
    }
    plan.groups.push_back(std::move(group));
  }
  context_.scatters.push_back(std::move(plan));
}

}  // namespace cogrsim::dsl
