// A thin hold on SQLite's databases and statements.
#pragma once

#include <sqlite3.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "cogrsim/core/result.h"

namespace cogrsim::cli {

/// "name" as an identifier in SQL.
inline std::string quoted(const std::string& name) {
  std::string out = "\"";
  for (const char c : name) {
    out += c;
    if (c == '"') out += c;
  }
  return out + "\"";
}

/// Opens the table of a study, which a stranger may have made: nothing that it has beside rows is run.
/// To be closed by sqlite3_close(). Errors: it is no database, or `runs` and the like are views or
/// virtual tables.
Result<sqlite3*> open_database(const std::string& path, bool writes);

/// One that takes longer than a minute is interrupted, which is an error.
class Statement {
 public:
  Statement(sqlite3* db, const std::string& sql) : db_(db) {
    constexpr int kStepsBetween = 100'000;  // of SQLite's machine, some milliseconds
    sqlite3_progress_handler(db, kStepsBetween, is_late, this);
    good_ = sqlite3_prepare_v2(db, sql.c_str(), -1, &statement_, nullptr) == SQLITE_OK;
  }
  ~Statement() {
    sqlite3_progress_handler(db_, 0, nullptr, nullptr);
    sqlite3_finalize(statement_);
  }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  explicit operator bool() const { return good_; }
  std::string error() const { return sqlite3_errmsg(db_); }

  void bind(int index, const std::string& text) {
    sqlite3_bind_text(statement_, index, text.data(), static_cast<int>(text.size()),
                      SQLITE_TRANSIENT);
  }
  void bind(int index, double value) {  // NaN becomes NULL
    sqlite3_bind_double(statement_, index, value);
  }
  /// SQLite's integers have a sign; larger numbers are kept as text.
  void bind(int index, std::uint64_t value) {
    if (value <= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
      sqlite3_bind_int64(statement_, index, static_cast<sqlite3_int64>(value));
    } else {
      bind(index, std::to_string(value));
    }
  }

  /// What a row of another statement has.
  void bind(int index, const Statement& row, int column) {
    sqlite3_bind_value(statement_, index, sqlite3_column_value(row.statement_, column));
  }
  /// Ready for other values.
  void again() { sqlite3_reset(statement_); }

  /// The next row; false: there is none, or an error.
  bool row() {
    status_ = sqlite3_step(statement_);
    return status_ == SQLITE_ROW;
  }
  bool done() const { return status_ == SQLITE_DONE; }
  int columns() const { return sqlite3_column_count(statement_); }
  std::string column_name(int column) const { return sqlite3_column_name(statement_, column); }
  int type(int column) const { return sqlite3_column_type(statement_, column); }
  std::string text(int column) const {
    const auto* bytes = sqlite3_column_text(statement_, column);
    return bytes == nullptr ? "" : reinterpret_cast<const char*>(bytes);
  }
  double number(int column) const { return sqlite3_column_double(statement_, column); }
  std::int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }

 private:
  static int is_late(void* statement);
  sqlite3* db_;
  std::chrono::steady_clock::time_point deadline_ =
      std::chrono::steady_clock::now() + std::chrono::minutes(1);
  sqlite3_stmt* statement_ = nullptr;
  bool good_ = false;
  int status_ = SQLITE_OK;
};

}  // namespace cogrsim::cli
