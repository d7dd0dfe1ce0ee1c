#include "sweep/sweep_table.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "cogrsim/core/shown_text.h"
#include "common/output_file.h"
#include "render/plots.h"
#include "sweep/sqlite_statement.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kTableVersion = 1;

const std::vector<std::string>& own_columns() {
  static const std::vector<std::string> kOwn = {"case",  "seed",     "backend",   "status",
                                                "cause", "end_time", "wall_time", "state_hash"};
  return kOwn;
}

// SQLite does not distinguish A from a in names.
bool is_own(const std::string& name) {
  return std::any_of(own_columns().begin(), own_columns().end(), [&](const std::string& own) {
    return sqlite3_stricmp(own.c_str(), name.c_str()) == 0;
  });
}

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    out += c;
    if (c == '"') out += c;
  }
  return out + "\"";
}

std::string cell_of(const Statement& row, int column) {
  switch (row.type(column)) {
    case SQLITE_NULL:
      return {};
    case SQLITE_FLOAT: {
      const double value = row.number(column);
      return std::isinf(value) ? (value > 0 ? "inf" : "-inf") : fmt::format("{}", value);
    }
    default:
      return csv_cell(row.text(column));
  }
}

double number_from(const Json& value) {
  if (value.is_number()) return value.get<double>();
  if (value == "inf") return std::numeric_limits<double>::infinity();
  if (value == "-inf") return -std::numeric_limits<double>::infinity();
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::size_t whole_number(const Json& object, const char* key) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_number_unsigned()) return 0;
  return object[key].get<std::size_t>();
}

std::string parameter_column(const std::string& name) {
  return is_own(name) ? "parameter." + name : name;
}
std::string measure_column(const std::string& name) {
  return is_own(name) ? "measure." + name : name;
}

SweepTable::SweepTable(SweepTable&& other) noexcept
    : folder_(std::move(other.folder_)),
      path_(std::move(other.path_)),
      lock_(std::exchange(other.lock_, -1)),
      db_(std::exchange(other.db_, nullptr)),
      done_(std::move(other.done_)),
      measures_(std::move(other.measures_)),
      parameters_(std::move(other.parameters_)) {}

SweepTable::~SweepTable() {
  sqlite3_close(db_);
  if (lock_ >= 0) close(lock_);
}

Result<> SweepTable::execute(const std::string& sql) {
  char* message = nullptr;
  if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, &message) == SQLITE_OK) return {};
  const std::string why = message == nullptr ? "unknown" : message;
  sqlite3_free(message);
  return fail(fmt::format("'{}': {}", path_, why), "",
              "is the disk full, or the file not a study's table?");
}

Result<bool> SweepTable::open_file(const std::string& folder) {
  folder_ = folder;
  path_ = (fs::path(folder_) / kTableName).string();
  if (const auto made = make_folder(folder_); !made) return tl::unexpected(made.error());
  lock_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0 || flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    return fail(fmt::format("another sweep is writing to '{}'", folder_), "",
                "wait for it, or give another folder with -o");
  }
  for (const char* name : {kTableName, kCsvName}) {
    const std::string path = (fs::path(folder_) / name).string();
    const OutputKind kind = name == kCsvName ? OutputKind::csv : OutputKind::study;
    if (auto allowed = check_writable(path, kind); !allowed) return tl::unexpected(allowed.error());
  }
  const bool there = fs::exists(path_);
  const auto opened = open_database(path_, true);
  if (!opened) return tl::unexpected(opened.error());
  db_ = *opened;
  // A database of something else is left as it is.
  if (there) {
    Statement foreign(db_,
                      "SELECT (SELECT count(*) FROM sqlite_master) > 0 AND NOT EXISTS "
                      "(SELECT 1 FROM sqlite_master WHERE name = 'study')");
    if (!foreign || !foreign.row() || foreign.integer(0) != 0) {
      return fail(fmt::format("'{}' is not a table of a study", path_), "",
                  "choose another folder with -o");
    }
  }
  // Written ahead: readers never wait for the writer, nor it for them.
  if (auto good = execute("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL"); !good) {
    return tl::unexpected(good.error());
  }
  return there;
}

Result<SweepTable> SweepTable::open(const SweepPlan& plan) {
  SweepTable table;
  const auto there = table.open_file(plan.options.output);
  if (!there) return tl::unexpected(there.error());
  Result<> good = table.prepare(plan);
  if (good) good = table.write_shard(plan);
  if (!good) {
    if (!*there) {
      sqlite3_close(std::exchange(table.db_, nullptr));
      std::error_code ignored;
      fs::remove(table.path_, ignored);
    }
    return tl::unexpected(good.error());
  }
  return table;
}

