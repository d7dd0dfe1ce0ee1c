// The table of a study, read again: from results.sqlite or results.csv.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/result.h"

namespace cogrsim::cli {

struct ResultTable {
  struct Column {
    std::string name, unit;
  };
  struct Cell {
    std::string text;
    double number;  ///< NaN where the text is not a number
  };
  std::vector<Column> columns;
  std::vector<std::vector<Cell>> rows;  ///< cells by column

  /// Errors: no such column, with the nearest there is.
  Result<std::size_t> find(const std::string& name) const;
};

/// Whether `path` is a study's folder, or a table by its ending (.sqlite, .csv).
bool is_result_table(const std::string& path);

/// Errors: it cannot be read, or is no table of a study.
Result<ResultTable> read_result_table(const std::string& path);

}  // namespace cogrsim::cli
