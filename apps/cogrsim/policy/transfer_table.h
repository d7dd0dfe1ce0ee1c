// The runs of `cogrsim transfer`, counted: how many stand on which engine, and how well they walk.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "compare/compare_output.h"
#include "sweep/sweep_plan.h"

namespace cogrsim::cli {

/// A share of counted runs and the interval in which it lies with a confidence of 95 %
/// (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927).
struct Share {
  std::size_t good = 0, of = 0;
  double low() const { return bound(-1.0); }
  double high() const { return bound(1.0); }
  double part() const { return of == 0 ? 0.0 : double(good) / double(of); }

 private:
  double bound(double side) const;
};

/// The runs of one engine with one command, and one value of whatever else is varied.
struct TransferRow {
  std::string backend;
  std::vector<std::string> values;  ///< by variation
  Share stood;                      ///< of the runs that were made
  std::size_t planned = 0;
  std::map<std::string, Estimate> measures;  ///< by PolicyMeasure; of the runs that have it
  std::vector<double> falls;                 ///< or diverges, times [s]; those that stand have none
};

struct TransferTable {
  std::vector<TransferRow> rows;      ///< in the order of the plan
  std::vector<std::string> failures;  ///< runs that did not come to an end of their own, and why
};

/// Reads the table of a study of a policy. Errors: it cannot be read.
Result<TransferTable> read_transfer(const SweepPlan& plan);

/// What the numbers are about, a sentence each.
std::vector<std::string> about_transfer(const SweepPlan& plan, const std::string& left_out);
/// Cells for a person, the first row the head; numbers as the format has them.
std::vector<std::vector<std::string>> transfer_cells(const SweepPlan& plan,
                                                     const TransferTable& table,
                                                     TableFormat format = TableFormat::markdown);
Json transfer_json(const SweepPlan& plan, const TransferTable& table, const std::string& left_out);
/// `pictures`: what is shown of the runs, as HTML.
std::string transfer_html(const SweepPlan& plan, const TransferTable& table,
                          const std::string& left_out, const std::string& pictures);

}  // namespace cogrsim::cli
