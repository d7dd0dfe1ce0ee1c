// cogrsim plugins: what can be loaded, what it takes, where it was found, what was refused and why.
#include <unistd.h>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/physics/backend_plugin.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/sensing/sensor.h"
#include "common/json_text.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/provenance_text.h"
#include "common/refuse.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

struct Entry {
  PluginDescriptor descriptor;
  std::string path;  ///< empty: built in
  std::shared_ptr<const Backend> backend;
  std::string family;  ///< of an algorithm: "grid-planner"; read while its library is loaded
};

struct Inventory {
  std::vector<Entry> entries;
  std::vector<RefusedPlugin> refused;
  std::vector<std::string> folders;
};

Inventory take_inventory(const std::vector<std::string>& plugin_paths) {
  Inventory inventory;
  PluginLoader loader(plugin_paths);
  inventory.folders = loader.folders();
  for (const PluginDescriptor& sensor : built_in_sensors()) {
    inventory.entries.push_back({sensor, "", nullptr, ""});
  }
  for (const PluginPtr& plugin : loader.all(&inventory.refused)) {
    Entry entry{plugin->descriptor(), plugin->path(), nullptr, ""};
    if (entry.descriptor.kind == PluginKind::algorithm) {
      entry.family = static_cast<const AlgorithmEntry*>(entry.descriptor.factory)->family;
    }
    if (entry.descriptor.kind == PluginKind::backend) {
      auto backend = loader.backend(entry.descriptor.name);
      if (!backend) {
        inventory.refused.push_back({plugin->path(), backend.error().message, ""});
        continue;
      }
      entry.backend = *backend;
    }
    inventory.entries.push_back(std::move(entry));
  }
  return inventory;
}

std::string value_text(const ParameterValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return fmt::format("{}", *whole);
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{:g}", *number);
  if (const auto* text = std::get_if<std::string>(&value)) return "\"" + *text + "\"";
  std::string out = "[";
  for (const double number : std::get<std::vector<double>>(value)) {
    out += (out.size() > 1 ? " " : "") + fmt::format("{:g}", number);
  }
  return out + "]";
}

std::string range_text(const ParameterSpec& spec) {
  if (!spec.choices.empty()) {
    std::string out;
    for (const std::string& choice : spec.choices) out += (out.empty() ? "" : " | ") + choice;
    return out;
  }
  const bool low = std::isfinite(spec.minimum), high = std::isfinite(spec.maximum);
  if (low && high) return fmt::format("{:g} to {:g}", spec.minimum, spec.maximum);
  if (low) return fmt::format("at least {:g}", spec.minimum);
  if (high) return fmt::format("at most {:g}", spec.maximum);
  return "any";
}

std::string parameter_table(const std::string& title, const ParameterTable& parameters,
                            const Style& style) {
  if (parameters.empty()) return {};
  using Align = TextTable::Align;
  TextTable table({Align::left, Align::left, Align::left, Align::left, Align::left, Align::left});
  table.row({title, "type", "default", "unit", "range", "meaning"});
  for (const ParameterSpec& spec : parameters) {
    const bool unitless = spec.unit.empty() || spec.unit == "1";
    table.row({spec.name, to_string(spec.type()),
               spec.required ? "must be set" : value_text(spec.default_value),
               unitless ? "-" : spec.unit, range_text(spec), spec.description});
  }
  return table.text("    ", style.dim, style.off);
}

std::string output_table(const std::vector<PluginOutput>& outputs, const Style& style) {
  if (outputs.empty()) return {};
  using Align = TextTable::Align;
  TextTable table({Align::left, Align::left, Align::left});
  table.row({"output", "unit", "meaning"});
  for (const PluginOutput& output : outputs) {
    const bool unitless = output.unit.empty() || output.unit == "1";
    table.row({output.name, unitless ? "-" : output.unit, output.description});
  }
  return table.text("    ", style.dim, style.off);
}

std::string capability_table(const Capabilities& capabilities, const Style& style) {
  using Align = TextTable::Align;
  TextTable table({Align::left, Align::left, Align::left});
  table.row({"capability", "support", "note"});
  for (const auto& [feature, capability] : capabilities.all()) {
    table.row({feature, to_string(capability.support), capability.note});
  }
  return table.text("    ", style.dim, style.off);
}

// With the default options.
std::string provenance_table(const Backend& backend, const Style& style) {
  const auto provenance = provenance_of(backend, SceneModel());
  if (!provenance) {
    return fmt::format("    {}does not say who computes its results:{} {}\n", style.red, style.off,
                       provenance.error().message);
  }
  using Align = TextTable::Align;
  TextTable table({Align::left, Align::left});
  table.row({"stage", "computed by"});
  for (auto& row : provenance_rows({*provenance})) table.row(std::move(row));
  return table.text("    ", style.dim, style.off);
}

