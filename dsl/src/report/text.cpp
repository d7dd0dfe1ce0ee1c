// Diagnostics as text for people.
#include <algorithm>

#include "cogrsim/core/shown_text.h"
#include "cogrsim/dsl/compiler.h"

namespace cogrsim::dsl {
namespace {

struct Style {
  const char *error, *warning, *strong, *frame, *help, *off;
};
constexpr Style kPlain = {"", "", "", "", "", ""};
constexpr Style kAnsi = {"\x1b[1;31m", "\x1b[1;33m", "\x1b[1m", "\x1b[34m", "\x1b[32m", "\x1b[0m"};

/// Blanks before the caret: as wide as what stands above them; tabs stay tabs.
std::string indent_of(const std::string& line, int column) {
  std::string out;
  int at = 1;
  for (std::size_t i = 0; i < line.size() && at < column; ++i) {
    const auto c = static_cast<unsigned char>(line[i]);
    if ((c & 0xC0) == 0x80) continue;  // inside a code point
    out += c == '\t' ? '\t' : ' ';
    ++at;
  }
  out.append(static_cast<std::size_t>(std::max(0, column - at)), ' ');
  return out;
}

int code_points(const std::string& text) {
  return static_cast<int>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

/// One excerpt shows a window of a long line, so that a machine-made file stays readable.
struct Excerpt {
  std::string line;
  int column;
};
Excerpt window(const std::string& line, int column) {
  constexpr int kWidth = 160;
  const int total = code_points(line);
  if (total <= kWidth) return {line, column};
  const int first = std::clamp(column - kWidth / 2, 1, total);
  std::string out;
  int at = 0;
  for (const char c : line) {
    if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) ++at;
    if (at >= first && at < first + kWidth) out += c;
  }
  return {first > 1 ? "…" + out : out, column - first + (first > 1 ? 2 : 1)};
}

}  // namespace

// Strangers choose the names of files and what stands in them: nothing of it may steer a terminal, or
// look like another diagnostic.
std::string to_text(const Diagnostic& given, bool color) {
  Diagnostic d = given;
  d.code = one_line(d.code);
  d.message = paragraph(d.message);
  d.file = one_line(d.file);
  d.source_line = printable(d.source_line);
  d.help = printable(d.help);
  for (DiagnosticNote& n : d.notes) {
    n.message = paragraph(n.message);
    n.file = one_line(n.file);
  }
  const Style& s = color ? kAnsi : kPlain;
  const bool bad = d.severity == Severity::error;
  std::string out = std::string(bad ? s.error : s.warning) + severity_name(d.severity) +
                    (d.code.empty() ? "" : "[" + d.code + "]") + s.off + s.strong + ": " +
                    d.message + s.off + "\n";
  // The bars are aligned, behind the line number.
  const std::string number = d.line > 0 ? std::to_string(d.line) : "";
  const std::string gutter(number.empty() ? 2 : number.size(), ' ');
  if (!d.file.empty()) {
    out += gutter + s.frame + "--> " + s.off + d.position_text() + "\n";
  }
  // Of very long lines only the start is kept; a caret would point beyond it.
  if (!d.source_line.empty() && d.line > 0 && d.column <= code_points(d.source_line) + 1) {
    const Excerpt e = window(d.source_line, d.column);
    const int most = std::max(1, code_points(e.line) - e.column + 1);
    const auto carets = static_cast<std::size_t>(std::clamp(d.length, 1, most));
    const std::string pad(gutter.size() - number.size(), ' ');
    const std::string bar = gutter + s.frame + " |" + s.off;
    out += bar + "\n";
    out += s.frame + pad + number + " |" + s.off + " " + e.line + "\n";
    out += bar + " " + indent_of(e.line, e.column) + (bad ? s.error : s.warning) +
           std::string(carets, '^') + s.off + "\n";
  }
  for (const DiagnosticNote& n : d.notes) {
    out += gutter + s.frame + " = " + s.off + n.message;
    if (!n.file.empty()) out += ", " + n.position_text();
    out += "\n";
  }
  if (!d.help.empty()) {
    std::size_t begin = 0;
    while (begin <= d.help.size()) {
      const std::size_t end = std::min(d.help.find('\n', begin), d.help.size());
      out += std::string(s.help) + (begin == 0 ? "help: " : "      ") + s.off +
             d.help.substr(begin, end - begin) + "\n";
      begin = end + 1;
    }
  }
  return out;
}

std::string to_text(const std::vector<Diagnostic>& diagnostics, bool color) {
  std::string out;
  for (const Diagnostic& d : diagnostics) {
    if (!out.empty()) out += "\n";
    out += to_text(d, color);
  }
  return out;
}

}  // namespace cogrsim::dsl
