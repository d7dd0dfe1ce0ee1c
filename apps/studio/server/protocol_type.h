// Types of the protocol's fields, read from TypeScript's notation.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cogrsim::studio {

struct FieldType {
  enum class Kind {
    string,
    integer,
    number,
    boolean,
    null,
    object,   ///< any
    literal,  ///< `name`
    named,    ///< `name` in protocol_types()
    list,     ///< of parts[0]
    tuple,    ///< of parts
    record,   ///< names to parts[0]
    one_of    ///< parts
  };
  Kind kind = Kind::object;
  std::string name;
  std::vector<FieldType> parts;
};

/// Throws std::logic_error for what is not in the notation: the table is wrong.
FieldType read_type(std::string_view text);

}  // namespace cogrsim::studio
