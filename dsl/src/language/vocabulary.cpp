// Look-ups in the vocabulary.
#include "language/vocabulary.h"

#include <algorithm>
#include <unordered_map>

namespace cogrsim::dsl {

const AttributeSpec* ElementSpec::find(std::string_view attribute) const {
  for (const AttributeSpec& a : attributes) {
    if (a.name == attribute) return &a;
  }
  return nullptr;
}

const ElementSpec* find_element(std::string_view name) {
  static const std::unordered_map<std::string_view, const ElementSpec*> index = [] {
    std::unordered_map<std::string_view, const ElementSpec*> out;
    for (const ElementSpec& e : vocabulary()) out.emplace(e.name, &e);
    return out;
  }();
  const auto found = index.find(name);
  return found == index.end() ? nullptr : found->second;
}

const ElementSpec& contact_sensor() {
  static const ElementSpec& spec = [&]() -> const ElementSpec& {
    for (const ElementSpec& e : vocabulary()) {
      if (e.name == "contact" && is_sensor(&e)) return e;
    }
    return vocabulary().front();  // never: the table has it
  }();
  return spec;
}

namespace {
bool in_group(std::string_view element, std::string_view group) {
  const ElementSpec* e = find_element(element);
  return e && e->group == group;
}
}  // namespace

bool is_force(std::string_view element) { return in_group(element, "Forces"); }
bool is_joint(std::string_view element) { return in_group(element, "Joints"); }

bool is_shape(std::string_view element) {
  return in_group(element, "Bodies") && element != "body" && element != "frame";
}

bool is_sensor(const ElementSpec* element) { return element && element->group == "Sensors"; }

}  // namespace cogrsim::dsl
