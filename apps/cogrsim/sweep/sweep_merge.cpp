// Tables of a study's shards become one.
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include <fmt/format.h>

#include "sweep/sqlite_statement.h"
#include "sweep/sweep_table.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;

using Database = std::unique_ptr<sqlite3, decltype(&sqlite3_close)>;

// For a while: there may be more shards than a process may have files.
Result<Database> open_part(const std::string& path) {
  const auto opened = open_database(path, false);
  if (!opened) return tl::unexpected(opened.error());
  return Database(*opened, sqlite3_close);
}

// One table, as its first rows say.
struct Part {
  std::string path;
  Json definition, shard;
  std::size_t number = 0, of = 0;
  std::vector<std::vector<std::string>> engines;  // backend, engine, its version, ours
};

std::string shard_text(const Part& part) { return fmt::format("{}/{}", part.number, part.of); }

std::vector<std::vector<std::string>> rows_of(sqlite3* db, const char* sql) {
  std::vector<std::vector<std::string>> out;
  Statement rows(db, sql);
  while (rows && rows.row()) {
    out.emplace_back();
    for (int c = 0; c < rows.columns(); ++c) out.back().push_back(rows.text(c));
  }
  return out;
}

Result<> read_part(const std::string& given, Part& part) {
  part.path = fs::is_directory(given) ? (fs::path(given) / kTableName).string() : given;
  if (!fs::is_regular_file(part.path))
    return fail(fmt::format("there is no '{}'", part.path), "",
                "give the folders of the shards, as they were with -o");
  const auto database = open_part(part.path);
  if (!database) return tl::unexpected(database.error());
  sqlite3* const db = database->get();
  Statement study(db, "SELECT key, value FROM study");
  while (study && study.row()) {
    if (study.text(0) == "definition") part.definition = Json::parse(study.text(1), nullptr, false);
    if (study.text(0) == "shard") part.shard = Json::parse(study.text(1), nullptr, false);
  }
  if (!study || !study.done() || !part.definition.is_object())
    return fail(fmt::format("'{}' is not a table of a study", part.path));
  if (part.shard.is_null())
    return fail(fmt::format("'{}' is not a shard, it is a whole study", part.path), "",
                "shards are made with --shard 3/16");
  part.number = whole_number(part.shard, "number");
  part.of = whole_number(part.shard, "of");
  if (part.number < 1 || part.number > part.of || part.of > kMostRuns ||
      !part.shard.contains("hash"))
    return fail(
        fmt::format("'{}' is damaged: it says to be shard {}", part.path, shard_text(part)));
  part.engines =
      rows_of(db, "SELECT backend, engine, version, cogrsim_version FROM provenance ORDER BY 1");
  Statement count(db, "SELECT count(*) FROM runs");
  if (!count || !count.row()) return fail(fmt::format("'{}': {}", part.path, count.error()));
  const auto there = static_cast<std::size_t>(count.integer(0));
  const std::size_t planned = whole_number(part.shard, "cases");
  if (there != planned)
    return fail(
        fmt::format("shard {} has {} of its {} runs, in '{}'", shard_text(part), there, planned,
                    part.path),
        "",
        fmt::format("the command that made it, with --shard {}, runs the rest", shard_text(part)));
  return {};
}

Result<> check_same_study(const Part& first, const Part& other) {
  const auto refuse = [&](const std::string& what) {
    return fail(
        fmt::format("'{}' and '{}' are not shards of one study: {}", first.path, other.path, what));
  };
  if (const auto different = definition_differences(first.definition, other.definition);
      !different.empty())
    return refuse(fmt::format("{}", fmt::join(different, "; ")));
  if (first.of != other.of)
    return refuse(fmt::format("one is {}, the other {}", shard_text(first), shard_text(other)));
  if (first.shard.at("hash") != other.shard.at("hash"))
    return refuse("other values, seeds or engines");
  for (const auto& one : first.engines) {
    for (const auto& two : other.engines) {
      if (one[0] == two[0] && one != two)
        return refuse(
            fmt::format("backend {} is {} {} of CogRSim {} in one, {} {} of CogRSim {} "
                        "in the other",
                        one[0], one[1], one[2], one[3], two[1], two[2], two[3]));
    }
  }
  return {};
}

Result<> check_complete(const std::vector<Part>& parts) {
  std::map<std::size_t, const Part*> known;
  for (const Part& part : parts) {
    const auto [there, fresh] = known.emplace(part.number, &part);
    if (!fresh)
      return fail(fmt::format("shard {} is given twice: '{}' and '{}'", shard_text(part),
                              there->second->path, part.path));
  }
  std::vector<std::string> missing;
  for (std::size_t number = 1; number <= parts.front().of; ++number) {
    if (known.count(number) == 0) missing.push_back(std::to_string(number));
  }
  if (missing.empty()) return {};
  const std::size_t count = missing.size();
  constexpr std::size_t kMostNamed = 20;
  if (count > kMostNamed) missing.resize(kMostNamed);
  return fail(fmt::format("{} of {} shards missing: {}{}", count, parts.front().of,
                          fmt::join(missing, ", "), count > kMostNamed ? ", …" : ""),
              "", "merge when all are done");
}

}  // namespace

