// Diagnostics about a scene: the source location, what is wrong there, and the remedy.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/core/source_position.h"

namespace cogrsim {

/// `error`: the operation cannot be carried out. `warning`: it can, but the result may not be the
/// intended one. `note`: for information only.
enum class Severity { error, warning, note };

/// "error", "warning" or "note".
constexpr const char* severity_name(Severity severity) {
  return severity == Severity::error ? "error" : severity == Severity::warning ? "warning" : "note";
}

/// An additional line under a diagnostic, for example
/// "in instance 'bot' of prototype 'DiffBot', maze.scene.xml:52:5".
struct DiagnosticNote : SourcePosition {
  std::string message;

  DiagnosticNote() = default;
  explicit DiagnosticNote(std::string text, SourcePosition at = {})
      : SourcePosition(std::move(at)), message(std::move(text)) {}
};

/// One finding about a scene or a file.
struct Diagnostic : SourcePosition {
  Severity severity = Severity::error;
  std::string code;         ///< "CG0502"
  std::string message;      ///< starts in lower case and has no final stop
  std::string source_line;  ///< text of line `line`, shown as an excerpt; may be empty
  std::vector<DiagnosticNote> notes;
  std::string help;  ///< "did you mean …"; may be empty
};

/// An error as one of several findings; `code` if it has none of its own. What is not a position
/// in a file, such as the name of a robot, is put before the message.
inline Diagnostic to_diagnostic(const Error& error, const std::string& code = {}) {
  Diagnostic d;
  d.locate(error);
  d.code = error.code.empty() ? code : error.code;
  d.message = error.where.empty() ? error.message : error.where + ": " + error.message;
  d.help = error.hint;
  return d;
}

/// A finding as the one error of a Result.
inline Error to_error(const Diagnostic& d) { return Error(d.message, d, d.help, d.code); }

/// The first that is an error; null if there is none.
inline const Diagnostic* first_error(const std::vector<Diagnostic>& found) {
  for (const Diagnostic& d : found) {
    if (d.severity == Severity::error) return &d;
  }
  return nullptr;
}

}  // namespace cogrsim
