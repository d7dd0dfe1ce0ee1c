// Finds out which files a scene consists of.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/result.h"
#include "manifest.h"

namespace cogrsim::share {

struct GatherOptions {
  std::string scene;
  std::vector<std::string> include;       ///< further files: below the scene's folder, or .mcap
  std::vector<std::string> plugin_paths;  ///< where the scene's plugins are, to compile it
};

struct Gathered {
  /// A file on this machine and its path in the package.
  struct Source {
    std::string from, path;
    Role role = Role::data;
  };
  std::string scene;                    ///< its path in the package
  std::vector<Source> files;            ///< by path
  std::vector<std::string> notes;       ///< what was left out, and why
  std::vector<Diagnostic> diagnostics;  ///< the compiler's; with an error `files` is empty
  bool ok() const { return !files.empty(); }
};

/// The scene, what the compiler read for it, files that parameters of controllers, supervisors and
/// sensors name, the sources beside the scene (CMakeLists.txt, *.cpp, *.h …), and what was included.
/// Errors: a file that a package does not take, or outside of the scene's folder.
Result<Gathered> gather(const GatherOptions& options);

/// Copies the files into `folder`, as they will be in the package, and fills in sizes and hashes.
Result<> stage(const Gathered& gathered, const std::string& folder, Manifest& manifest);

/// Errors of compiling the scene `file`, with the plugins found in `plugin_paths`; empty: none.
std::vector<Diagnostic> compile_errors(const std::string& file,
                                       const std::vector<std::string>& plugin_paths);

}  // namespace cogrsim::share
