#include "cogrsim/physics/provenance.h"

#include <fmt/format.h>

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/backend.h"

namespace cogrsim {
namespace {

using Json = nlohmann::json;

/// The texts of a provenance beside its stages and options, by JSON key.
struct TextField {
  const char* key;
  std::string Provenance::*text;
};
constexpr TextField kTexts[] = {{"backend", &Provenance::backend},
                                {"engine", &Provenance::engine},
                                {"version", &Provenance::version},
                                {"solver", &Provenance::solver},
                                {"formulation", &Provenance::formulation},
                                {"integrator", &Provenance::integrator},
                                {"cogrsim_version", &Provenance::cogrsim_version}};

constexpr ComputedBy kComputedBy[] = {ComputedBy::unanswered, ComputedBy::engine,
                                      ComputedBy::cogrsim, ComputedBy::none};

Json options_json(const Parameters& options) {
  Json out = Json::object();
  for (const auto& [name, value] : options) out[name] = option_text(value);
  return out;
}

Parameters options_from(const Json& json) {
  Parameters out;
  for (const auto& [name, value] : json.items()) out[name] = value.get<std::string>();
  return out;
}

const Parameters& block_of(const std::map<std::string, Parameters>& blocks, const char* engine) {
  static const Parameters none;
  const auto found = blocks.find(engine);
  return found == blocks.end() ? none : found->second;
}

}  // namespace

std::string library_version(const std::string& headers, const void* address) {
  Dl_info info{};
  std::error_code error;
  if (::dladdr(address, &info) == 0 || !info.dli_fname) return headers;
  const auto path = std::filesystem::canonical(info.dli_fname, error);
  return error ? headers : headers + " (" + path.filename().string() + ")";
}

const char* to_string(StepStage stage) {
  switch (stage) {
    case StepStage::broad_phase:
      return "broad-phase";
    case StepStage::narrow_phase:
      return "narrow-phase";
    case StepStage::contact_memory:
      return "contact-memory";
    case StepStage::contact_law:
      return "contact-law";
    case StepStage::friction:
      return "friction";
    case StepStage::restitution:
      return "restitution";
    case StepStage::joints:
      return "joints";
    case StepStage::limits:
      return "limits";
    case StepStage::motors:
      return "motors";
    case StepStage::integrator:
      return "integrator";
  }
  return "?";
}

const char* to_string(ComputedBy by) {
  switch (by) {
    case ComputedBy::unanswered:
      return "unanswered";
    case ComputedBy::engine:
      return "engine";
    case ComputedBy::cogrsim:
      return "cogrsim";
    case ComputedBy::none:
      return "none";
  }
  return "?";
}

Result<Provenance> provenance_of(const Backend& backend, const SceneModel& model) {
  auto options = complete_parameters(backend.world_options(),
                                     block_of(model.physics.engine_options, backend.name()));
  if (!options) return tl::unexpected(options.error());
  Provenance out = backend.provenance(*options);
  out.backend = backend.name();
  out.version = backend.engine_version();
  out.cogrsim_version = COGRSIM_VERSION;
  out.options = std::move(*options);
  const auto defaults = complete_parameters(backend.element_options("assembly"), {});
  for (const AssemblyInfo& assembly : model.assemblies) {
    if (assembly.removed) continue;
    auto complete = complete_parameters(backend.element_options("assembly"),
                                        block_of(assembly.engine_options, backend.name()));
    if (!complete) return tl::unexpected(complete.error());
    if (defaults && *complete == *defaults) continue;
    out.assembly_options[assembly.name] = std::move(*complete);
  }
  if (auto whole = check_provenance(out); !whole) return tl::unexpected(whole.error());
  return out;
}

Result<> check_provenance(const Provenance& provenance) {
  std::string lacking;
  const auto note = [&](const std::string& what) {
    lacking += (lacking.empty() ? "" : "\n") + what;
  };
  for (const TextField& field : kTexts) {
    if ((provenance.*field.text).empty()) note(fmt::format("its {} is not named", field.key));
  }
  for (const StepStage stage : kStepStages) {
    const StageOrigin& origin = provenance[stage];
    if (origin.by == ComputedBy::unanswered) {
      note(fmt::format("it does not declare what computes {}", to_string(stage)));
    } else if (origin.name.empty()) {
      note(fmt::format("it does not name what computes {}", to_string(stage)));
    }
  }
  if (lacking.empty()) return {};
  return fail(lacking, "",
              "declare every stage of cogrsim/physics/provenance.h in Backend::provenance()");
}

std::string option_text(const ParameterValue& value) {
  struct Text {
    std::string operator()(bool flag) const { return flag ? "true" : "false"; }
    std::string operator()(std::int64_t whole) const { return fmt::format("{}", whole); }
    std::string operator()(double number) const { return fmt::format("{}", number); }
    std::string operator()(const std::string& text) const { return text; }
    std::string operator()(const std::vector<double>& numbers) const {
      return fmt::format("{}", fmt::join(numbers, " "));
    }
  };
  return std::visit(Text(), value);
}

std::string summary_text(const Provenance& p) {
  return fmt::format("{} {}, {}, {}, {}", p.engine, p.version, p.solver, p.formulation,
                     p.integrator);
}

std::string to_json_text(const Provenance& provenance) {
  Json out;
  for (const TextField& field : kTexts) out[field.key] = provenance.*field.text;
  for (const StepStage stage : kStepStages) {
    const StageOrigin& origin = provenance[stage];
    out["stages"][to_string(stage)] = {{"by", to_string(origin.by)}, {"name", origin.name}};
  }
  out["options"] = options_json(provenance.options);
  out["assembly_options"] = Json::object();
  for (const auto& [name, options] : provenance.assembly_options) {
    out["assembly_options"][name] = options_json(options);
  }
  out["left_out"] = Json::array();
  for (const LeftOut& one : provenance.left_out)
    out["left_out"].push_back({{"feature", one.feature}, {"of", one.of}, {"count", one.count}});
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<Provenance> parse_provenance(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    Provenance out;
    for (const TextField& field : kTexts) out.*field.text = json.at(field.key).get<std::string>();
    for (const StepStage stage : kStepStages) {
      const Json& entry = json.at("stages").at(to_string(stage));
      auto by = entry.at("by").get<std::string>();
      if (by == "nobody") by = to_string(ComputedBy::none);  // recordings of version 0.1
      const auto* const found =
          std::find_if(std::begin(kComputedBy), std::end(kComputedBy),
                       [&](ComputedBy candidate) { return by == to_string(candidate); });
      if (found == std::end(kComputedBy)) {
        return fail(fmt::format("provenance: stage {} is computed by '{}', which is not known",
                                to_string(stage), by));
      }
      out[stage] = {*found, entry.at("name").get<std::string>()};
    }
    out.options = options_from(json.at("options"));
    for (const auto& [name, options] : json.at("assembly_options").items()) {
      out.assembly_options[name] = options_from(options);
    }
    for (const Json& one : json.value("left_out", Json::array()))  // not in older recordings
      out.left_out.push_back({one.at("feature"), one.at("of"), one.at("count")});
    return out;
  } catch (const Json::exception& e) {
    return fail(fmt::format("not a provenance: {}", e.what()));
  }
}

}  // namespace cogrsim
