// Frames as rows of tables: the columns that `cogrsim replay --csv` writes and Python reads.
#pragma once

#include <functional>
#include <string_view>
#include <variant>
#include <vector>

#include "cogrsim/physics/frame.h"

namespace cogrsim {

enum class FrameTable { frames, bodies, joints, contacts, events };

struct TableColumn {
  const char* name;
  const char* unit = "";
  bool is_name = false;  ///< of texts, not numbers
};

/// A number, a name, or nothing where a row has no value. Names are valid during the call.
using TableValue = std::variant<std::monostate, double, std::string_view>;

COGRSIM_API const std::vector<TableColumn>& columns_of(FrameTable table);

/// Calls `use` with each row of a frame: a value per column, in their order. Removed elements have
/// no rows. A joint has a row per coordinate; one with more speeds than positions, or the reverse,
/// has rows without the one or the other.
COGRSIM_API void for_rows(FrameTable table, const Frame& frame,
                          const std::function<void(const std::vector<TableValue>&)>& use);

}  // namespace cogrsim
