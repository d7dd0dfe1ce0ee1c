// A strict scan of a file's text: refuses what XML 1.0 (Fifth Edition) refuses and tinyxml2 lets
// pass, and records the position of every name and value.
#pragma once

#include <utility>
#include <vector>

#include "report/diagnostics.h"
#include "syntax/node.h"

namespace cogrsim::dsl {

/// Appends one Node per element to `document`, in document order, with spans, parents and raw
/// attributes (names and values as views into the file's text, entities not yet replaced).
/// Returns whether the text is well-formed and within limits; if not, that was reported, several
/// errors where the scan could continue. `instructions` gets the byte ranges [begin, end) of
/// processing instructions, which mean nothing here.
bool scan_xml(const SourceFile& file, int file_index, const Limits& limits, DiagnosticSink& sink,
              Document& document, std::vector<std::pair<std::size_t, std::size_t>>& instructions);

/// Byte offsets at which the lines of a text begin; a line ends with \n, \r\n or \r.
std::vector<std::uint32_t> find_line_starts(std::string_view text);

/// A code point and the bytes it takes; length 0: not UTF-8.
struct CodePoint {
  std::uint32_t value = 0;
  int length = 0;
};
CodePoint decode_utf8(std::string_view text, std::size_t at);

}  // namespace cogrsim::dsl
