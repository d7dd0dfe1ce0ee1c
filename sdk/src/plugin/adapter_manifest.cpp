#include "plugin/adapter_manifest.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cogrsim/core/json_bounds.h"

namespace cogrsim {

namespace {

namespace files = std::filesystem;
using ManifestJson = nlohmann::json;

/// What is wrong with a manifest: thrown within this file alone.
struct ManifestFault {
  std::string what, hint;
};

std::string text_of(const ManifestJson& object, const char* key, bool required) {
  const auto found = object.find(key);
  if (found == object.end()) {
    if (required) throw ManifestFault{fmt::format("'{}' is missing", key), ""};
    return "";
  }
  if (!found->is_string() || (required && found->get_ref<const std::string&>().empty()))
    throw ManifestFault{fmt::format("'{}' must be a text", key), ""};
  return found->get<std::string>();
}

void refuse_unknown(const ManifestJson& object, const std::string& what,
                    const std::vector<std::string>& known) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string near = nearest_name(key, known);
    throw ManifestFault{fmt::format("{} has no member '{}'", what, key),
                        near.empty() ? fmt::format("there are: {}", fmt::join(known, ", "))
                                     : fmt::format("did you mean '{}'?", near)};
  }
}

/// As of plugins that `cogrsim new` makes: small letters, digits and _.
bool is_backend_name(const std::string& name) {
  return !name.empty() && name.size() <= 64 && name.front() >= 'a' && name.front() <= 'z' &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
         });
}

void take_manifest(const ManifestJson& json, AdapterManifest& out) {
  if (!json.is_object()) throw ManifestFault{"it is not a JSON object", ""};
  refuse_unknown(json, "a backend.json",
                 {"name", "engine", "version", "author", "summary", "protocol", "command", "needs",
                  "reads", "writes", "patience"});
  out.name = text_of(json, "name", true);
  if (!is_backend_name(out.name)) {
    throw ManifestFault{fmt::format("'{}' is not a name of a backend", out.name),
                        "names are small letters, digits and _, and begin with a letter"};
  }
  out.engine = text_of(json, "engine", true);
  out.version = text_of(json, "version", false);
  out.author = text_of(json, "author", false);
  out.summary = text_of(json, "summary", false);
  const auto protocol = json.find("protocol");
  if (protocol == json.end() || !protocol->is_number_integer())
    throw ManifestFault{"'protocol' must be the version of the protocol, a whole number",
                        fmt::format("this CogRSim speaks {}", kAdapterProtocol)};
  if (*protocol != kAdapterProtocol) {
    throw ManifestFault{
        fmt::format("it speaks version {} of the protocol, and this CogRSim version {}",
                    protocol->dump(), kAdapterProtocol),
        "take the cogrsim_backend library of this CogRSim: `cogrsim new backend --language "
        "js|python` "
        "writes it"};
  }
  const auto command = json.find("command");
  const auto is_text = [](const ManifestJson& entry) {
    return entry.is_string() && entry.get_ref<const std::string&>().find('\0') == std::string::npos;
  };
  if (command == json.end() || !command->is_array() || command->empty() ||
      !std::all_of(command->begin(), command->end(), is_text) ||
      command->front().get_ref<const std::string&>().empty()) {
    throw ManifestFault{"'command' must be a list of texts that begins with a program",
                        "for example [\"node\", \"adapter.mjs\"]"};
  }
  out.command = command->get<std::vector<std::string>>();
  for (const auto& [key, to] : {std::pair{"reads", &out.reads}, {"writes", &out.writes}}) {
    const auto paths = json.find(key);
    if (paths == json.end()) continue;
    const auto is_path = [&](const ManifestJson& one) {
      if (!is_text(one)) return false;
      const auto& path = one.get_ref<const std::string&>();
      return (path.rfind('/', 0) == 0 || path.rfind("~/", 0) == 0) &&
             path.find('\n') == std::string::npos;
    };
    if (!paths->is_array() || !std::all_of(paths->begin(), paths->end(), is_path))
      throw ManifestFault{fmt::format("'{}' must be a list of files and folders", key),
                          "they begin with / or ~/"};
    *to = paths->get<std::vector<std::string>>();
  }
  const auto patience = json.find("patience");
  if (patience != json.end()) {
    if (!patience->is_number() || !(patience->get<double>() > 0.0))
      throw ManifestFault{"'patience' must be a number of seconds above 0", ""};
    out.patience = patience->get<double>();
  }
  const auto needs = json.find("needs");
  if (needs == json.end()) return;
  if (!needs->is_array()) throw ManifestFault{"'needs' must be a list", ""};
  for (const ManifestJson& need : *needs) {
    if (!need.is_object()) throw ManifestFault{"each of 'needs' must be an object", ""};
    refuse_unknown(need, "an entry of 'needs'", {"program", "file", "install"});
    AdapterManifest::Need& one = out.needs.emplace_back();
    one.program = text_of(need, "program", false);
    one.file = text_of(need, "file", false);
    one.install = text_of(need, "install", false);
    if (one.program.empty() == one.file.empty())
      throw ManifestFault{"each of 'needs' must name a program or a file", ""};
  }
}

}  // namespace

