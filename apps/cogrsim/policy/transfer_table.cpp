#include "policy/transfer_table.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/terminal.h"
#include "policy/policy_case.h"
#include "sweep/result_table.h"
#include "sweep/sweep_table.h"

namespace cogrsim::cli {
namespace {

// The 97.5 % quantile of the normal distribution.
constexpr double kNormal = 1.959963984540054;

// Of ResultTable, by name.
struct Columns {
  explicit Columns(const ResultTable& t) {
    for (std::size_t c = 0; c < t.columns.size(); ++c) at[t.columns[c].name] = c;
  }
  const ResultTable::Cell* cell(const std::vector<ResultTable::Cell>& row,
                                const std::string& name) const {
    const auto found = at.find(name);
    return found == at.end() ? nullptr : &row[found->second];
  }
  std::map<std::string, std::size_t> at;
};

}  // namespace

double Share::bound(double side) const {
  if (of == 0) return side < 0.0 ? 0.0 : 1.0;
  if (side < 0.0 ? good == 0 : good == of)
    return side < 0.0 ? 0.0 : 1.0;  // exactly, not by rounding
  const double n = double(of), p = part(), z2 = kNormal * kNormal;
  const double middle = p + z2 / (2.0 * n);
  const double half = kNormal * std::sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n));
  return (middle + side * half) / (1.0 + z2 / n);
}

Result<TransferTable> read_transfer(const SweepPlan& plan) {
  const auto read = read_result_table(plan.options.output);
  if (!read) return tl::unexpected(read.error());
  const Columns columns(*read);
  std::map<std::string, const std::vector<ResultTable::Cell>*> by_key;
  for (const auto& row : read->rows)
    if (const auto* key = columns.cell(row, "case")) by_key[key->text] = &row;
  TransferTable out;
  std::map<std::pair<std::vector<std::size_t>, std::string>, std::size_t> groups;
  std::vector<std::map<std::string, std::vector<double>>> numbers;
  for (const SweepCase& one : plan.cases) {
    const auto [group, is_new] =
        groups.emplace(std::pair(one.values, one.backend), out.rows.size());
    if (is_new) {
      TransferRow& row = out.rows.emplace_back();
      row.backend = one.backend;
      for (std::size_t v = 0; v < one.values.size(); ++v)
        row.values.push_back(plan.options.variations[v].values[one.values[v]].text);
      numbers.emplace_back();
    }
    TransferRow& row = out.rows[group->second];
    ++row.planned;
    const auto found = by_key.find(plan.key(one));
    if (found == by_key.end()) continue;
    const auto& cells = *found->second;
    const std::string status = columns.cell(cells, "status")->text,
                      cause = columns.cell(cells, "cause")->text;
    if (status != "completed")
      out.failures.push_back(fmt::format("{}: {}{}", one_line(plan.title(one)), status,
                                         cause.empty() ? "" : ": " + one_line(cause)));
    const ResultTable::Cell* stood = columns.cell(cells, "stood");
    if (stood == nullptr || !std::isfinite(stood->number)) continue;
    ++row.stood.of;
    if (stood->number > 0.5)
      ++row.stood.good;
    else if (const auto* upright = columns.cell(cells, "upright"))
      row.falls.push_back(upright->number);
    for (const PolicyMeasure& measure : kPolicyMeasures) {
      const ResultTable::Cell* cell = columns.cell(cells, measure.name);
      if (cell != nullptr && std::isfinite(cell->number))
        numbers[group->second][measure.name].push_back(cell->number);
    }
  }
  for (std::size_t i = 0; i < out.rows.size(); ++i) {
    for (const PolicyMeasure& measure : kPolicyMeasures)
      out.rows[i].measures[measure.name] = estimate_of(numbers[i][measure.name]);
  }
  return out;
}

}  // namespace cogrsim::cli
