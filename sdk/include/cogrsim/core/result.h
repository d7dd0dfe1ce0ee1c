// Errors as values. Every error that a user or a file can cause is returned as a value; assertions
// are only for bugs in CogRSim itself.
#pragma once

#include <exception>
#include <new>
#include <string>
#include <utility>

// A result that is ignored is an error that is lost. The attribute must come before the definition.
#ifndef TL_EXPECTED_HPP
namespace tl {
template <class T, class E>
class [[nodiscard]] expected;
}
#endif
#include <tl/expected.hpp>

#include "cogrsim/core/source_position.h"

namespace cogrsim {

/// Indents every line of `text` but the first by two blanks, so that no line of foreign text can be
/// mistaken for a line of CogRSim's own output.
inline std::string indented(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    out += text[i];
    if (text[i] == '\n' && i + 1 < text.size() && text[i + 1] != ' ' && text[i + 1] != '\n')
      out += "  ";
  }
  return out;
}

/// An error: what went wrong, where, and the remedy. Texts start in lower case and have no final
/// stop. One that a file causes has its position in it; others may name the file or element in
/// `where`.
struct Error : SourcePosition {
  std::string message;  ///< the faulty value or element and what was expected
  std::string where;    ///< robot, folder, file as a whole …; may be empty
  std::string hint;     ///< how to correct the error; may be empty
  std::string code;     ///< stable code such as "CG0901"; may be empty

  Error() = default;
  explicit Error(std::string what, std::string location = {}, std::string remedy = {},
                 std::string stable_code = {})
      : message(std::move(what)),
        where(std::move(location)),
        hint(std::move(remedy)),
        code(std::move(stable_code)) {}
  Error(std::string what, SourcePosition position, std::string remedy = {},
        std::string stable_code = {})
      : SourcePosition(std::move(position)),
        message(std::move(what)),
        hint(std::move(remedy)),
        code(std::move(stable_code)) {}

  /// The whole error as text: "where: message", followed by a line "help: hint" if there is a hint.
  std::string text() const {
    std::string out = position_text();
    if (!out.empty()) out += ": ";
    if (!where.empty()) out += where + ": ";
    out = indented(out + message);
    if (!hint.empty()) out += "\nhelp: " + indented(hint);
    return out;
  }
};

template <class T = void>
using Result = tl::expected<T, Error>;

/// Creates the error value of a Result: `return fail("joint 'knee': …");`. The arguments are those
/// of the constructor of Error.
template <class... Args>
tl::unexpected<Error> fail(Args&&... args) {
  return tl::unexpected<Error>(Error(std::forward<Args>(args)...));
}

/// The message of an exception for users: its what(), or a plain text for std::bad_alloc.
inline std::string message_of(const std::exception& e) {
  return dynamic_cast<const std::bad_alloc*>(&e) != nullptr ? "the memory ran out" : e.what();
}

}  // namespace cogrsim
