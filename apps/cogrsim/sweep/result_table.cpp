#include "sweep/result_table.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "common/quantities.h"
#include "sweep/sqlite_statement.h"
#include "sweep/sweep_table.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;

ResultTable::Cell cell_from(std::string text) {
  ResultTable::Cell cell;
  cell.number = std::numeric_limits<double>::quiet_NaN();
  if (text == "inf" || text == "-inf") {
    cell.number = text == "inf" ? std::numeric_limits<double>::infinity()
                                : -std::numeric_limits<double>::infinity();
  } else if (const auto number = parse_number(text)) {
    cell.number = *number;
  }
  cell.text = std::move(text);
  return cell;
}

Result<ResultTable> read_sqlite(const std::string& path) {
  const auto opened = open_database(path, false);
  if (!opened) return tl::unexpected(opened.error());
  sqlite3* const db = *opened;
  const std::unique_ptr<sqlite3, int (*)(sqlite3*)> owner(db, sqlite3_close);
  std::map<std::string, std::string> units = {{"end_time", "s"}, {"wall_time", "s"}};
  Statement columns(db, "SELECT name, unit FROM columns");
  while (columns && columns.row()) units[columns.text(0)] = columns.text(1);
  Statement rows(db, "SELECT * FROM runs");
  if (!columns || !rows) {
    return fail(fmt::format("'{}' is not a table of a study: {}", path, rows.error()));
  }
  ResultTable table;
  for (int c = 0; c < rows.columns(); ++c) {
    table.columns.push_back({rows.column_name(c), units[rows.column_name(c)]});
  }
  while (rows.row()) {
    auto& row = table.rows.emplace_back();
    for (int c = 0; c < rows.columns(); ++c) {
      ResultTable::Cell cell = cell_from(rows.type(c) == SQLITE_NULL ? "" : rows.text(c));
      if (rows.type(c) == SQLITE_FLOAT) cell.number = rows.number(c);
      row.push_back(std::move(cell));
    }
  }
  if (!rows.done()) return fail(fmt::format("'{}': {}", path, rows.error()));
  return table;
}

// Records of comma-separated values; quotes as RFC 4180 has them.
Result<std::vector<std::vector<std::string>>> csv_records(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(fmt::format("cannot read '{}'", path));
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  std::vector<std::vector<std::string>> records;
  std::vector<std::string> record;
  std::string cell;
  bool quoted_cell = false, open = false;
  const auto end_cell = [&] {
    record.push_back(std::move(cell));
    cell.clear();
    quoted_cell = false;
  };
  const auto end_record = [&] {
    end_cell();
    if (record.size() > 1 || !record[0].empty()) records.push_back(std::move(record));
    record.clear();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (open) {
      if (c != '"') {
        cell += c;
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        cell += c;
        ++i;
      } else {
        open = false;
      }
    } else if (c == '"' && cell.empty() && !quoted_cell) {
      open = quoted_cell = true;
    } else if (c == ',') {
      end_cell();
    } else if (c == '\n') {
      end_record();
    } else if (c != '\r') {
      cell += c;
    }
  }
  if (open) return fail(fmt::format("'{}' ends within quotes", path));
  if (!cell.empty() || !record.empty()) end_record();
  if (records.empty()) return fail(fmt::format("'{}' is empty", path));
  return records;
}

Result<ResultTable> read_csv(const std::string& path) {
  auto records = csv_records(path);
  if (!records) return tl::unexpected(records.error());
  ResultTable table;
  for (std::string& name : records->front()) table.columns.push_back({std::move(name), ""});
  for (std::size_t r = 1; r < records->size(); ++r) {
    if ((*records)[r].size() != table.columns.size()) {
      return fail(fmt::format("'{}': record {} has {} cells, the head has {}", path, r + 1,
                              (*records)[r].size(), table.columns.size()));
    }
    auto& row = table.rows.emplace_back();
    for (std::string& cell : (*records)[r]) row.push_back(cell_from(std::move(cell)));
  }
  return table;
}

}  // namespace

Result<std::size_t> ResultTable::find(const std::string& name) const {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (columns[c].name == name) return c;
    names.push_back(columns[c].name);
  }
  const std::string near = nearest_name(name, names);
  return fail(fmt::format("the table has no column '{}'", name), "",
              near.empty() ? fmt::format("it has {}", fmt::join(names, ", "))
                           : fmt::format("did you mean '{}'?", near));
}

bool is_result_table(const std::string& path) {
  std::error_code error;
  return path.ends_with(".sqlite") || path.ends_with(".csv") || fs::is_directory(path, error);
}

Result<ResultTable> read_result_table(const std::string& path) {
  std::error_code error;
  std::string file = path;
  if (fs::is_directory(path, error)) {
    file = (fs::path(path) / kTableName).string();
    if (!fs::exists(file, error)) {
      return fail(fmt::format("the folder '{}' has no {}", path, kTableName), "",
                  "name the folder that cogrsim sweep wrote to");
    }
  }
  if (!fs::exists(file, error)) return fail(fmt::format("there is no file '{}'", file));
  return file.ends_with(".csv") ? read_csv(file) : read_sqlite(file);
}

}  // namespace cogrsim::cli