Result<std::set<std::string>> SweepTable::peek(const SweepPlan& plan) {
  SweepTable table;
  table.folder_ = plan.options.output;
  table.path_ = (fs::path(table.folder_) / kTableName).string();
  if (!fs::exists(table.path_)) return std::set<std::string>();
  const auto opened = open_database(table.path_, false);
  if (!opened) return tl::unexpected(opened.error());
  table.db_ = *opened;
  if (auto good = table.read_existing(plan); !good) return tl::unexpected(good.error());
  return table.done_;
}

Result<> SweepTable::prepare(const SweepPlan& plan) {
  Statement tables(db_, "SELECT name FROM sqlite_master WHERE name = 'study'");
  if (!tables) return fail(fmt::format("'{}': {}", path_, tables.error()));
  if (auto good = execute("CREATE TABLE IF NOT EXISTS provenance (backend TEXT PRIMARY KEY, "
                          "engine TEXT, version TEXT, solver TEXT, formulation TEXT, integrator "
                          "TEXT, cogrsim_version TEXT, options TEXT, stages TEXT, left_out TEXT)");
      !good) {
    return good;
  }
  if (!Statement(db_, "SELECT left_out FROM provenance"))  // an older table
    if (auto good = execute("ALTER TABLE provenance ADD COLUMN left_out TEXT"); !good) return good;
  return tables.row() ? read_existing(plan) : create(plan);
}

Result<> SweepTable::create(const SweepPlan& plan) {
  std::string columns = "\"case\" TEXT PRIMARY KEY";
  std::string rows;
  std::set<std::string> names;
  const auto take = [&](const std::string& column) -> Result<> {
    std::string low = column;
    for (char& c : low) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c);
    if (names.insert(low).second) return {};
    return fail(fmt::format("two columns of the table would be called '{}'", column), "",
                "give the measure another name");
  };
  for (const auto& variation : plan.options.variations) {
    const std::string column = parameter_column(variation.param);
    if (auto good = take(column); !good) return good;
    columns += ", " + quoted(column);
  }
  columns +=
      ", seed, backend TEXT, status TEXT, cause TEXT, end_time REAL, state_hash TEXT, "
      "wall_time REAL";
  std::vector<std::string> measures = plan.scene_measures;
  for (const auto& measure : plan.options.measures) measures.push_back(measure.name);
  for (const std::string& measure : measures) {
    const std::string column = measure_column(measure);
    if (auto good = take(column); !good) return good;
    columns += ", " + quoted(column) + " REAL";
  }
  if (auto good = execute("BEGIN; CREATE TABLE study (key TEXT PRIMARY KEY, value TEXT);"
                          "CREATE TABLE columns (name TEXT PRIMARY KEY, kind TEXT, unit TEXT);"
                          "CREATE TABLE runs (" +
                          columns + ")");
      !good) {
    return good;
  }
  const auto insert = [&](const char* sql, std::initializer_list<std::string> values) -> Result<> {
    Statement statement(db_, sql);
    int index = 0;
    for (const std::string& value : values) statement.bind(++index, value);
    statement.row();
    if (!statement.done()) return fail(fmt::format("'{}': {}", path_, statement.error()));
    return {};
  };
  constexpr const char* kStudy = "INSERT INTO study VALUES (?, ?)";
  if (auto good = insert(kStudy, {"version", std::to_string(kTableVersion)}); !good) return good;
  if (auto good = insert(kStudy, {"definition", plan.definition().dump()}); !good) return good;
  constexpr const char* kColumn = "INSERT INTO columns VALUES (?, ?, ?)";
  for (const auto& variation : plan.options.variations) {
    parameters_.push_back(parameter_column(variation.param));
    if (auto good =
            insert(kColumn, {parameters_.back(), "parameter", variation.values.front().unit});
        !good) {
      return good;
    }
  }
  for (const std::string& measure : measures) {
    measures_.insert(measure_column(measure));
    if (auto good = insert(kColumn, {measure_column(measure), "measure", ""}); !good) return good;
  }
  return execute("COMMIT");
}

// After the table is known to be of this study: a study may have grown.
Result<> SweepTable::write_shard(const SweepPlan& plan) {
  if (plan.options.shard.of == 0) return {};
  Statement insert(db_, "INSERT OR REPLACE INTO study VALUES ('shard', ?)");
  const Json shard = {{"number", plan.options.shard.number},
                      {"of", plan.options.shard.of},
                      {"cases", plan.cases.size()},
                      {"hash", fmt::format("{:016x}", plan.cases_hash)}};
  insert.bind(1, shard.dump());
  insert.row();
  if (!insert.done()) return fail(fmt::format("'{}': {}", path_, insert.error()));
  return {};
}

