// Records of gdb's machine interface (MI, version 3): one line each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "talk.h"

namespace cogrsim::studio {

/// The longest line that is read [byte]; gdb's own answers are far below.
constexpr std::size_t kMostMiLine = 4u << 20;

struct MiRecord {
  enum class Kind {
    result,  ///< the answer to a command: `^done`, `^running`, `^error`, `^exit`
    exec,    ///< `*stopped`, `*running`
    status,  ///< `+download`
    notify,  ///< `=breakpoint-modified`
    console,
    target,
    log,    ///< text: `~"…"`, `@"…"`, `&"…"`
    prompt  ///< `(gdb)`
  };
  Kind kind = Kind::prompt;
  std::optional<std::uint64_t> token;  ///< of the command that it answers
  std::string what;                    ///< "done", "stopped"; of a text: the text
  /// Tuples are objects, lists arrays; all else is text. Of a list of results only the values are
  /// kept; of a name that comes twice in a tuple, the last.
  Json fields = Json::object();
};

/// Reads one line, without its line end. Errors: it is no record, it is cut off, it is nested more
/// than 64 deep, or it is longer than kMostMiLine.
Result<MiRecord> read_mi_record(std::string_view line);

/// A text as a parameter of a command, in quotes. Errors: it has a character that no line of a
/// command can have (a line end, a zero), or over 10,000 bytes.
Result<std::string> mi_quoted(std::string_view text);

/// The text at a name of a tuple; "": there is none.
std::string mi_text(const Json& tuple, const char* name);
/// The whole number at a name of a tuple; nullopt: there is none, or it is out of range.
std::optional<int> mi_number(const Json& tuple, const char* name);

}  // namespace cogrsim::studio
