// Positions in source files: as stored in a model, and as shown to users.
#pragma once

#include <string>

namespace cogrsim {

/// Location in a source file. Lines and columns count from 1; columns are UTF-8 code points.
/// `file` is an index into SceneModel::files, or -1 if a program created the element (no file).
struct SourceSpan {
  int file = -1;
  int line = 0;
  int column = 0;
  int length = 0;  ///< code points to underline; at least 1 if the location is known
};

/// The same with the file's name: what errors and diagnostics bring to their readers.
struct SourcePosition {
  std::string file;  ///< path as the user wrote it; empty: no source location
  int line = 0;      ///< 0: only the file is known
  int column = 0;    ///< 0: only the line is known
  int length = 0;

  /// "maze.scene.xml:27:48", shorter if less is known, "" without a file.
  std::string position_text() const {
    if (file.empty() || line <= 0) return file;
    return file + ':' + std::to_string(line) +
           (column > 0 ? ':' + std::to_string(column) : std::string());
  }
  /// Sets these four members only.
  void locate(const SourcePosition& position) { *this = position; }
};

}  // namespace cogrsim
