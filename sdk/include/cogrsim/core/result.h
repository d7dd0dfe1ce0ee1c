// Errors that a user or a file can cause travel as values; assertions are for our own bugs.
#pragma once

#include <exception>
#include <new>
#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace cogrsim {

/// `text` with two blanks before every line but the first, so that none passes for one of ours.
inline std::string indented(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    out += text[i];
    if (text[i] == '\n' && i + 1 < text.size() && text[i + 1] != ' ' && text[i + 1] != '\n')
      out += "  ";
  }
  return out;
}

/// What went wrong, where, and the way out. Lower-case sentences without a final stop.
struct Error {
  std::string message;  ///< the offender and what was expected
  std::string where;    ///< file:line:column, robot, folder …; may be empty
  std::string hint;     ///< what to do about it; may be empty
  std::string code;     ///< stable code such as "CG0901"; may be empty

  Error() = default;
  explicit Error(std::string what, std::string place = {}, std::string way_out = {},
                 std::string stable_code = {})
      : message(std::move(what)),
        where(std::move(place)),
        hint(std::move(way_out)),
        code(std::move(stable_code)) {}

  /// All of it on as many lines as it needs: "where: message" and "help: hint".
  std::string text() const {
    std::string out = indented(where.empty() ? message : where + ": " + message);
    if (!hint.empty()) out += "\nhelp: " + indented(hint);
    return out;
  }
};

template <class T = void>
using Result = tl::expected<T, Error>;

/// `return fail("joint 'knee': …");`
template <class... Args>
tl::unexpected<Error> fail(Args&&... args) {
  return tl::unexpected<Error>(Error(std::forward<Args>(args)...));
}

/// What an exception says to people: its what(), or that the memory ran out.
inline std::string words_of(const std::exception& e) {
  return dynamic_cast<const std::bad_alloc*>(&e) != nullptr ? "the memory ran out" : e.what();
}

}  // namespace cogrsim
