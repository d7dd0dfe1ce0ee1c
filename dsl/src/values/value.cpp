#include "values/value.h"

#include <algorithm>

#include "syntax/element.h"

namespace cogrsim::dsl {

std::string describe(const Value& value) {
  if (const Quantity* q = value.as_number()) return describe(q->dimension);
  if (value.as_boolean()) return "true or false";
  if (value.as_text()) return "text";
  if (const ValueList* list = value.as_list()) return "a list of " + std::to_string(list->size());
  return "nothing";
}

std::string to_text(const Value& value) {
  if (const Quantity* q = value.as_number()) {
    const std::string unit = unit_of(q->dimension);
    return number_text(q->value) + (unit.empty() ? "" : " " + unit);
  }
  if (const bool* b = value.as_boolean()) return *b ? "true" : "false";
  if (const std::string* t = value.as_text()) return *t;
  std::string out;
  if (const ValueList* list = value.as_list()) {
    for (const Value& entry : *list) out += (out.empty() ? "[" : ", ") + to_text(entry);
    out = list->empty() ? "[]" : out + "]";
  }
  return out;
}

std::size_t size_of(const Value& value, std::size_t most) {
  if (const std::string* text = value.as_text()) return std::min(text->size(), most);
  const ValueList* list = value.as_list();
  if (list == nullptr) return 0;
  std::size_t sum = 0;
  for (const Value& entry : *list) {
    sum += 64;
    if (sum >= most) return most;
    sum += size_of(entry, most - sum);
  }
  return std::min(sum, most);
}

void Scope::set(std::string name, Value value) {
  entries_[std::move(name)].value = std::move(value);
}

const Value* Scope::find(std::string_view name) const {
  for (const Scope* s = this; s; s = s->opaque_ ? nullptr : s->parent_) {
    const auto found = s->entries_.find(name);
    if (found == s->entries_.end()) continue;
    found->second.used = true;
    return &found->second.value;
  }
  return nullptr;
}

bool Scope::has_own(std::string_view name) const { return entries_.find(name) != entries_.end(); }

std::vector<std::string> Scope::unused() const {
  std::vector<std::string> out;
  for (const auto& [name, entry] : entries_) {
    if (!entry.used) out.push_back(name);
  }
  return out;
}

std::vector<std::string> Scope::names() const {
  std::vector<std::string> out;
  for (const Scope* s = this; s; s = s->opaque_ ? nullptr : s->parent_) {
    for (const auto& [name, entry] : s->entries_) out.push_back(name);
  }
  return out;
}

}  // namespace cogrsim::dsl
