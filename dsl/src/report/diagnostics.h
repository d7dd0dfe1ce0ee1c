// Collects findings: many in one go, none twice.
#pragma once

#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/dsl/compiler.h"

namespace cogrsim::dsl {

struct Trail;
struct Element;
class SourceFiles;
class DiagnosticSink;

/// An entry of the catalog of codes (codes.cpp), where `explain` gets its text.
struct CodeInfo {
  const char* code;  ///< "CG0502"
  Severity severity;
  const char* title;  ///< short, as in the SARIF rule
  const char* cause;
  const char* cure;
  const char* example;  ///< bad and good XML
};
const std::vector<CodeInfo>& code_catalog();
const CodeInfo* find_code(std::string_view code);

/// Handle to the finding just reported, to add to it. Does nothing when it was a repeat.
class Report {
 public:
  Report(DiagnosticSink* sink, int index) : sink_(sink), index_(index) {}
  /// "did you mean …" or what else to do.
  Report& help(std::string text);
  /// A line with another source position: "first defined here".
  Report& note(std::string text, const SourceSpan& at = {});
  Report& note(std::string text, SourcePosition at);

 private:
  DiagnosticSink* sink_;
  int index_;  // -1: swallowed
};

/// sink.report("CG0502", span, element.trail, "expected an angle, found a length").help("…");
/// The severity comes from the catalog. The same code at the same position in another repeat or
/// instance is counted, not repeated: a note "and 4 more like it" is added at the end.
class DiagnosticSink {
 public:
  explicit DiagnosticSink(const Limits& limits) : limits_(limits) {}
  void set_files(const SourceFiles* files) { files_ = files; }

  Report report(std::string_view code, const SourceSpan& at, const Trail* trail,
                std::string message);
  /// At the element's name.
  Report report(std::string_view code, const Element& element, std::string message);
  /// At an attribute's value; at the element when it is not written.
  Report report(std::string_view code, const Element& element, std::string_view attribute,
                std::string message);

  int error_count() const { return errors_; }
  bool has_errors() const { return errors_ > 0; }

  /// All findings sorted by file and position, with excerpts, trails and counts.
  std::vector<Diagnostic> take();

 private:
  friend class Report;
  SourcePosition position(const SourceSpan& at) const;
  struct Entry {
    Diagnostic diagnostic;
    SourceSpan at;
    const Trail* trail = nullptr;
    int repeats = 0;
  };
  Limits limits_;
  const SourceFiles* files_ = nullptr;
  std::vector<Entry> entries_;
  std::unordered_map<std::string, std::vector<int>> by_position_;
  int errors_ = 0;
  int dropped_ = 0;
};

/// " did you mean 'x'?"-style help for `word`, or a list of the available names when none is near
/// and the list is short; "" when neither helps.
std::string suggest(std::string_view word, const std::vector<std::string>& known);

}  // namespace cogrsim::dsl