Result<> SweepTable::read_existing(const SweepPlan& plan) {
  Statement study(db_, "SELECT key, value FROM study");
  if (!study) return fail(fmt::format("'{}' is not a table of a study: {}", path_, study.error()));
  int version = 0;
  Json definition;
  Shard shard;
  while (study.row()) {
    if (study.text(0) == "shard") {
      const Json read = Json::parse(study.text(1), nullptr, false);
      shard = {whole_number(read, "number"), whole_number(read, "of")};
    }
    if (study.text(0) == "version") version = std::atoi(study.text(1).c_str());
    if (study.text(0) == "definition") definition = Json::parse(study.text(1), nullptr, false);
  }
  if (version > kTableVersion) {
    return fail(fmt::format("'{}' was written by a newer version of cogrsim", path_));
  }
  if (!definition.is_object()) return fail(fmt::format("'{}' is damaged", path_));
  const std::vector<std::string> differences =
      definition_differences(definition, plan.definition());
  if (!differences.empty()) {
    return fail(fmt::format("'{}' is of another study: {}", path_, fmt::join(differences, "; ")),
                "", "give another folder with -o, or the parameters of that study");
  }
  if (shard.number != plan.options.shard.number || shard.of != plan.options.shard.of) {
    return fail(
        fmt::format("'{}' is {}, and not {}", path_, shard.text(), plan.options.shard.text()), "",
        "give each shard a folder of its own with -o");
  }
  Statement columns(db_, "SELECT name, kind FROM columns ORDER BY rowid");
  while (columns && columns.row()) {
    if (columns.text(1) == "parameter") {
      parameters_.push_back(columns.text(0));
    } else {
      measures_.insert(columns.text(0));
    }
  }
  Statement runs(db_, "SELECT \"case\" FROM runs");
  while (runs && runs.row()) done_.insert(runs.text(0));
  if (!runs || !runs.done()) return fail(fmt::format("'{}': {}", path_, runs.error()));
  std::set<std::string> planned;
  for (const SweepCase& one : plan.cases) planned.insert(plan.key(one));
  std::size_t strange = 0;
  std::string first;
  for (const std::string& key : done_) {
    if (planned.count(key) > 0) continue;
    if (strange++ == 0) first = key;
  }
  if (strange > 0) {
    return fail(fmt::format("'{}' has {} runs that this study does not have, such as {}", path_,
                            strange, first),
                "", "a study may grow; for a smaller one give another folder with -o");
  }
  return {};
}

Result<int> SweepTable::forget_failed() {
  if (auto good = execute("DELETE FROM runs WHERE status IN ('crashed', 'timeout', 'memory', "
                          "'failed')");
      !good) {
    return tl::unexpected(good.error());
  }
  const int forgotten = sqlite3_changes(db_);
  done_.clear();
  Statement runs(db_, "SELECT \"case\" FROM runs");
  while (runs && runs.row()) done_.insert(runs.text(0));
  return forgotten;
}

Result<> SweepTable::add_measure_column(const std::string& name, const std::string& unit) {
  // Its unit is known with the first run that has it.
  if (measures_.count(name) == 0) {
    if (auto good = execute("ALTER TABLE runs ADD COLUMN " + quoted(name) + " REAL"); !good) {
      return good;
    }
    measures_.insert(name);
  }
  Statement column(db_,
                   "INSERT INTO columns VALUES (?1, 'measure', ?2) ON CONFLICT(name) DO UPDATE SET "
                   "unit = ?2 WHERE unit = ''");
  column.bind(1, name);
  column.bind(2, unit);
  column.row();
  if (!column.done()) return fail(fmt::format("'{}': {}", path_, column.error()));
  return {};
}

