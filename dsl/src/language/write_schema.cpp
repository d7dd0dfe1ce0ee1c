#include <cmath>

#include <nlohmann/json.hpp>

#include "cogrsim/dsl/schema.h"
#include "cogrsim/physics/backend.h"
#include "language/vocabulary.h"

namespace cogrsim::dsl {
namespace {

using Json = nlohmann::ordered_json;

const char* to_text(Kind kind) {
  switch (kind) {
    case Kind::name:
      return "name";
    case Kind::reference:
      return "reference";
    case Kind::references:
      return "references";
    case Kind::text:
      return "text";
    case Kind::boolean:
      return "boolean";
    case Kind::choice:
      return "choice";
    case Kind::integer:
      return "integer";
    case Kind::number:
      return "number";
    case Kind::numbers:
      return "numbers";
    case Kind::range:
      return "range";
    case Kind::color:
      return "color";
    case Kind::file:
      return "file";
    case Kind::noise:
      return "noise";
    case Kind::expression:
      return "expression";
    case Kind::value:
      return "value";
  }
  return "";
}

struct WrittenUnits {
  Dimension dimension;
  std::vector<const char*> units;  // the usual one first
};

const std::vector<WrittenUnits>& written_units() {
  static const std::vector<WrittenUnits> table = {{dim::kNone, {}},
                                                  {dim::kLength, {"m", "cm", "mm", "km"}},
                                                  {dim::kMass, {"kg", "g", "t"}},
                                                  {dim::kTime, {"s", "ms", "us", "min", "h"}},
                                                  {dim::kAngle, {"deg", "rad"}},
                                                  {dim::kSpeed, {"m/s", "cm/s", "mm/s", "km/h"}},
                                                  {dim::kAcceleration, {"m/s^2"}},
                                                  {dim::kAngularSpeed, {"rad/s", "deg/s", "rpm"}},
                                                  {dim::kFrequency, {"Hz", "kHz"}},
                                                  {dim::kDensity, {"kg/m^3", "g/cm^3"}},
                                                  {dim::kLinearDensity, {"kg/m", "g/m"}},
                                                  {dim::kInertia, {"kg*m^2", "g*cm^2"}},
                                                  {dim::kForce, {"N", "kN", "mN"}},
                                                  {dim::kTorque, {"N*m", "N*cm", "mN*m"}},
                                                  {dim::kStiffness, {"N/m", "N/mm"}},
                                                  {dim::kAngularStiffness, {"N*m/rad", "N*m/deg"}},
                                                  {dim::kDamping, {"N*s/m"}},
                                                  {dim::kAngularDamping, {"N*m*s/rad"}},
                                                  {dim::kIntegralGain, {"N/(m*s)"}},
                                                  {dim::kAngularIntegralGain, {"N*m/(rad*s)"}},
                                                  {dim::kVoltage, {"V", "mV"}},
                                                  {dim::kCurrent, {"A", "mA"}},
                                                  {dim::kResistance, {"ohm"}},
                                                  {dim::kTorqueConstant, {"N*m/A"}},
                                                  {dim::kBackEmf, {"V*s/rad"}},
                                                  {dim::kForceConstant, {"N/A", "V*s/m"}},
                                                  {dim::kMemory, {"MB", "GB", "MiB", "kB", "B"}}};
  return table;
}

/// The kind of element that a reference expects.
std::string wanted(const ElementSpec& element, const AttributeSpec& attribute) {
  const std::string_view name = attribute.name;
  if (name == "material" || name == "door-material" ||
      (element.name == "contact" && name == "between"))
    return "material";
  if (name == "joint") return "joint";
  if (name == "door" || name == "motor" || name == "sensor") return std::string(name);
  if (element.name == "maze" && name == "open") return "door";
  if (name == "of")
    return element.name == "instance" ? "prototype" : element.name == "spawn" ? "template" : "any";
  if (name == "parent" || name == "child" || name == "on" || name == "frame" || name == "who" ||
      name == "between")
    return "place";
  return "any";
}

Json attribute_json(const ElementSpec& element, const AttributeSpec& a) {
  Json out{{"name", a.name},         {"kind", to_text(a.kind)},
           {"doc", a.doc},           {"default", a.default_text},
           {"required", a.required}, {"units", Json::array()}};
  for (const Dimension& d : a.dimensions) out["units"].push_back(unit_of(d));
  if (a.per_entry) out["per_entry"] = true;
  if (a.kind == Kind::numbers || a.kind == Kind::references) {
    out["min_count"] = a.min_count;
    out["max_count"] = a.max_count;
  }
  if (std::isfinite(a.minimum)) out["min"] = a.minimum;
  if (std::isfinite(a.maximum)) out["max"] = a.maximum;
  if (a.above_minimum) out["above_min"] = true;
  if (a.none_allowed) out["none_allowed"] = true;
  if (!a.choices.empty()) out["choices"] = a.choices;
  if (a.kind == Kind::reference || a.kind == Kind::references) out["wants"] = wanted(element, a);
  return out;
}

Json element_json(const ElementSpec& e) {
  Json out{{"name", e.name},
           {"group", e.group},
           {"doc", e.doc},
           {"example", e.example},
           {"children", e.children},
           {"attributes", Json::array()},
           {"flow", e.flow},
           {"open_attributes", e.open_attributes},
           {"engine_blocks", e.engine_blocks},
           {"text", e.text}};
  if (e.name == "contact" && is_sensor(&e)) out["when"] = "on";
  for (const AttributeSpec& a : e.attributes) out["attributes"].push_back(attribute_json(e, a));
  return out;
}

/// As one would write it in a `<set>`.
std::string default_of(const ParameterSpec& p) {
  const std::string unit = p.unit.empty() || p.unit == "1" ? "" : " " + p.unit;
  if (const auto* truth = std::get_if<bool>(&p.default_value)) return *truth ? "true" : "false";
  if (const auto* whole = std::get_if<std::int64_t>(&p.default_value))
    return std::to_string(*whole);
  if (const auto* number = std::get_if<double>(&p.default_value))
    return std::isfinite(*number) ? number_text(*number) + unit : "";
  if (const auto* text = std::get_if<std::string>(&p.default_value)) return *text;
  std::string out;
  for (const double number : std::get<std::vector<double>>(p.default_value))
    out += (out.empty() ? "" : " ") + number_text(number);
  return out.empty() ? out : out + unit;
}

Json parameters_json(const ParameterTable& table) {
  Json out = Json::array();
  for (const ParameterSpec& p : table) {
    Json one{{"name", p.name},
             {"kind", p.type() == ParameterType::number_list ? "numbers"
                      : !p.choices.empty()                   ? "choice"
                                                             : cogrsim::to_string(p.type())},
             {"doc", p.description},
             {"default", default_of(p)},
             {"required", p.required},
             {"units", Json::array()}};
    if (p.type() == ParameterType::number || p.type() == ParameterType::number_list)
      one["units"].push_back(p.unit == "1" ? "" : p.unit);
    if (p.type() == ParameterType::number_list) {
      one["min_count"] = 0;
      one["max_count"] = 1000;
    }
    if (std::isfinite(p.minimum)) one["min"] = p.minimum;
    if (std::isfinite(p.maximum)) one["max"] = p.maximum;
    if (!p.choices.empty()) one["choices"] = p.choices;
    out.push_back(std::move(one));
  }
  return out;
}

}  // namespace

std::string write_schema_json(PluginCatalog* plugins) {
  Json out{{"version", 1}, {"elements", Json::array()}, {"units", Json::object()}};
  for (const ElementSpec& e : vocabulary()) out["elements"].push_back(element_json(e));
  for (const WrittenUnits& known : written_units()) {
    const std::string unit = unit_of(known.dimension);
    out["units"][unit] = Json::array();
    for (const char* one : known.units)
      if (parse_unit(one)) out["units"][unit].push_back(one);
  }
  if (plugins != nullptr) {
    const std::pair<PluginKind, const char*> kinds[] = {{PluginKind::controller, "controllers"},
                                                        {PluginKind::supervisor, "supervisors"},
                                                        {PluginKind::sensor, "sensors"}};
    out["plugins"] = Json::object();
    for (const auto& [kind, word] : kinds) {
      out["plugins"][word] = Json::array();
      for (const std::string& name : plugins->names(kind))
        if (const auto table = plugins->parameters(kind, name))
          out["plugins"][word].push_back({{"name", name}, {"parameters", parameters_json(*table)}});
    }
    out["backends"] = plugins->names(PluginKind::backend);
    out["blocks"] = Json::object();
    for (const std::string& name : plugins->names(PluginKind::backend)) {
      const auto list = [&](const Result<ParameterTable>& table) {
        return table ? parameters_json(*table) : Json::array();
      };
      Json& blocks = out["blocks"][name];
      blocks["world"] = list(plugins->world_options(name));
      for (const std::string_view element : kOptionElements)
        blocks[std::string(element)] = list(plugins->element_options(name, element));
    }
  }
  return out.dump(1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace cogrsim::dsl
