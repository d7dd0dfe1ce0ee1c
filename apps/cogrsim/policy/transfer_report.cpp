// The table of `cogrsim transfer` for people and for programs.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "common/terminal.h"
#include "compare/zoom_chart.h"
#include "policy/policy_case.h"
#include "policy/transfer_table.h"

namespace cogrsim::cli {
namespace {

struct ShownMeasure {
  const char *name, *head;
  double unit = 1.0;
};
constexpr ShownMeasure kShown[] = {
    {"fell_at", "falls at [s]"},
    {"velocity_error", "velocity error [m/s]"},
    {"turning_error", "turning error [rad/s]"},
    {"slip", "slip [m/s]"},
    {"mean_force", "mean force [N]"},
    {"peak_force", "peak force [N]"},
    {"at_limit", "at limit [%]", 0.01},
    {"cost_of_transport", "cost of transport"},
};

// "1..20", or a list.
std::string seeds_text(const std::vector<std::uint64_t>& seeds) {
  if (seeds.size() > 2 && std::is_sorted(seeds.begin(), seeds.end()) &&
      seeds.back() - seeds.front() + 1 == seeds.size())
    return fmt::format("{}..{}", seeds.front(), seeds.back());
  return fmt::format("{}", fmt::join(seeds, ","));
}

std::string share_text(const Share& share) {
  return share.of == 0 ? "–"
                       : fmt::format("{:.0f} to {:.0f}", 100.0 * share.low(), 100.0 * share.high());
}

// How many still stand, over time.
std::string standing_chart(const SweepPlan& plan, const TransferTable& table) {
  constexpr int kPoints = 200;
  Chart chart;
  chart.id = "standing";
  chart.title = "Robots that stand";
  chart.note = "share of all runs of an engine, over all commands";
  for (int i = 0; i <= kPoints; ++i)
    chart.times.push_back(*plan.options.scene.duration * i / kPoints);
  for (const std::string& backend : plan.options.backends) {
    if (chart.curves.size() == std::size_t(kChartColours)) break;
    std::vector<double> falls;
    std::size_t runs = 0;
    for (const TransferRow& row : table.rows) {
      if (row.backend != backend) continue;
      runs += row.stood.of;
      falls.insert(falls.end(), row.falls.begin(), row.falls.end());
    }
    if (runs == 0) continue;
    Curve curve;
    curve.name = backend;
    for (const double t : chart.times)
      curve.y.push_back(1.0 - double(std::count_if(falls.begin(), falls.end(),
                                                   [&](double at) { return at <= t; })) /
                                  double(runs));
    chart.curves.push_back(std::move(curve));
  }
  return chart.curves.empty() ? "" : chart_html(chart);
}

}  // namespace

std::vector<std::string> about_transfer(const SweepPlan& plan, const std::string& left_out) {
  std::vector<std::string> out;
  out.push_back(fmt::format("{} for {} with the seeds {}", one_line(plan.options.scene.scene),
                            time_text(*plan.options.scene.duration),
                            seeds_text(plan.options.seeds)));
  out.push_back(
      "a seed draws the start: joints within ±0.02 rad of their pose, a velocity within ±0.1 m/s "
      "forward and to the left, 1 cm above the scene's start; and the noise of the observations");
  out.push_back(
      "stands: has not fallen, as the card defines it; in brackets the interval of 95 % (Wilson)");
  out.push_back(
      "other numbers: mean of the runs that have it ± half of its interval of 95 % (Student); –: "
      "not "
      "measured, as the robot fell before 2 s or the engine does not report it");
  out.push_back(
      "errors: of the mean velocity from 2 s on; slip: mean speed along the ground of what "
      "touches it, by load; forces: of the ground on the robot; cost of transport: positive power "
      "of the motors over weight times speed");
  if (!left_out.empty()) out.push_back("left out: " + left_out);
  return out;
}

std::vector<std::vector<std::string>> transfer_cells(const SweepPlan& plan,
                                                     const TransferTable& table,
                                                     TableFormat format) {
  std::vector<std::vector<std::string>> out(1);
  for (const auto& variation : plan.options.variations) out[0].push_back(one_line(variation.param));
  for (const char* head : {"backend", "stands", "[%]"}) out[0].emplace_back(head);
  for (const ShownMeasure& shown : kShown) out[0].emplace_back(shown.head);
  for (const TransferRow& row : table.rows) {
    std::vector<std::string>& cells = out.emplace_back();
    for (const std::string& value : row.values) cells.push_back(one_line(value));
    cells.push_back(one_line(row.backend));
    cells.push_back(fmt::format("{} of {}", row.stood.good, row.stood.of));
    cells.push_back(share_text(row.stood));
    for (const ShownMeasure& shown : kShown)
      cells.push_back(estimate_text(row.measures.at(shown.name), shown.unit, format));
  }
  return out;
}

Json transfer_json(const SweepPlan& plan, const TransferTable& table, const std::string& left_out) {
  Json rows = Json::array();
  for (const TransferRow& row : table.rows) {
    Json settings = Json::object(), measures = Json::object();
    for (std::size_t v = 0; v < row.values.size(); ++v)
      settings[plan.options.variations[v].param] = row.values[v];
    for (const PolicyMeasure& measure : kPolicyMeasures) {
      const Estimate& e = row.measures.at(measure.name);
      if (measure.name == std::string("stood")) continue;
      measures[measure.name] = {{"unit", measure.unit},
                                {"runs", e.count},
                                {"mean", e.count > 0 ? Json(e.mean) : Json(nullptr)},
                                {"half_width", e.half_width ? Json(*e.half_width) : Json(nullptr)}};
    }
    rows.push_back({{"settings", settings},
                    {"backend", row.backend},
                    {"planned", row.planned},
                    {"runs", row.stood.of},
                    {"stood", row.stood.good},
                    {"share", {{"low", row.stood.low()}, {"high", row.stood.high()}}},
                    {"measures", measures}});
  }
  return {{"card", plan.options.scene.scene},
          {"duration", *plan.options.scene.duration},
          {"seeds", plan.options.seeds},
          {"backends", plan.options.backends},
          {"about", about_transfer(plan, left_out)},
          {"rows", rows},
          {"failures", table.failures}};
}

std::string transfer_html(const SweepPlan& plan, const TransferTable& table,
                          const std::string& left_out, const std::string& pictures) {
  const std::string name =
      one_line(std::filesystem::path(plan.options.scene.scene).filename().string());
  std::string out = page_start(name + " on other engines");
  out += fmt::format("<h1>{}</h1>\n", html_escaped(name));
  for (const std::string& line : about_transfer(plan, left_out))
    out += fmt::format("<p class=\"soft\">{}</p>\n", html_escaped(line));
  if (!table.failures.empty()) {
    out += "<h2>Runs without a result</h2>\n<ul class=\"plain\">\n";
    for (const std::string& line : table.failures)
      out += fmt::format("<li class=\"bad\">{}</li>\n", html_escaped(line));
    out += "</ul>\n";
  }
  out += "<h2>Who stands</h2>\n<div class=\"scroll\"><table>";
  const auto cells = transfer_cells(plan, table);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool all = i > 0 && table.rows[i - 1].stood.of > 0 &&
                     table.rows[i - 1].stood.good == table.rows[i - 1].stood.of;
    const std::size_t stands = cells[i].size() - std::size(kShown) - 2;
    out += i == 0 ? "<thead><tr>" : "<tr>";
    for (std::size_t c = 0; c < cells[i].size(); ++c)
      out += i == 0 ? fmt::format("<th>{}</th>", html_escaped(cells[i][c]))
                    : fmt::format("<td{}>{}</td>",
                                  c != stands ? ""
                                  : all       ? " class=\"good\""
                                              : " class=\"bad\"",
                                  html_escaped(cells[i][c]));
    out += i == 0 ? "</tr></thead><tbody>\n" : "</tr>\n";
  }
  out += "</tbody></table></div>\n" + standing_chart(plan, table) + pictures;
  return out + page_end();
}

}  // namespace cogrsim::cli
