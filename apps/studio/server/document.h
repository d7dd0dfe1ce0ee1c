// The scene's text and its one history: edits by typing, in the tree, with handles and in forms.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/dsl/compiler.h"
#include "run.h"
#include "talk.h"

namespace cogrsim::studio {

struct DocumentOptions {
  std::string path;  ///< of the scene file; need not exist yet: an empty scene then
  std::map<std::string, std::string> parameters;  ///< `--set`
  std::optional<std::uint64_t> seed;
  std::vector<std::string> without;  ///< of tests
  bool allow_build = false;
  std::string state_folder;  ///< for journals that cannot lie beside the scene; "": none
};

/// The part that answers everything in PROTOCOL.md under "The document". Works on a thread of its
/// own: compiling never delays the network or the run.
class Document : public Part {
 public:
  /// Compiles and passes good scenes to `show`. Errors: the file is there and cannot be read, or is
  /// no UTF-8.
  static Result<std::unique_ptr<Document>> open(DocumentOptions options,
                                                std::shared_ptr<PluginLoader> loader, Run& run,
                                                Outbox& outbox);

  /// What the user should know of earlier unsaved changes: a sentence each.
  virtual const std::vector<std::string>& notes() const = 0;
  /// Nothing is answered any more. Returns where unsaved changes are kept; "": all is saved.
  virtual std::string finish() = 0;
};

}  // namespace cogrsim::studio