Result<> SweepTable::take_rows(sqlite3* from, const std::string& source, const std::string& table) {
  Statement rows(from, "SELECT * FROM " + quoted(table) + " ORDER BY rowid");
  if (!rows) return fail(fmt::format("'{}': {}", source, rows.error()));
  std::string names, values;
  for (int c = 0; c < rows.columns(); ++c) {
    names += (c ? ", " : "") + quoted(rows.column_name(c));
    values += c ? ", ?" : "?";
  }
  Statement insert(
      db_, "INSERT OR REPLACE INTO " + quoted(table) + " (" + names + ") VALUES (" + values + ")");
  if (!insert) return fail(fmt::format("'{}': {}", path_, insert.error()));
  while (rows.row()) {
    for (int c = 0; c < rows.columns(); ++c) insert.bind(c + 1, rows, c);
    insert.row();
    if (!insert.done()) return fail(fmt::format("'{}': {}", path_, insert.error()));
    insert.again();
  }
  if (!rows.done()) return fail(fmt::format("'{}': {}", source, rows.error()));
  return {};
}

Result<> SweepTable::fill_from(sqlite3* from, const std::string& source) {
  Statement columns(from, "SELECT name, kind, unit FROM columns ORDER BY rowid");
  while (columns && columns.row()) {
    if (columns.text(1) == "parameter") continue;
    if (auto good = add_measure_column(columns.text(0), columns.text(2)); !good) return good;
  }
  if (!columns || !columns.done()) return fail(fmt::format("'{}': {}", source, columns.error()));
  for (const char* table : {"provenance", "runs"}) {
    if (auto good = take_rows(from, source, table); !good) return good;
  }
  return {};
}

Result<SweepTable> SweepTable::merge(const std::vector<std::string>& shards,
                                     const std::string& folder) {
  std::vector<Part> parts(shards.size());
  for (std::size_t i = 0; i < shards.size(); ++i) {
    if (auto good = read_part(shards[i], parts[i]); !good) return tl::unexpected(good.error());
    if (auto good = check_same_study(parts[0], parts[i]); !good)
      return tl::unexpected(good.error());
  }
  if (auto good = check_complete(parts); !good) return tl::unexpected(good.error());
  std::sort(parts.begin(), parts.end(),
            [](const Part& a, const Part& b) { return a.number < b.number; });

  SweepTable table;
  const auto there = table.open_file(folder);
  if (!there) return tl::unexpected(there.error());
  if (*there)
    return fail(fmt::format("there is a table in '{}' already", folder), "",
                "give another folder with -o");
  const auto fill = [&]() -> Result<> {
    const std::string& first = parts.front().path;
    const auto pattern = open_part(first);
    if (!pattern) return tl::unexpected(pattern.error());
    if (auto good =
            table.execute("BEGIN; CREATE TABLE study (key TEXT PRIMARY KEY, value TEXT);"
                          "CREATE TABLE columns (name TEXT PRIMARY KEY, kind TEXT, unit TEXT)");
        !good)
      return good;
    // As they were made: "runs" has a column for each parameter.
    for (const char* name : {"provenance", "runs"}) {
      Statement made(pattern->get(),
                     fmt::format("SELECT sql FROM sqlite_master WHERE name = '{}'", name));
      if (!made || !made.row()) return fail(fmt::format("'{}' is damaged", first));
      Statement make(table.db_, made.text(0));  // its first statement alone: a stranger wrote it
      make.row();
      if (!make || !make.done()) return fail(fmt::format("'{}' is damaged", first));
    }
    if (auto good = table.take_rows(pattern->get(), first, "study"); !good) return good;
    if (auto good = table.execute("DELETE FROM study WHERE key = 'shard'"); !good) return good;
    if (auto good = table.take_rows(pattern->get(), first, "columns"); !good) return good;
    for (const auto& row : rows_of(table.db_, "SELECT name, kind FROM columns ORDER BY rowid")) {
      if (row[1] == "parameter")
        table.parameters_.push_back(row[0]);
      else
        table.measures_.insert(row[0]);
    }
    for (const Part& part : parts) {
      const auto database = open_part(part.path);
      if (!database) return tl::unexpected(database.error());
      if (auto good = table.fill_from(database->get(), part.path); !good) return good;
    }
    return table.execute("COMMIT");
  };
  if (auto good = fill(); !good) {
    sqlite3_close(std::exchange(table.db_, nullptr));
    std::error_code ignored;
    fs::remove(table.path_, ignored);
    return tl::unexpected(good.error());
  }
  return table;
}

}  // namespace cogrsim::cli
