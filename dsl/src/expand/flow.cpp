#include <cmath>

#include "expand/expand_scene.h"

namespace cogrsim::dsl {
namespace {

// Words of an attribute such as var="side y".
std::vector<std::string_view> names_in(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = text.find_first_not_of(' ');
    if (begin == std::string_view::npos) return words;
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    text.remove_prefix(end);
  }
}

bool is_identifier(std::string_view word) {
  if (word.empty() || (word[0] >= '0' && word[0] <= '9')) return false;
  for (const char c : word)
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'))
      return false;
  return true;
}

}  // namespace

void Expander::repeat(const Node& node, const InsertPoint& point, const std::string& key) {
  const Attribute* count = node.find("count");
  const Attribute* var = node.find("var");
  if (count == nullptr) {  // reported by the vocabulary
    point.into->incomplete = true;
    return;
  }
  if (var != nullptr && !is_identifier(var->value)) {
    context_.sink
        .report("CG0403", var->value_span, point.trail,
                "'" + std::string(var->value) + "' cannot be a variable's name")
        .help("use letters, digits and _, for example var=\"i\"");
    point.into->incomplete = true;
    return;
  }
  const Value value = evaluate_attribute(context_, node, *count, point.scope, point.trail, key);
  if (value.is_poison()) {
    point.into->incomplete = true;
    return;
  }
  const Quantity* number = value.as_number();
  if (number == nullptr || !number->dimension.none() || number->value < 0 ||
      number->value != std::floor(number->value)) {
    point.into->incomplete = true;
    context_.sink.report(
        "CG0311", count->value_span, point.trail,
        "expected a whole number of iterations, 0 or more, found " +
            (number != nullptr && number->dimension.none() ? number_text(number->value)
                                                           : describe(value)));
    return;
  }
  const std::string name = var != nullptr ? std::string(var->value) : "i";
  const double limit = context_.options.limits.expanded_elements;
  const auto rounds = static_cast<std::size_t>(std::min(number->value, limit + 1.0));
  for (std::size_t i = 0; i < rounds; ++i) {
    if (!within_limits(node, point) || !spend(node, point, 4 * name.size())) return;
    Scope& scope = context_.scopes.emplace_back(point.scope);
    scope.set(name, Value::number(static_cast<double>(i)));
    InsertPoint inner = point;
    inner.scope = &scope;
    inner.trail = step(point, "in iteration " + std::to_string(i) + " of a repeat", node.span);
    inner.key = key + "[" + std::to_string(i) + "]";
    children(node, inner);
  }
}

void Expander::for_each(const Node& node, const InsertPoint& point, const std::string& key) {
  const Attribute* var = node.find("var");
  const Attribute* in = node.find("in");
  if (var == nullptr || in == nullptr) {
    point.into->incomplete = true;
    return;
  }
  if (!spend(node, point, 16 * var->value.size())) return;
  const auto names = names_in(var->value);
  for (const std::string_view name : names)
    if (!is_identifier(name)) {
      point.into->incomplete = true;
      context_.sink
          .report("CG0403", var->value_span, point.trail,
                  "'" + std::string(name) + "' cannot be a variable's name")
          .help("use letters, digits and _, for example var=\"side y\"");
      return;
    }
  const Value value = evaluate_attribute(context_, node, *in, point.scope, point.trail, key);
  if (value.is_poison() || names.empty()) {
    point.into->incomplete = true;
    return;
  }
  const ValueList* list = value.as_list();
  if (list == nullptr) {
    point.into->incomplete = true;
    context_.sink
        .report("CG0312", in->value_span, point.trail,
                "expected a list to iterate over, found " + describe(value))
        .help("write a list in square brackets: in=\"[1, 2, 3]\"");
    return;
  }
  for (std::size_t i = 0; i < list->size(); ++i) {
    if (!within_limits(node, point) || !spend(node, point, 100 * names.size())) return;
    const Value& item = (*list)[i];
    Scope& scope = context_.scopes.emplace_back(point.scope);
    if (names.size() == 1) {
      scope.set(std::string(names[0]), item);
    } else {
      const ValueList* tuple = item.as_list();
      if (item.is_poison() || tuple == nullptr || tuple->size() != names.size()) {
        point.into->incomplete = true;
        if (!item.is_poison())
          context_.sink
              .report("CG0312", in->value_span, point.trail,
                      "var has " + std::to_string(names.size()) + " names, but entry " +
                          std::to_string(i + 1) + " of the list is " + describe(item))
              .help("give each entry as many items: in=\"[['left', 1], ['right', -1]]\"");
        continue;
      }
      for (std::size_t k = 0; k < names.size(); ++k) scope.set(std::string(names[k]), (*tuple)[k]);
    }
    InsertPoint inner = point;
    inner.scope = &scope;
    inner.trail = step(point, "in iteration " + std::to_string(i) + " of a for", node.span);
    inner.key = key + "[" + std::to_string(i) + "]";
    children(node, inner);
  }
}

void Expander::condition(const Node& node, const InsertPoint& point, const std::string& key) {
  const Attribute* test = node.find("test");
  if (test == nullptr) {
    point.into->incomplete = true;
    return;
  }
  const Value value = evaluate_attribute(context_, node, *test, point.scope, point.trail, key);
  if (value.is_poison()) {
    point.into->incomplete = true;
    return;
  }
  const bool* yes = value.as_boolean();
  if (yes == nullptr) {
    point.into->incomplete = true;
    context_.sink
        .report("CG0313", test->value_span, point.trail,
                "expected true or false, found " + describe(value))
        .help("compare it: test=\"" + std::string(test->value) + " gt 0\"");
    return;
  }
  if (!*yes) return;
  InsertPoint inner = point;
  inner.key = key;
  children(node, inner);
}

}  // namespace cogrsim::dsl
