#include "physics/adapter/adapter_about.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cogrsim/core/json_bounds.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/physics/backend_checks.h"

namespace cogrsim {

namespace {

using AboutJson = nlohmann::ordered_json;

struct AboutFault {
  std::string what;
};

Support support_of(const AboutJson& json, const std::string& feature) {
  for (const Support support : {Support::unsupported, Support::approximate, Support::exact})
    if (json == to_string(support)) return support;
  throw AboutFault{
      fmt::format("the support of '{}' is {}, not \"exact\", \"approximate\" or "
                  "\"unsupported\"",
                  feature, json.dump())};
}

/// Whether `text` is `pattern`, in which each * stands for any text.
bool matches(std::string_view pattern, std::string_view text) {
  const std::size_t star = pattern.find('*');
  if (star == std::string_view::npos) return pattern == text;
  if (text.substr(0, star) != pattern.substr(0, star)) return false;
  for (std::size_t at = star; at <= text.size(); ++at)
    if (matches(pattern.substr(star + 1), text.substr(at))) return true;
  return false;
}

/// "exact", or ["approximate", "why"], by feature or by pattern; later ones overrule earlier ones.
Capabilities take_capabilities(const AboutJson& json) {
  if (!json.is_object()) throw AboutFault{"'capabilities' is not an object"};
  Capabilities out;
  for (const std::string& feature : all_features())
    out.set(feature, Support::unsupported, "not declared by the adapter");
  for (const auto& [pattern, value] : json.items()) {
    const bool pair = value.is_array() && value.size() == 2 && value[1].is_string();
    const Support support = support_of(pair ? value[0] : value, pattern);
    const std::string note = pair ? value[1].get<std::string>() : "";
    if (support != Support::exact && note.empty()) {
      throw AboutFault{
          fmt::format("'{}' needs a reason: [\"{}\", \"why\"]", pattern, to_string(support))};
    }
    bool found = false;
    for (const std::string& feature : all_features()) {
      if (!matches(pattern, feature)) continue;
      out.set(feature, support, note);
      found = true;
    }
    if (!found) {
      const std::string near = nearest_name(pattern, all_features());
      throw AboutFault{fmt::format("there is no feature '{}'{}", pattern,
                                   near.empty() ? "" : "; did you mean '" + near + "'?")};
    }
  }
  return out;
}

ParameterSpec take_option(const AboutJson& json) {
  const auto text = [&](const char* key) {
    const auto found = json.find(key);
    if (found == json.end()) return std::string();
    if (!found->is_string()) throw AboutFault{fmt::format("'{}' of an option is not a text", key)};
    return found->get<std::string>();
  };
  if (!json.is_object() || !json.contains("name") || !json.contains("default"))
    throw AboutFault{"each of 'options' needs a name and a default"};
  ParameterSpec out;
  out.name = text("name");
  out.unit = text("unit");
  out.description = text("description");
  const AboutJson& value = json["default"];
  if (value.is_boolean())
    out.default_value = value.get<bool>();
  else if (value.is_string())
    out.default_value = value.get<std::string>();
  else if (value.is_number() && text("type") == "integer")
    out.default_value = static_cast<std::int64_t>(std::llround(value.get<double>()));
  else if (value.is_number())
    out.default_value = value.get<double>();
  else
    throw AboutFault{
        fmt::format("the default of option '{}' is no truth value, number or text", out.name)};
  const auto bound = [&](const char* key, double& to) {
    if (!json.contains(key)) return;
    if (!json[key].is_number()) throw AboutFault{fmt::format("'{}' is not a number", key)};
    to = json[key].get<double>();
  };
  bound("minimum", out.minimum);
  bound("maximum", out.maximum);
  if (json.contains("choices")) {
    const AboutJson& choices = json["choices"];
    const auto is_text = [](const AboutJson& one) { return one.is_string(); };
    if (!choices.is_array() || !std::all_of(choices.begin(), choices.end(), is_text))
      throw AboutFault{fmt::format("the choices of option '{}' are not texts", out.name)};
    out.choices = choices.get<std::vector<std::string>>();
  }
  return out;
}

ParameterTable take_options(const AboutJson& json) {
  if (!json.is_array()) throw AboutFault{"'options' is not a list"};
  ParameterTable out;
  for (const AboutJson& option : json) {
    ParameterSpec spec = take_option(option);
    for (const ParameterSpec& other : out)
      if (other.name == spec.name)
        throw AboutFault{fmt::format("two options are called '{}'", spec.name)};
    out.push_back(std::move(spec));
  }
  return out;
}

/// One of two words for a member; the first one if it is missing.
bool is_second(const AboutJson& json, const char* key, const char* first, const char* second) {
  const auto found = json.find(key);
  if (found == json.end() || *found == first) return false;
  if (*found == second) return true;
  throw AboutFault{
      fmt::format("'{}' is {}, not \"{}\" or \"{}\"", key, found->dump(), first, second)};
}

AdapterAbout take_about(const AboutJson& json) {
  if (!json.is_object()) throw AboutFault{"it is not an object"};
  AdapterAbout out;
  if (!json.contains("version") || !json["version"].is_string())
    throw AboutFault{"'version', that of the engine, is not a text"};
  out.version = json["version"].get<std::string>();
  out.capabilities = take_capabilities(json.value("capabilities", AboutJson()));
  if (json.contains("options")) out.options = take_options(json["options"]);
  const AboutJson of_elements = json.value("element_options", AboutJson::object());
  if (!of_elements.is_object()) throw AboutFault{"'element_options' is not an object"};
  for (const auto& [element, options] : of_elements.items()) {
    if (std::find(std::begin(kOptionElements), std::end(kOptionElements), element) ==
        std::end(kOptionElements))
      throw AboutFault{
          fmt::format("'{}' in 'element_options' is no element with options", element)};
    out.element_options[element] = take_options(options);
  }
  out.coordinates_from_bodies = is_second(json, "coordinates", "joints", "bodies");
  out.lacks_couplings = is_second(json, "couplings", "engine", "host");
  if (json.contains("force_time")) {
    const AboutJson& time = json["force_time"];
    if (!time.is_number() || !(time >= 0.0) || !(time <= 1.0))
      throw AboutFault{"'force_time' is not a number from 0 to 1"};
    out.evaluation_time = time.get<double>();
  }
  return out;
}

}  // namespace

const std::vector<std::string>& all_features() {
  static const std::vector<std::string> features = [] {
    Capabilities named;
    set_shape_features(named);
    set_joint_features(named);
    for (const JointType type : kJointTypes)
      if (type != JointType::fixed && type != JointType::free)
        named.set(std::string("joint.rotor-inertia.") + to_string(type), Support::exact);
    named.set_all({"joint.coupling",
                   "joint.coupling-effort",
                   "body.force",
                   "body.static",
                   "body.kinematic",
                   "body.gravity-scale",
                   "contact.stiffness",
                   "contact.rolling-friction",
                   "contact.spinning-friction",
                   "contact.surface-velocity",
                   "runtime.add",
                   "runtime.remove",
                   "runtime.save",
                   "runtime.set_state",
                   "runtime.attach",
                   "runtime.body_kind",
                   "runtime.joint_axes",
                   "report.contact_force",
                   "report.joint_reaction",
                   "report.joint_effort"},
                  Support::exact);
    std::vector<std::string> out;
    for (const auto& [feature, capability] : named.all()) out.push_back(feature);
    return out;
  }();
  return features;
}

Result<AdapterAbout> read_about(const std::string& text) {
  if (const std::string excess = json_excess(text); !excess.empty()) return fail("it " + excess);
  try {
    return take_about(AboutJson::parse(text));
  } catch (const AboutFault& fault) {
    return fail(fault.what);
  } catch (const AboutJson::exception& e) {
    return fail(e.what());
  }
}

Result<Provenance> read_adapter_provenance(const std::string& text) {
  const AboutJson json = AboutJson::parse(text, nullptr, false);
  if (!json.is_object()) return fail("its provenance is not an object");
  Provenance out;
  for (const auto& [key, to] : {std::pair{"engine", &out.engine},
                                {"solver", &out.solver},
                                {"formulation", &out.formulation},
                                {"integrator", &out.integrator}}) {
    if (json.contains(key) && json[key].is_string()) *to = json[key].get<std::string>();
  }
  const AboutJson stages = json.value("stages", AboutJson::object());
  if (!stages.is_object()) return fail("'stages' of its provenance is not an object");
  for (const auto& [name, value] : stages.items()) {
    const auto stage =
        std::find_if(kStepStages.begin(), kStepStages.end(),
                     [&, &called = name](StepStage one) { return called == to_string(one); });
    if (stage == kStepStages.end()) return fail("a step has no stage '" + name + "'");
    const ComputedBy* by = nullptr;
    static constexpr ComputedBy kAnswers[] = {ComputedBy::engine, ComputedBy::cogrsim,
                                              ComputedBy::none};
    for (const ComputedBy& one : kAnswers)
      if (value.is_array() && value.size() == 2 && value[0] == to_string(one)) by = &one;
    if (!by || !value[1].is_string())
      return fail("stage '" + name + "' must be [\"engine\", \"cogrsim\" or \"none\", name]");
    out[*stage] = {*by, value[1].get<std::string>()};
  }
  return out;
}

}  // namespace cogrsim
