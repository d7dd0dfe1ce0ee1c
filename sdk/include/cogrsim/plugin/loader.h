// Search, check and loading of plugin libraries.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

class Backend;

/// A loaded library. The library stays loaded as long as the object exists.
class COGRSIM_API Plugin {
 public:
  const PluginDescriptor& descriptor() const;
  const std::string& path() const;
  /// Whether it stands for another program: a backend in a process of its own.
  bool is_program() const;
  ~Plugin();
  struct Impl;
  explicit Plugin(std::unique_ptr<Impl> impl);

 private:
  std::unique_ptr<Impl> impl_;
};
using PluginPtr = std::shared_ptr<const Plugin>;

/// What was found but rejected, and the reason.
struct RefusedPlugin {
  std::string path;
  std::string reason;
  /// Name of a backend in another program with which nothing is wrong: something that it needs is not
  /// installed. Empty: it is refused for another reason.
  std::string unavailable;
};

/// Loads plugins by name. It searches NAME.so in the given folders, then in those of the
/// environment variable COGRSIM_PLUGIN_PATH (separated by ':'), and then next to libcogrsim
/// (…/lib/cogrsim/backends and …/lib/cogrsim/plugins, in a build tree as in an installation). Each
/// library is loaded at most once. A backend may also be another program: NAME/backend.json in such a
/// folder, or backend.json in it (docs/plugins/backends-in-any-language.md). Thread-safe.
class COGRSIM_API PluginLoader {
 public:
  explicit PluginLoader(std::vector<std::string> extra_folders = {});

  /// Loads a plugin. Errors (CG0901 not found, CG0902 and CG0910 rejected, CG0903 wrong kind): all searched
  /// paths with the reasons of failure, and for an unknown name the existing plugins.
  Result<PluginPtr> load(PluginKind kind, const std::string& name);

  /// Loads the plugin in this file. Errors: CG0902.
  Result<PluginPtr> load_from(const std::string& path);

  /// Loads the current file of a plugin as a second copy next to the loaded one. load() returns it
  /// only after replace(). Errors: CG0902.
  Result<PluginPtr> load_fresh_copy(const Plugin& plugin);
  /// Makes load() return `fresh` instead of the library with the same path.
  void replace(PluginPtr fresh);

  /// Loads a backend and returns its factory; the library stays loaded as long as the pointer
  /// exists. `choice` may have options, see cogrsim/physics/backend_choice.h; they are checked here
  /// and applied by Simulation::create(). Errors: CG0901, CG0902, CG0910, or an option that the
  /// backend does not have.
  Result<std::shared_ptr<const Backend>> backend(const std::string& choice);

  /// All plugins in the folders, sorted by kind and name. Rejected libraries, and backends in other
  /// programs that lack what they need, are added to `refused`.
  std::vector<PluginPtr> all(std::vector<RefusedPlugin>* refused = nullptr);

  const std::vector<std::string>& folders() const { return folders_; }

 private:
  Result<PluginPtr> load_file(const std::string& path);
  std::vector<PluginPtr> list(std::vector<RefusedPlugin>* refused);
  tl::unexpected<Error> missing(PluginKind kind, const std::string& name,
                                const std::string& tried) const;

  std::vector<std::string> folders_;
  std::mutex mutex_;  ///< protects the following members
  std::vector<PluginPtr> loaded_;
};

}  // namespace cogrsim
