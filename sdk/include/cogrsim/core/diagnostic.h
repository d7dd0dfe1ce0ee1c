// Diagnostics about a scene: the source location, what is wrong there, and the remedy.
#pragma once

#include <string>
#include <vector>

namespace cogrsim {

/// Location in a source file. Lines and columns count from 1; columns are UTF-8 code points.
/// `file` is an index into SceneModel::files, or -1 if a program created the element (no file).
struct SourceSpan {
  int file = -1;
  int line = 0;
  int column = 0;
  int length = 0;  ///< code points to underline; at least 1 if the location is known
};

/// `error`: the operation cannot be carried out. `warning`: it can, but the result may not be the
/// intended one. `note`: for information only.
enum class Severity { error, warning, note };

/// "error", "warning" or "note".
constexpr const char* severity_name(Severity severity) {
  return severity == Severity::error ? "error" : severity == Severity::warning ? "warning" : "note";
}

/// An additional line under a diagnostic, for example
/// "in instance 'bot' of prototype 'DiffBot', maze.scene.xml:52:5".
struct DiagnosticNote {
  std::string message;
  std::string file;  ///< empty: no source location
  int line = 0;
  int column = 0;
};

/// One finding about a scene or a file.
struct Diagnostic {
  Severity severity = Severity::error;
  std::string code;     ///< "CG0502"
  std::string message;  ///< starts in lower case and has no final stop
  std::string file;     ///< path as the user wrote it; empty: no source location
  int line = 0;
  int column = 0;
  int length = 0;
  std::string source_line;  ///< text of line `line`, shown as an excerpt; may be empty
  std::vector<DiagnosticNote> notes;
  std::string help;  ///< "did you mean …"; may be empty
};

}  // namespace cogrsim
