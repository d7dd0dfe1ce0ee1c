#include "sweep/sqlite_statement.h"

#include <fmt/format.h>

namespace cogrsim::cli {

int Statement::is_late(void* statement) {
  return std::chrono::steady_clock::now() > static_cast<Statement*>(statement)->deadline_ ? 1 : 0;
}

Result<sqlite3*> open_database(const std::string& path, bool writes) {
  sqlite3* db = nullptr;
  const int flags = writes ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READONLY;
  const auto refuse = [&](const std::string& message, const std::string& help = {}) {
    sqlite3_close(db);
    return fail(message, "", help);
  };
  if (sqlite3_open_v2(path.c_str(), &db, flags, nullptr) != SQLITE_OK)
    return refuse(fmt::format("cannot open '{}': {}", path, sqlite3_errmsg(db)));
  sqlite3_busy_timeout(db, 5000);
  for (const auto& [option, value] : {std::pair{SQLITE_DBCONFIG_DEFENSIVE, 1},
                                      {SQLITE_DBCONFIG_ENABLE_TRIGGER, 0},
                                      {SQLITE_DBCONFIG_ENABLE_VIEW, 0},
                                      {SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0}})
    sqlite3_db_config(db, option, value, nullptr);
  constexpr int kLongestCell = 16 << 20;  // [byte]
  sqlite3_limit(db, SQLITE_LIMIT_LENGTH, kLongestCell);
  // A view or a virtual table is a program that runs when it is read. Others that a user has added
  // are not read, and triggers do not run.
  Statement strange(db,
                    "SELECT type, name FROM sqlite_master WHERE "
                    "lower(name) IN ('study', 'columns', 'runs', 'provenance') AND "
                    "(type <> 'table' OR sql LIKE 'CREATE VIRTUAL%')");
  if (!strange) return refuse(fmt::format("'{}' is not a table of a study: {}", path,
                                          strange.error()));
  if (strange.row()) {
    const std::string what = strange.text(0), name = strange.text(1);
    return refuse(fmt::format("'{}' is not a table of a study: its '{}' is a {}", path, name,
                              what == "table" ? "virtual table" : what));
  }
  return db;
}

}  // namespace cogrsim::cli
