// What the language's several small scanners ask of a character.
#pragma once

namespace cogrsim::dsl {

/// White space as XML has it.
inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

}  // namespace cogrsim::dsl
