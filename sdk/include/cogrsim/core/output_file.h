// Rules for output files. An output file is either new, or replaces a regular file of the same kind
// that CogRSim wrote itself, or replaces any regular file if the user allowed overwriting. It is
// never an input of the same command, a link, a device, a pipe or a folder.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// Contents of an output file. Files of kind `other` carry a CogRSim mark only where their first line
/// begins with "# CogRSim"; without, they are only written as new files or with
/// OutputRules::overwrite.
enum class OutputKind {
  json,
  xml,
  csv,
  png,
  jpeg,
  svg,
  pdf,
  html,
  film,
  recording,
  snapshot,
  figure,
  script,
  learner,
  study,
  journal,
  text_table,
  other
};

/// Restrictions on where an output file may be written.
struct OutputRules {
  bool overwrite = false;           ///< allows replacing any regular file
  std::vector<std::string> inputs;  ///< files that the same command reads; they are never replaced
  /// If not empty: the output must lie inside this folder after links are resolved, and its
  /// extension must match its kind. Used for file names that a scene chooses.
  std::string folder;
};

/// Folder for outputs that a scene names: the value of the environment variable COGRSIM_OUTPUT_DIR,
/// or `scene_folder` if it is not set. Never empty.
COGRSIM_API std::string output_folder(const std::string& scene_folder);

/// Path inside `folder` of the output that a scene calls `name`. Errors: `name` is empty, absolute,
/// or leads out of the folder.
COGRSIM_API Result<std::string> output_in(const std::string& folder, const std::string& name);

/// Checks whether `path` may be written under `rules`, without changing anything. Call it before a
/// long computation. The error states the reason and the remedy.
COGRSIM_API Result<> check_output(const std::string& path, OutputKind kind,
                                  const OutputRules& rules = {});

/// Adds to `bytes` the mark by which CogRSim recognises its own files of this kind. The bytes stay
/// unchanged if the format identifies CogRSim by itself.
COGRSIM_API std::string marked(OutputKind kind, std::string bytes);

/// Writes `bytes` with the mark, atomically: into a temporary file next to `path` that then
/// replaces it. Errors: those of check_output() and of the operating system; `path` is then
/// unchanged.
COGRSIM_API Result<> write_output_file(const std::string& path, OutputKind kind, std::string bytes,
                                       const OutputRules& rules = {});

/// An output file that is written in pieces. The bytes go to a temporary file next to `path`, which
/// commit() renames to `path`. Destroying the object without commit() removes the temporary file.
/// Not thread-safe: use an object from one thread at a time.
class COGRSIM_API OutputFile {
 public:
  /// Creates the temporary file. Errors: those of check_output(), or the folder is not writable.
  static Result<OutputFile> create(const std::string& path, OutputKind kind,
                                   const OutputRules& rules = {});
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  /// Name of the temporary file, for external programs that write it directly. It has the same
  /// extension as `path`.
  const std::string& temporary() const { return temporary_; }
  /// Appends bytes. Errors: the disk is full; the file can then no longer be committed.
  Result<> append(std::string_view bytes);
  /// Flushes and closes the temporary file, checks the rules again, and renames it to its final
  /// name. Films, which an external program writes, get their mark here. Errors: those of
  /// check_output() and of the operating system.
  Result<> commit();

 private:
  OutputFile() = default;
  Result<> mark_film();
  Result<> flush();
  std::string path_, temporary_;
  OutputKind kind_ = OutputKind::other;
  OutputRules rules_;
  std::string buffer_;
  int descriptor_ = -1;
};

}  // namespace cogrsim
