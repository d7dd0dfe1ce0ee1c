// The table of a study: DIR/results.sqlite, and results.csv made from it.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "sweep/sweep_plan.h"

struct sqlite3;

namespace cogrsim::cli {

inline constexpr const char* kTableName = "results.sqlite";
inline constexpr const char* kCsvName = "results.csv";

/// One program at a time writes it; every finished run is one transaction, so that a process killed
/// at any time leaves whole rows and nothing else.
class SweepTable {
 public:
  /// Makes the folder and the table, or continues the one that is there. Errors: another study's
  /// table, with what is different; runs in it that are not in the plan; one that another program
  /// is writing; a folder or file that cannot be written.
  static Result<SweepTable> open(const SweepPlan& plan);
  /// The runs in an existing table, without making one; for `--dry-run`. Errors: as open().
  static Result<std::set<std::string>> peek(const SweepPlan& plan);
  /// The table of a study of the tables of its shards (folders or files), in a folder that has none.
  /// Errors: a shard that is missing, incomplete, given twice, or of another study; as open().
  static Result<SweepTable> merge(const std::vector<std::string>& shards,
                                  const std::string& folder);
  ~SweepTable();
  SweepTable(SweepTable&& other) noexcept;
  SweepTable& operator=(SweepTable&&) = delete;

  /// Keys of the runs that have a row.
  const std::set<std::string>& done() const { return done_; }
  /// Forgets the runs that did not come to an end of their own; returns how many.
  Result<int> forget_failed();

  Result<> add(const SweepPlan& plan, const SweepCase& one, const Json& result);

  struct Counts {
    int good = 0, failed = 0;
  };
  Counts counts() const;
  /// What each backend left out of its runs, a line each; empty: nothing.
  std::string left_out_text() const;

  /// results.csv: sorted by parameters, seed and backend; wall times in the last column.
  Result<> write_csv() const;

 private:
  SweepTable() = default;
  /// Makes the folder and opens the file; true: it was there.
  Result<bool> open_file(const std::string& folder);
  Result<> write_shard(const SweepPlan& plan);
  Result<> fill_from(sqlite3* from, const std::string& source);
  Result<> take_rows(sqlite3* from, const std::string& source, const std::string& table);
  Result<> prepare(const SweepPlan& plan);
  Result<> read_existing(const SweepPlan& plan);
  Result<> create(const SweepPlan& plan);
  /// The provenance of the runs of a backend; options and stages as JSON, what was left out as text.
  Result<> add_provenance(const SweepCase& one, const Json& provenance);
  Result<> add_measure_column(const std::string& name, const std::string& unit);
  Result<> execute(const std::string& sql);

  std::string folder_, path_;
  int lock_ = -1;
  sqlite3* db_ = nullptr;
  std::set<std::string> done_, measures_;
  std::vector<std::string> parameters_;
};

/// A whole number of an object that a stranger may have written; 0: it is not there.
std::size_t whole_number(const Json& object, const char* key);

/// The name of a column: a parameter or measure that is called as a column of the table's own gets
/// "parameter." or "measure." before it.
std::string parameter_column(const std::string& name);
std::string measure_column(const std::string& name);

}  // namespace cogrsim::cli
