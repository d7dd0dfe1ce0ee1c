// Text of strangers on a terminal: names, messages and file names out of scenes, recordings, packages
// and plugins can steer it (colours, titles, what was written before), turn the direction of writing,
// and forge lines. Everything that is printed for people goes through here.
#pragma once

#include <string>

#include "cogrsim/core/export.h"

namespace cogrsim {

/// `text` with U+FFFD for what could steer a terminal: control characters (C0 but newline and tab, DEL,
/// C1), what turns or hides text (U+061C, U+200E, U+200F, U+2028 to U+202E, U+2060 to U+206F, U+FEFF,
/// U+FFF9 to U+FFFB, tags from U+E0000), and bytes that are no UTF-8.
COGRSIM_API std::string printable(const std::string& text);

/// The same for a name: line breaks and tabs are replaced, too, so that it forges no line.
COGRSIM_API std::string one_line(const std::string& text);

/// The same for a message of several lines: those after the first are indented.
COGRSIM_API std::string paragraph(const std::string& text);

/// JSON text in which such characters are escaped: the same JSON to programs.
COGRSIM_API std::string printable_json(const std::string& json);

}  // namespace cogrsim