std::string program_on_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  const std::string list = path ? path : "/usr/local/bin:/usr/bin:/bin";
  for (std::size_t begin = 0, end; begin <= list.size(); begin = end + 1) {
    end = std::min(list.find(':', begin), list.size());
    const files::path file = files::path(list.substr(begin, end - begin)) / program;
    std::error_code error;
    if (files::is_regular_file(file, error) && ::access(file.c_str(), X_OK) == 0)
      return file.string();
  }
  return "";
}

Result<AdapterManifest> read_adapter_manifest(const std::string& path) {
  const auto refuse = [&](const std::string& what, const std::string& hint) {
    return fail(what, path, hint, "CG0910");
  };
  std::error_code error;
  AdapterManifest out;
  out.path = files::canonical(path, error).string();
  if (error) return refuse(error.message(), "");
  if (!files::is_regular_file(out.path, error)) return refuse("it is not a regular file", "");
  out.folder = files::path(out.path).parent_path().string();
  std::ifstream in(out.path, std::ios::binary);
  constexpr std::size_t kMost = 1 << 20;
  std::string text(kMost + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad() || !in.is_open()) return refuse("it cannot be read", "");
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMost) return refuse("it is larger than 1 MB", "");
  if (const std::string excess = json_excess(text); !excess.empty())
    return refuse("it " + excess, "");
  try {
    take_manifest(ManifestJson::parse(text), out);
  } catch (const ManifestFault& fault) {
    return refuse(fault.what, fault.hint);
  } catch (const ManifestJson::exception& e) {
    return refuse(std::string("it is not JSON: ") + e.what(), "");
  }
  return out;
}

std::string missing_of(const AdapterManifest& manifest) {
  std::vector<std::string> missing;
  const auto add = [&](const std::string& what, const std::string& install) {
    missing.push_back(what + (install.empty() ? "" : " (" + install + ")"));
  };
  std::error_code error;
  bool program_named = false;
  for (const AdapterManifest::Need& need : manifest.needs) {
    if (!need.program.empty()) {
      program_named = program_named || need.program == manifest.command.front();
      if (program_on_path(need.program).empty())
        add(need.program + " is not installed", need.install);
    } else if (!files::exists(files::path(manifest.folder) / need.file, error)) {
      add(need.file + " is missing in " + manifest.folder, need.install);
    }
  }
  const std::string& program = manifest.command.front();
  if (program_named) return fmt::format("{}", fmt::join(missing, "; "));
  if (program.find('/') == std::string::npos) {
    if (program_on_path(program).empty()) add(program + " is not installed", "");
  } else if (const files::path file = files::path(manifest.folder) / program;
             ::access(file.c_str(), X_OK) != 0) {
    add(file.string() + " is not a program", "");
  }
  return fmt::format("{}", fmt::join(missing, "; "));
}

std::vector<std::string> adapters_in(const std::string& folder) {
  std::vector<std::string> out;
  const auto take = [&](const files::path& file) {
    std::error_code error;
    if (files::exists(files::symlink_status(file, error))) out.push_back(file.string());
  };
  take(files::path(folder) / kAdapterFile);
  try {
    for (const files::directory_entry& entry : files::directory_iterator(folder)) {
      std::error_code error;
      if (entry.is_directory(error)) take(entry.path() / kAdapterFile);
    }
  } catch (const files::filesystem_error&) {
    // a folder that does not exist or cannot be read has no plugins
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace cogrsim
