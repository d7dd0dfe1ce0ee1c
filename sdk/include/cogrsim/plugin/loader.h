// Finds, checks and loads plugin libraries.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

class Backend;

/// A loaded library; whoever keeps the pointer keeps the code mapped.
class COGRSIM_API Plugin {
 public:
  const PluginDescriptor& descriptor() const;
  const std::string& path() const;
  ~Plugin();
  struct Impl;
  explicit Plugin(std::unique_ptr<Impl> impl);

 private:
  std::unique_ptr<Impl> impl_;
};
using PluginPtr = std::shared_ptr<const Plugin>;

/// A library that was found but refused, and why.
struct RefusedPlugin {
  std::string path;
  std::string reason;
};

/// Looks plugins up by name: NAME.so in, in this order, the folders given, those of the
/// environment variable COGRSIM_PLUGIN_PATH (separated by ':'), and the ones beside libcogrsim
/// (…/lib/cogrsim/backends, …/lib/cogrsim/plugins; the same in a build tree and in an installed
/// one). Loads each at most once. May be used by several threads at once.
class COGRSIM_API PluginLoader {
 public:
  explicit PluginLoader(std::vector<std::string> extra_folders = {});

  /// Errors (CG0901 not found, CG0902 refused, CG0903 wrong kind): every place tried and why it
  /// failed, and, for an unknown name, what exists.
  Result<PluginPtr> load(PluginKind kind, const std::string& name);

  /// The plugin in this very file. Errors: CG0902.
  Result<PluginPtr> load_from(const std::string& path);

  /// The library of a plugin as it lies on disk now, loaded a second time beside the first.
  /// load() does not know of it until replace() is called. Errors: CG0902.
  Result<PluginPtr> load_anew(const Plugin& plugin);
  /// From now on load() gives `fresh` where it gave the library that was at the same path.
  void replace(PluginPtr fresh);

  /// Loads a backend and returns its factory; keeps the library loaded with the returned pointer.
  /// `choice` may carry options, see cogrsim/physics/backend_choice.h; they are checked, and
  /// Simulation::create applies them. Errors: CG0901, CG0902; options that it does not take.
  Result<std::shared_ptr<const Backend>> backend(const std::string& choice);

  /// Everything that can be loaded from the folders, sorted by kind and name, and what was refused.
  std::vector<PluginPtr> all(std::vector<RefusedPlugin>* refused = nullptr);

  const std::vector<std::string>& folders() const { return folders_; }

 private:
  Result<PluginPtr> load_file(const std::string& path);
  std::vector<PluginPtr> list(std::vector<RefusedPlugin>* refused);

  std::vector<std::string> folders_;
  std::mutex mutex_;  ///< guards what follows
  std::vector<PluginPtr> loaded_;
};

}  // namespace cogrsim