Result<> SweepTable::add_provenance(const SweepCase& one, const Json& provenance) {
  Statement insert(db_, "INSERT OR REPLACE INTO provenance VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!insert) return fail(fmt::format("'{}': {}", path_, insert.error()));
  const auto text = [&](const char* key) { return provenance.at(key).get<std::string>(); };
  int i = 0;
  insert.bind(++i, one.backend);
  for (const char* key :
       {"engine", "version", "solver", "formulation", "integrator", "cogrsim_version"}) {
    insert.bind(++i, text(key));
  }
  insert.bind(++i, provenance.at("options").dump());
  insert.bind(++i, provenance.at("stages").dump());
  const auto read = parse_provenance(provenance.dump());
  insert.bind(++i, read ? to_text(read->left_out) : std::string());
  insert.row();
  if (!insert.done()) return fail(fmt::format("'{}': {}", path_, insert.error()));
  return {};
}

Result<> SweepTable::add(const SweepPlan& plan, const SweepCase& one, const Json& result) {
  if (auto good = execute("BEGIN IMMEDIATE"); !good) return good;
  const auto undo = [&](const Error& error) -> Result<> {
    static_cast<void>(execute("ROLLBACK"));
    return tl::unexpected(error);
  };
  std::string names = "\"case\", seed, backend, status, cause, end_time, wall_time, state_hash";
  std::string values = "?, ?, ?, ?, ?, ?, ?, ?";
  const auto text = [&](const char* key) {
    return result.contains(key) && result[key].is_string() ? result[key].get<std::string>() : "";
  };
  for (const auto& variation : plan.options.variations) {
    names += ", " + quoted(parameter_column(variation.param));
    values += ", ?";
  }
  for (const auto& [name, value] : result["measures"].items()) {
    static_cast<void>(value);
    const std::string column = measure_column(name);
    std::string unit;
    if (result.contains("units") && result["units"].contains(name)) {
      unit = result["units"][name].get<std::string>();
    }
    if (auto good = add_measure_column(column, unit); !good) return undo(good.error());
    names += ", " + quoted(column);
    values += ", ?";
  }
  {
    Statement insert(db_, "INSERT OR REPLACE INTO runs (" + names + ") VALUES (" + values + ")");
    if (!insert) return undo(Error(fmt::format("'{}': {}", path_, insert.error())));
    int i = 0;
    insert.bind(++i, plan.key(one));
    insert.bind(++i, one.seed);
    insert.bind(++i, one.backend);
    insert.bind(++i, text("status"));
    ++i;  // an empty cause is NULL
    if (!text("cause").empty()) insert.bind(i, text("cause"));
    for (const char* key : {"end_time", "wall_time"}) {
      insert.bind(++i, result.contains(key) ? number_from(result[key]) : std::nan(""));
    }
    ++i;
    if (!text("state_hash").empty()) insert.bind(i, text("state_hash"));
    for (std::size_t v = 0; v < plan.options.variations.size(); ++v) {
      const dsl::StudyValue& value = plan.options.variations[v].values[one.values[v]];
      if (std::isnan(value.number)) {
        insert.bind(++i, value.text);
      } else {
        insert.bind(++i, value.number);
      }
    }
    for (const auto& entry : result["measures"].items())
      insert.bind(++i, number_from(entry.value()));
    insert.row();
    if (!insert.done()) return undo(Error(fmt::format("'{}': {}", path_, insert.error())));
  }
  if (result.contains("provenance")) {
    if (auto good = add_provenance(one, result["provenance"]); !good) return undo(good.error());
  }
  if (auto good = execute("COMMIT"); !good) return undo(good.error());
  done_.insert(plan.key(one));
  return {};
}

std::string SweepTable::left_out_text() const {
  std::string out;
  Statement rows(db_, "SELECT backend, left_out FROM provenance WHERE left_out <> '' ORDER BY 1");
  while (rows && rows.row())
    out += fmt::format("  {} without {}\n", one_line(rows.text(0)), one_line(rows.text(1)));
  return out;
}

SweepTable::Counts SweepTable::counts() const {
  Counts counts;
  Statement rows(db_, "SELECT status IN ('completed', 'stopped'), count(*) FROM runs GROUP BY 1");
  while (rows && rows.row()) {
    (rows.integer(0) != 0 ? counts.good : counts.failed) = static_cast<int>(rows.integer(1));
  }
  return counts;
}

Result<> SweepTable::write_csv() const {
  std::string order, columns;
  for (const std::string& parameter : parameters_) {
    order += quoted(parameter) + ", ";
    columns += quoted(parameter) + ", ";
  }
  columns += "seed, backend, status, cause, end_time, ";
  for (const std::string& measure : measures_) columns += quoted(measure) + ", ";
  Statement rows(db_, "SELECT " + columns + "state_hash, wall_time FROM runs ORDER BY " + order +
                          "seed, backend");
  if (!rows) return fail(fmt::format("'{}': {}", path_, rows.error()));
  std::string csv;
  for (int c = 0; c < rows.columns(); ++c) csv += (c ? "," : "") + csv_cell(rows.column_name(c));
  csv += "\n";
  while (rows.row()) {
    for (int c = 0; c < rows.columns(); ++c) csv += (c ? "," : "") + cell_of(rows, c);
    csv += "\n";
  }
  if (!rows.done()) return fail(fmt::format("'{}': {}", path_, rows.error()));
  return write_output((fs::path(folder_) / kCsvName).string(), OutputKind::csv, csv);
}

}  // namespace cogrsim::cli
