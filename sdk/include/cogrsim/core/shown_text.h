// Safe display of untrusted text on a terminal. Names, messages and file names from scenes,
// recordings, packages and plugins could contain control sequences (colours, titles, overwriting of
// earlier output), reverse the direction of writing, or forge lines of output. All text printed for
// users passes through these functions.
#pragma once

#include <string>

#include "cogrsim/core/export.h"

namespace cogrsim {

/// Replaces by U+FFFD every character that could control a terminal: control characters (C0 except
/// newline and tab, DEL, C1), characters that reverse or hide text (U+061C, U+200E, U+200F, U+2028
/// to U+202E, U+2060 to U+206F, U+FEFF, U+FFF9 to U+FFFB, tags from U+E0000), and invalid UTF-8.
COGRSIM_API std::string printable(const std::string& text);

/// As printable(), for names: line breaks and tabs are replaced, too, so that a name cannot forge a
/// line of output.
COGRSIM_API std::string one_line(const std::string& text);

/// As printable(), for messages of several lines: all lines after the first are indented.
COGRSIM_API std::string paragraph(const std::string& text);

/// Escapes these characters in a JSON text. The JSON value stays the same.
COGRSIM_API std::string printable_json(const std::string& json);

}  // namespace cogrsim
