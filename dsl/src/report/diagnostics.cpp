#include "report/diagnostics.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "syntax/element.h"
#include "syntax/node.h"
#include "syntax/xml_scan.h"

namespace cogrsim::dsl {
namespace {

constexpr int kLongestTrail = 12;              // lines of backtrace shown
constexpr std::size_t kLongestExcerpt = 4000;  // bytes of source line kept

/// Identifies a source position; line and column are enough.
std::string place_key(std::string_view code, const SourceSpan& at) {
  return std::string(code) + ':' + std::to_string(at.file) + ':' + std::to_string(at.line) + ':' +
         std::to_string(at.column);
}

/// The line as it may be shown: control characters, which could steer a terminal, and bytes that
/// are no UTF-8 are replaced one for one; very long lines are cut.
std::string presentable(std::string_view line) {
  std::string out;
  for (std::size_t i = 0; i < line.size() && out.size() < kLongestExcerpt;) {
    const CodePoint c = decode_utf8(line, i);
    const bool control = (c.value < 0x20 && c.value != '\t') || (c.value >= 0x7F && c.value < 0xA0);
    if (c.length == 0 || control) {
      out += "\xEF\xBF\xBD";
    } else {
      out += line.substr(i, static_cast<std::size_t>(c.length));
    }
    i += static_cast<std::size_t>(std::max(1, c.length));
  }
  return out;
}

}  // namespace

Report& Report::help(std::string text) {
  if (index_ < 0 || text.empty()) return *this;
  std::string& help = sink_->entries_[index_].diagnostic.help;
  if (!help.empty()) help += '\n';
  help += text;
  return *this;
}

Report& Report::note(std::string text, const SourceSpan& at) {
  return note(std::move(text), sink_->position(at));
}

Report& Report::note(std::string text, SourcePosition at) {
  if (index_ < 0) return *this;
  sink_->entries_[index_].diagnostic.notes.emplace_back(std::move(text), std::move(at));
  return *this;
}

Report DiagnosticSink::report(std::string_view code, const SourceSpan& at, const Trail* trail,
                              std::string message) {
  const CodeInfo* info = find_code(code);
  assert(info && "every code is in the catalog");
  const Severity severity = info->severity;
  if (severity == Severity::error) ++errors_;

  // The same finding again: the same message, or the same position in another iteration.
  std::vector<int>& here = by_position_[place_key(code, at)];
  int same = -1;
  for (const int i : here) {
    const Entry& e = entries_[i];
    if (e.diagnostic.message == message && (at.file >= 0 || e.trail == trail)) {
      same = i;
      break;
    }
    if (at.file >= 0 && e.trail != trail && same < 0) same = i;
  }
  if (same >= 0) {
    Entry& e = entries_[same];
    if (e.trail != trail) ++e.repeats;  // two reports on one element are one finding
    return Report(this, -1);
  }
  if (entries_.size() >= static_cast<std::size_t>(std::max(1, limits_.diagnostics))) {
    ++dropped_;
    return Report(this, -1);
  }

  Entry e;
  e.diagnostic.severity = severity;
  e.diagnostic.code = std::string(code);
  e.diagnostic.message = std::move(message);
  e.at = at;
  e.trail = trail;
  e.diagnostic.locate(position(at));
  if (e.diagnostic.line > 0)
    e.diagnostic.source_line = presentable(files_->file(at.file).line(at.line));
  here.push_back(static_cast<int>(entries_.size()));
  entries_.push_back(std::move(e));
  return Report(this, static_cast<int>(entries_.size()) - 1);
}

Report DiagnosticSink::report(std::string_view code, const Element& element, std::string message) {
  return report(code, element.span(), element.trail, std::move(message));
}

Report DiagnosticSink::report(std::string_view code, const Element& element,
                              std::string_view attribute, std::string message) {
  const Attribute* a = element.find(attribute);
  return report(code, a ? a->value_span : element.span(), element.trail, std::move(message));
}

SourcePosition DiagnosticSink::position(const SourceSpan& at) const {
  if (at.file < 0 || !files_) return {};
  return {files_->file(at.file).name, at.line, at.column, at.length};
}

std::vector<Diagnostic> DiagnosticSink::take() {
  std::vector<std::size_t> order(entries_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const SourceSpan& p = entries_[a].at;
    const SourceSpan& q = entries_[b].at;
    if (p.file != q.file) return p.file >= 0 && (q.file < 0 || p.file < q.file);
    if (p.line != q.line) return p.line < q.line;
    return p.column < q.column;
  });
  std::vector<Diagnostic> out;
  for (const std::size_t i : order) {
    Entry& e = entries_[i];
    int shown = 0;
    for (const Trail* t = e.trail; t && shown < kLongestTrail; t = t->up, ++shown) {
      e.diagnostic.notes.emplace_back(t->text, position(t->at));
    }
    if (e.repeats > 0) {
      e.diagnostic.notes.emplace_back("and " + std::to_string(e.repeats) + " more");
    }
    out.push_back(std::move(e.diagnostic));
  }
  if (dropped_ > 0 && !out.empty()) {
    out.back().notes.emplace_back(std::to_string(dropped_) + " further findings are not shown");
  }
  entries_.clear();
  by_position_.clear();
  return out;
}

std::string suggest(std::string_view word, const std::vector<std::string>& known) {
  const std::string near = nearest_name(std::string(word), known);
  if (!near.empty()) return "did you mean \"" + near + "\"?";
  if (known.empty() || known.size() > 12) return {};
  std::string out = "available: ";
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (i) out += i + 1 == known.size() ? " and " : ", ";
    out += known[i];
  }
  return out;
}

}  // namespace cogrsim::dsl
