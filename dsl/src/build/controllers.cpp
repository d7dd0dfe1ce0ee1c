// Controllers, supervisors and engine blocks: the parameters of plugins.
#include <algorithm>
#include <sstream>

#include "build/build_scene.h"

namespace cogrsim::dsl {

// All attributes of one element, checked against `table`. Without a table their types and units are
// unknown: "50 deg" may be an angle, or a mistake for a distance.
bool Builder::take_parameters(const Element& element, const ParameterTable* table,
                              Parameters& given) {
  Reader r = reader(element);
  bool good = true;
  if (table == nullptr && !element.node->attributes.empty()) {
    fault("CG0909", element, "parameters of plugins cannot be checked without the plugins")
        .help("compile with a plugin catalog, a dsl::LoaderCatalog in CompileOptions::plugins");
    return false;
  }
  for (const Attribute& attribute : element.node->attributes) {
    const std::string name(attribute.name);
    if (given.count(name) != 0) {
      good = false;
      sink().report("CG0904", attribute.name_span, element.trail,
                    "parameter '" + name + "' is set twice");
      continue;
    }
    const auto spec = std::find_if(table->begin(), table->end(),
                                   [&](const ParameterSpec& s) { return s.name == name; });
    if (spec == table->end()) {
      good = false;
      std::vector<std::string> known;
      for (const ParameterSpec& s : *table) known.push_back(s.name);
      sink()
          .report("CG0904", attribute.name_span, element.trail,
                  "there is no parameter '" + name + "' here")
          .help(known.empty() ? "it takes no parameters" : suggest(name, known));
      continue;
    }
    auto value = r.parameter(attribute, *spec);
    // A text may name elements of the scene; renaming needs to know these names.
    if (context_.outline != nullptr && spec->type() == ParameterType::text &&
        spec->choices.empty()) {
      std::istringstream words{std::string(attribute.value)};
      for (std::string word; words >> word;) names_.peek(element, word);
    }
    if (value.given())
      given.emplace(name, std::move(value.value));
    else
      good = false;
  }
  return good;
}

std::optional<Parameters> Builder::plugin_parameters(const Element& element, PluginKind kind,
                                                     const std::string& plugin, Parameters given) {
  const ParameterTable* table = nullptr;
  Result<ParameterTable> found = ParameterTable{};
  if (context_.options.plugins != nullptr) {
    found = context_.options.plugins->parameters(kind, plugin);
    if (!found) {
      const Error& error = found.error();
      fault(find_code(error.code) != nullptr ? error.code : "CG0901", element, "plugin",
            error.message)
          .help(error.hint);
      return std::nullopt;
    }
    table = &*found;
  }
  bool good = true;
  for (const Element* child : element.children)
    if (child->tag() == "set") good = take_parameters(*child, table, given) && good;
  if (element.incomplete) good = false;
  if (!good) return std::nullopt;
  if (table == nullptr) return given;
  auto complete = complete_parameters(*table, given);
  if (!complete) {
    fault("CG0904", element, "plugin", plugin + ": " + complete.error().message)
        .help(complete.error().hint);
    return std::nullopt;
  }
  return *complete;
}

void Builder::controller(const Element& element) {
  ControllerModel controller;
  controller.name = element.path;
  controller.origin = element.span();
  Reader r = reader(element);
  controller.rate = *r.number("rate");
  rates_.push_back({&element, controller.rate});
  controller.on_fault =
      *r.text("on-fault") == "end-run" ? FaultPolicy::end_run : FaultPolicy::stop_controller;
  const bool is_supervisor = element.tag() == "supervisor";
  const bool connects = !is_supervisor && r.has("connect");
  Parameters given;
  if (connects) {
    const auto address = r.text("connect");
    if (!address.given()) return;
    given["connect"] = *address;
    controller.plugin = "socket";
  }
  if (!connects || r.has("plugin")) {
    if (!r.has("plugin")) {
      fault("CG0204", element, "<controller> needs the attribute \"plugin\" or \"connect\"")
          .help("add plugin=\"…\"");
      return;
    }
    const auto plugin = r.text("plugin");
    if (!plugin.given()) return;
    if (connects && *plugin != "socket") {
      fault("CG0904", element, "connect", "only the plugin 'socket' connects to another program")
          .help("remove plugin=\"" + *plugin + "\"");
      return;
    }
    controller.plugin = *plugin;
  }
  if (!is_supervisor) {
    if (const std::string isolation = *r.text("isolation"); !isolation.empty())
      controller.isolation = isolation == "process" ? Isolation::process : Isolation::none;
    controller.deadline = *r.number("deadline");
    controller.memory = *r.number("memory");
    for (const char* bound : {"deadline", "memory"}) {
      if (controller.isolation == Isolation::process || !r.has(bound)) continue;
      idle_bounds_.push_back({&element, bound});
    }
    controller.assembly = note(element).assembly;
    if (controller.assembly < 0)
      fault("CG0202", element, "a controller must be inside the assembly that it commands")
          .help(
              "wrap the robot and its controller in an <assembly>; a <supervisor> serves the "
              "whole scene");
  }
  auto parameters =
      plugin_parameters(element, is_supervisor ? PluginKind::supervisor : PluginKind::controller,
                        controller.plugin, std::move(given));
  if (!parameters) return;
  controller.parameters = std::move(*parameters);
  if (context_.options.plugins != nullptr)
    controller.outputs = context_.options.plugins->outputs(
        is_supervisor ? PluginKind::supervisor : PluginKind::controller, controller.plugin);
  (is_supervisor ? model_.supervisors : model_.controllers).push_back(std::move(controller));
}

void Builder::engine_blocks(const Element& element, std::map<std::string, Parameters>& options) {
  for (const Element* child : element.children) {
    if (child->node->spec != nullptr || !is_engine_block(*child->node, context_.files)) continue;
    const std::string engine(child->tag());
    const ParameterTable* table = nullptr;
    Result<ParameterTable> found = ParameterTable{};
    if (context_.options.plugins != nullptr) {
      const std::string_view tag = element.tag();
      found = tag == "physics" ? context_.options.plugins->world_options(engine)
                               : context_.options.plugins->element_options(
                                     engine, is_joint(tag)       ? "joint"
                                             : tag == "instance" ? "assembly"
                                                                 : tag);
      if (!found) {
        const Error& error = found.error();
        fault(find_code(error.code) != nullptr ? error.code : "CG0901", *child, error.message)
            .help(error.hint);
        continue;
      }
      table = &*found;
    }
    Parameters given;
    if (options.count(engine) != 0) {
      fault("CG0904", *child, "there is a second block for '" + engine + "' here")
          .help("merge the blocks");
      continue;
    }
    if (take_parameters(*child, table, given)) options.emplace(engine, std::move(given));
  }
}

}  // namespace cogrsim::dsl
