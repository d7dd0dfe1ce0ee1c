// A finding about a scene: a place in a file, what is wrong there, and the way out.
#pragma once

#include <string>
#include <vector>

namespace cogrsim {

/// Place in a source file; lines and columns count from 1, columns in UTF-8 code points.
/// `file` indexes SceneModel::files; -1: made by a program, no file.
struct SourceSpan {
  int file = -1;
  int line = 0;
  int column = 0;
  int length = 0;  ///< code points to underline; at least 1 where there is a place
};

enum class Severity { error, advice };

/// A line under a diagnostic: "in instance 'bot' of prototype 'DiffBot', maze.scene.xml:52:5".
struct DiagnosticNote {
  std::string message;
  std::string file;  ///< empty: no place
  int line = 0;
  int column = 0;
};

struct Diagnostic {
  Severity severity = Severity::error;
  std::string code;     ///< "CG0502"
  std::string message;  ///< lower-case, no final stop
  std::string file;     ///< as the user named it; empty: no place
  int line = 0;
  int column = 0;
  int length = 0;
  std::string source_line;  ///< text of that line, for the excerpt; may be empty
  std::vector<DiagnosticNote> notes;
  std::string help;  ///< "did you mean …"; may be empty
};

}  // namespace cogrsim
