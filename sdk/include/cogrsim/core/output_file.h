// The one rule for files that are written: an output is a new file, or a regular file of the same
// kind that CogRSim wrote, or the user said that it may be overwritten; never an input of the same
// work, never a link, a device, a pipe or a folder.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// What a file holds. `other`: a kind without a mark; only a new file, or with `overwrite`.
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

struct OutputRules {
  bool overwrite = false;           ///< a regular file may be replaced, whoever wrote it
  std::vector<std::string> inputs;  ///< files that are read by the same work: never replaced
  /// Not empty: whatever is written lies in this folder after links are resolved, and its name ends
  /// as its kind's names do. For names that a scene chose.
  std::string folder;
};

/// Where outputs that a scene names may be written: the folder in the environment variable
/// COGRSIM_OUTPUT_DIR, else `scene_folder`; never empty.
COGRSIM_API std::string output_folder(const std::string& scene_folder);

/// Where a scene's `name` for an output lies: inside `folder`. Errors: `name` is empty, absolute or
/// leads out of the folder.
COGRSIM_API Result<std::string> output_in(const std::string& folder, const std::string& name);

/// Whether `path` may be written by the rule; asked before long work. Changes nothing. Errors: what
/// is in the way, and the way out.
COGRSIM_API Result<> check_output(const std::string& path, OutputKind kind,
                                  const OutputRules& rules = {});

/// `bytes` with the mark by which CogRSim knows its own files of this kind again; unchanged where
/// the kind itself is the mark.
COGRSIM_API std::string marked(OutputKind kind, std::string bytes);

/// Writes `bytes`, marked, whole or not at all: into a new file beside `path`, which then takes its
/// place. Errors: check_output's, and the system's; `path` is then as it was.
COGRSIM_API Result<> write_output_file(const std::string& path, OutputKind kind, std::string bytes,
                                       const OutputRules& rules = {});

/// An output that grows: bytes go to a temporary file beside `path`, and commit() gives it its
/// name. Destroyed before: nothing is left. One thread at a time.
class COGRSIM_API OutputFile {
 public:
  /// Errors: check_output's, the folder is not writable.
  static Result<OutputFile> create(const std::string& path, OutputKind kind,
                                   const OutputRules& rules = {});
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  /// The temporary file's name, for programs that write it themselves; ends as `path` does.
  const std::string& temporary() const { return temporary_; }
  /// Errors: the disk is full; the file is then not committed.
  Result<> append(std::string_view bytes);
  /// Flushes, closes and renames; films, which other programs write, are marked. The rule is asked once more. Errors: the rule's, the system's.
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