std::string inventory_text(const Inventory& inventory, const Style& style) {
  std::string out;
  for (const Entry& entry : inventory.entries) {
    const PluginDescriptor& d = entry.descriptor;
    out += fmt::format("{}{} {}{} {}{}\n", style.bold, to_string(d.kind), d.name, style.off,
                       d.version, d.author.empty() ? "" : ", by " + d.author);
    if (!d.summary.empty()) out += fmt::format("    {}\n", d.summary);
    if (!entry.family.empty()) out += fmt::format("    family: {}\n", entry.family);
    out += fmt::format("    found: {}\n", entry.path.empty() ? "built in" : one_line(entry.path));
    out += parameter_table("parameter", d.parameters, style);
    out += output_table(d.outputs, style);
    if (entry.backend) {
      out += parameter_table("world option", entry.backend->world_options(), style);
      for (const std::string_view element : kOptionElements)
        out += parameter_table(std::string(element) + " option",
                               entry.backend->element_options(element), style);
      out += provenance_table(*entry.backend, style);
      out += capability_table(entry.backend->capabilities(), style);
    }
    out += "\n";
  }
  for (const RefusedPlugin& refused : inventory.refused) {
    const bool lacks = !refused.unavailable.empty();
    out += fmt::format("{}{}{} {}\n    {}\n\n", lacks ? style.cyan : style.red,
                       lacks ? "not available" : "refused", style.off, one_line(refused.path),
                       paragraph(refused.reason));
  }
  out += style.bold + "folders searched" + style.off + "\n";
  for (const std::string& folder : inventory.folders) out += "    " + one_line(folder) + "\n";
  return out;
}

Json value_json(const ParameterValue& value) {
  return std::visit([](const auto& held) { return Json(held); }, value);
}

Json to_json(const ParameterTable& parameters) {
  Json out = Json::array();
  for (const ParameterSpec& spec : parameters) {
    // an open end has no figure
    const auto bound = [](double value) {
      return std::isfinite(value) ? Json(value) : Json(nullptr);
    };
    out.push_back({{"name", spec.name},
                   {"type", to_string(spec.type())},
                   {"default", value_json(spec.default_value)},
                   {"unit", spec.unit},
                   {"minimum", bound(spec.minimum)},
                   {"maximum", bound(spec.maximum)},
                   {"choices", spec.choices},
                   {"required", spec.required},
                   {"description", spec.description}});
  }
  return out;
}

Json to_json(const std::vector<PluginOutput>& outputs) {
  Json out = Json::array();
  for (const PluginOutput& output : outputs) {
    out.push_back(
        {{"name", output.name}, {"unit", output.unit}, {"description", output.description}});
  }
  return out;
}

Json to_json(const Inventory& inventory) {
  Json plugins = Json::array();
  for (const Entry& entry : inventory.entries) {
    const PluginDescriptor& d = entry.descriptor;
    Json item = {{"kind", to_string(d.kind)},
                 {"name", d.name},
                 {"version", d.version},
                 {"author", d.author},
                 {"summary", d.summary},
                 {"path", entry.path.empty() ? Json(nullptr) : Json(entry.path)},
                 {"built_in", entry.path.empty()},
                 {"parameters", to_json(d.parameters)},
                 {"outputs", to_json(d.outputs)}};
    if (!entry.family.empty()) item["family"] = entry.family;
    if (entry.backend) {
      item["engine_version"] = entry.backend->engine_version();
      if (const auto provenance = provenance_of(*entry.backend, SceneModel())) {
        item["provenance"] = cli::to_json(*provenance);
      }
      item["world_options"] = to_json(entry.backend->world_options());
      for (const std::string_view element : kOptionElements)
        item[std::string(element) + "_options"] = to_json(entry.backend->element_options(element));
      Json& capabilities = item["capabilities"] = Json::object();
      for (const auto& [feature, capability] : entry.backend->capabilities().all()) {
        capabilities[feature] = {{"support", to_string(capability.support)},
                                 {"note", capability.note}};
      }
    }
    plugins.push_back(std::move(item));
  }
  Json refused = Json::array();
  for (const RefusedPlugin& item : inventory.refused) {
    refused.push_back(
        {{"path", item.path},
         {"reason", item.reason},
         {"unavailable", item.unavailable.empty() ? Json() : Json(item.unavailable)}});
  }
  return {{"plugins", std::move(plugins)},
          {"refused", std::move(refused)},
          {"folders", inventory.folders}};
}

}  // namespace

int plugins_command(const PluginsOptions& options) {
  const Inventory inventory = take_inventory(options.plugin_paths);
  const auto printed =
      print_found(options.json, [&] { return json_text(to_json(inventory)); },
                  [&] { return inventory_text(inventory, style_of(fileno(standard_output()))); });
  return printed ? kGood : refuse(printed.error());
}

}  // namespace cogrsim::cli
