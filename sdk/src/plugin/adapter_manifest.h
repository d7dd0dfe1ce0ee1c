// backend.json: a backend that is another program, an adapter, in any language.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

/// Of the frames between an adapter and its host. Raised when an older library would misread them.
inline constexpr int kAdapterProtocol = 1;
/// Stands in the adapter's folder.
inline constexpr const char* kAdapterFile = "backend.json";

/// The contents of a backend.json.
struct AdapterManifest {
  /// What the adapter cannot run without.
  struct Need {
    std::string program;  ///< on the PATH
    std::string file;     ///< or this one, relative to the folder of the adapter
    std::string install;  ///< how to get it; may be empty
  };
  std::string path, folder;  ///< absolute
  std::string name, version, author, summary;
  std::string engine;                ///< "Rapier"
  std::vector<std::string> command;  ///< program first
  std::vector<Need> needs;
  std::vector<std::string> reads, writes;  ///< files and folders outside of its own; "~/…": of the user
  double patience = 30.0;  ///< time after which an answer is given up [s]
};

/// Reads it. Errors (CG0910), which name the file: it is not JSON, a member is missing, unknown or of a
/// wrong type, the name is no name, or the protocol is another version.
Result<AdapterManifest> read_adapter_manifest(const std::string& path);

/// What is missing of the manifest's needs and its program, with the remedies: "node is not installed
/// (apt install nodejs)"; empty: nothing. Starts no program.
std::string missing_of(const AdapterManifest& manifest);

/// The first program of this name on the PATH; empty: there is none.
std::string program_on_path(const std::string& program);

class Backend;

/// The factory table of such a plugin is the first member, whose `get` is a nullptr.
struct AdapterPlugin;
/// Makes the plugin; defined in physics.
std::shared_ptr<const PluginDescriptor> make_adapter_plugin(AdapterManifest manifest);

/// "FOLDER/backend.json" and "FOLDER/*/backend.json", those that exist, sorted.
std::vector<std::string> adapters_in(const std::string& folder);

}  // namespace cogrsim
