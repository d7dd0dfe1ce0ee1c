#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "expand/expand_scene.h"
#include "values/number_list.h"

namespace cogrsim::dsl {
namespace {

using Form = ParamType::Form;

constexpr std::array<ParamType, 17> kTypes = {
    {{"", Form::any, {}},
     {"number", Form::quantity, dim::kNone},
     {"int", Form::integer, dim::kNone},
     {"bool", Form::boolean, {}},
     {"text", Form::text, {}},
     {"list", Form::list, {}},
     {"length", Form::quantity, dim::kLength},
     {"angle", Form::quantity, dim::kAngle},
     {"mass", Form::quantity, dim::kMass},
     {"time", Form::quantity, dim::kTime},
     {"speed", Form::quantity, dim::kSpeed},
     {"angular-speed", Form::quantity, dim::kAngularSpeed},
     {"acceleration", Form::quantity, dim::kAcceleration},
     {"force", Form::quantity, dim::kForce},
     {"torque", Form::quantity, dim::kTorque},
     {"density", Form::quantity, dim::kDensity},
     {"frequency", Form::quantity, dim::kFrequency}}};

std::string expected(const ParamType& type) {
  switch (type.form) {
    case Form::quantity:
      return describe(type.dimension);
    case Form::integer:
      return "a whole number";
    case Form::boolean:
      return "true or false";
    case Form::text:
      return "a text";
    case Form::list:
      return "a list";
    case Form::any:
      break;
  }
  return "a value";
}

// `value` as `type`; nullopt: it is none. `raw` is what was written, for texts that look like
// something else.
std::optional<Value> coerce(const Value& value, const ParamType& type, std::string_view raw) {
  if (value.is_poison()) return value;
  const Quantity* number = value.as_number();
  switch (type.form) {
    case Form::any:
      return value;
    case Form::boolean:
      if (value.as_boolean() == nullptr) return std::nullopt;
      return value;
    case Form::text:
      if (value.as_text() != nullptr) return value;
      return Value::text(raw.find("${") == std::string_view::npos ? std::string(raw)
                                                                  : to_text(value));
    case Form::list:
      if (value.as_list() == nullptr) return std::nullopt;
      return value;
    case Form::integer:
      if (number == nullptr || !number->dimension.none() ||
          number->value != std::floor(number->value))
        return std::nullopt;
      return value;
    case Form::quantity:
      if (number == nullptr) return std::nullopt;
      if (fits(number->dimension, type.dimension))
        return Value::number(number->value, type.dimension);
      // Without a unit it is SI, but an angle must say what it is in.
      if (number->dimension.none() && (type.dimension.angle == 0 || number->value == 0))
        return Value::number(number->value, type.dimension);
      return std::nullopt;
  }
  return std::nullopt;
}

std::string found(const Value& value) {
  const Quantity* number = value.as_number();
  if (const std::string* text = value.as_text())
    return text->empty() ? "nothing" : "the text \"" + *text + "\"";
  return number != nullptr && number->dimension.none() ? number_text(number->value)
                                                       : describe(value);
}

bool can_be_named(std::string_view word) {
  return !word.empty() && word.find('-') == std::string_view::npos;
}

std::string with_unit(const Quantity& quantity) {
  const std::string unit = unit_of(quantity.dimension);
  return number_text(quantity.value) + (unit.empty() ? "" : " " + unit);
}

}  // namespace

const ParamType* find_param_type(std::string_view name) {
  for (const ParamType& type : kTypes)
    if (type.name == name) return &type;
  return nullptr;
}

void Expander::check_bounds(const Element& param, const ParamType& type, const Value& value,
                            std::string_view name, const SourceSpan& at, const Trail* trail) {
  const Quantity* number = value.as_number();
  if (number == nullptr) return;
  Reader reader(context_, param);
  for (const bool low : {true, false}) {
    const std::string_view which = low ? "min" : "max";
    const Attribute* attribute = param.find(which);
    if (attribute == nullptr) continue;
    const auto read = reader.value(which);
    if (!read.given()) continue;
    const auto bound = coerce(*read, type, attribute->value);
    if (!bound) {
      context_.sink.report("CG0310", attribute->value_span, param.trail,
                           std::string(which) + " of parameter '" + std::string(name) +
                               "': expected " + expected(type) + ", found " + describe(*read));
      continue;
    }
    const Quantity* limit = bound->as_number();
    if (limit == nullptr || limit->dimension != number->dimension) continue;
    if (low ? number->value < limit->value : number->value > limit->value) {
      context_.sink
          .report("CG0309", at, trail,
                  "parameter '" + std::string(name) + "' is " + with_unit(*number) +
                      (low ? ", less than its min " : ", more than its max ") + with_unit(*limit))
          .note("the parameter", param.span());
      return;
    }
  }
}

Value Expander::param_value(const Element& param, const ParamType* type, const std::string& name,
                            const Node& container, const Element* instance, bool is_scene) {
  Reader reader(context_, param);
  // Where the value comes from: the instance, the command line, the default.
  Value value = Value::poison();
  std::string raw;
  const Node* node = param.node;
  SourceSpan at = node->span;
  const Trail* trail = param.trail;
  const Attribute* given = instance != nullptr ? instance->find(name) : nullptr;
  const auto& sets = context_.options.set_parameters;
  const auto set = is_scene ? sets.find(name) : sets.end();
  bool from_set = false;
  if (given != nullptr) {
    raw = std::string(given->value);
    at = given->value_span;
    trail = instance->trail;
    const auto read = Reader(context_, *instance).value(*given);
    if (read.given()) value = *read;
  } else if (set != sets.end()) {
    from_set = true;
    raw = set->second;
    std::string problem;
    value = parse_value_text(raw, &problem);
    if (type != nullptr && type->form == Form::text) {
      value = Value::text(raw);
    } else if (!problem.empty()) {
      context_.sink.report("CG0310", node->span, trail,
                           "--set " + name + "=" + raw + ": " + problem);
    }
  } else if (const Attribute* fallback = node->find("default"); fallback != nullptr) {
    raw = std::string(fallback->value);
    at = fallback->value_span;
    const auto read = reader.value("default");
    if (read.given()) value = *read;
  } else if (instance != nullptr) {
    context_.sink
        .report("CG0308", instance->span(), instance->trail,
                "parameter '" + name + "' is missing: prototype '" +
                    std::string(container.find("name")->value) + "' has no default for it")
        .note("the parameter", node->span)
        .help("add " + name + "=\"…\" to the instance");
  } else {
    context_.sink
        .report("CG0308", node->span, trail,
                "parameter '" + name + "' has neither value nor default")
        .help(is_scene ? "run with --set " + name + "=…, or write default=\"…\""
                       : "write default=\"…\"");
  }
  if (!value.is_poison() && type != nullptr) {
    const auto as_typed = coerce(value, *type, raw);
    if (!as_typed) {
      auto report = context_.sink.report(
          "CG0310", at, trail,
          (from_set ? "--set " + name + "=" + raw : "parameter '" + name + "'") + ": expected " +
              expected(*type) + ", found " + found(value));
      if (given != nullptr) report.note("the parameter", node->span);
      if (const std::string* text = value.as_text(); text != nullptr) {
        report.help(type->form == Form::quantity || type->form == Form::integer
                        ? nearly_number_help(*text)
                        : "");
      }
      value = Value::poison();
    } else {
      value = *as_typed;
      check_bounds(param, *type, value, name, at, trail);
    }
  }
  return value;
}

void Expander::define_params(const Node& container, Scope& scope, const InsertPoint& point,
                             const Element* instance, bool is_scene) {
  check_given_names(container, instance, is_scene);
  const ElementSpec* instance_spec = find_element("instance");
  for (const Node* node : container.children) {
    if (node->name != "param") continue;
    if (!spend(*node, point, 1000)) return;
    if (node->spec == nullptr) {  // misplaced: reported once, not for every use
      if (const Attribute* name = node->find("name");
          name != nullptr && !scope.has_own(name->value))
        scope.set(std::string(name->value), Value::poison());
      continue;
    }
    Element& param = context_.elements.emplace_back();
    param.node = node;
    param.scope = &scope;
    param.trail = point.trail;
    Reader reader(context_, param);
    const auto word = reader.word("name");
    if (!word.given()) continue;
    const std::string& name = (*word).text;
    param.path = point.key + "/param:" + name;
    if (!can_be_named(name)) {
      context_.sink
          .report("CG0403", (*word).span, point.trail,
                  "'" + name + "' cannot be used in expressions: '-' there means minus")
          .help("use _ instead");
      scope.set(name, Value::poison());
      continue;
    }
    if (scope.has_own(name)) {
      context_.sink.report("CG0401", param, "name", "parameter '" + name + "' exists twice");
      continue;
    }
    if (instance != nullptr && instance_spec->find(name) != nullptr) {
      context_.sink
          .report("CG0403", param, "name",
                  "a prototype cannot have a parameter '" + name +
                      "': every instance has an attribute of that name")
          .help("choose another name");
      scope.set(name, Value::poison());
      continue;
    }
    const auto type_name = reader.text("type");
    const ParamType* type = type_name.failed() ? nullptr : find_param_type(*type_name);
    scope.set(name, param_value(param, type, name, container, instance, is_scene));
    context_.params.push_back({&scope, node, name});
  }
}

void Expander::check_given_names(const Node& container, const Element* instance, bool is_scene) {
  if (instance == nullptr && !is_scene) return;
  std::vector<std::string> known;
  std::set<std::string_view> names;
  for (const Node* node : container.children)
    if (node->name == "param")
      if (const Attribute* name = node->find("name"); name && names.insert(name->value).second)
        known.emplace_back(name->value);
  const auto is_known = [&](std::string_view name) { return names.count(name) != 0; };
  const std::string none = is_scene ? "the scene has no parameters" : "it has no parameters";
  if (is_scene) {
    for (const auto& [name, text] : context_.options.set_parameters)
      if (!is_known(name))
        context_.sink
            .report("CG0307", SourceSpan{}, nullptr,
                    "--set " + name + "=" + text + ": the scene has no parameter '" + name + "'")
            .help(known.empty() ? none : suggest(name, known));
    return;
  }
  const ElementSpec* spec = find_element("instance");
  for (const Attribute& attribute : instance->node->attributes)
    if (spec->find(attribute.name) == nullptr && !is_known(attribute.name))
      context_.sink
          .report("CG0307", attribute.name_span, instance->trail,
                  "prototype '" + std::string(container.find("name")->value) +
                      "' has no parameter '" + std::string(attribute.name) + "'")
          .help(known.empty() ? none : suggest(attribute.name, known));
}

}  // namespace cogrsim::dsl
