#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "compare/compare_output.h"
#include "common/provenance_text.h"

namespace cogrsim::cli {
namespace {

constexpr std::size_t kNameWidth = 28;

std::string spread_cell(const std::optional<Spread>& spread, double Spread::*part, bool angle) {
  if (!spread) return "";
  return angle ? angle_text((*spread).*part) : length_text((*spread).*part);
}

std::string difference_table(const std::string& kind, const char* distance,
                             const std::vector<Difference>& differences,
                             const CompareReport& report, int rows, const Style& style) {
  if (differences.empty()) return {};
  const CompareResult& comparison = report.result->comparison;
  const bool several = comparison.runs.size() > 2;
  const auto any = [&](std::optional<Spread> Difference::*part) {
    return std::any_of(differences.begin(), differences.end(),
                       [&](const Difference& d) { return (d.*part).has_value(); });
  };
  const bool distances = any(&Difference::distance), angles = any(&Difference::angle);
  std::vector<TextTable::Align> columns = {TextTable::Align::left};
  std::vector<std::string> head = {kind};
  const auto column = [&](TextTable::Align align, const std::string& title) {
    columns.push_back(align);
    head.push_back(title);
  };
  const auto columns_of = [&](const std::string& quantity) {
    column(TextTable::Align::right, quantity + " max");
    column(TextTable::Align::right, "rms");
    column(TextTable::Align::right, "at end");
  };
  if (several) column(TextTable::Align::left, "backend");
  if (distances) columns_of(distance);
  if (angles) columns_of("angle");
  column(TextTable::Align::right, "diverges at");
  TextTable table(columns);
  table.row(head);
  const std::size_t shown = std::min(differences.size(), static_cast<std::size_t>(rows));
  for (std::size_t i = 0; i < shown; ++i) {
    const Difference& d = differences[i];
    std::vector<std::string> row = {shortened(d.name, kNameWidth)};
    if (several) row.push_back(comparison.runs[d.run]);
    for (const auto part : {&Spread::max, &Spread::rms, &Spread::end}) {
      if (distances) row.push_back(spread_cell(d.distance, part, false));
    }
    for (const auto part : {&Spread::max, &Spread::rms, &Spread::end}) {
      if (angles) row.push_back(spread_cell(d.angle, part, true));
    }
    row.push_back(d.first_over ? style.red + time_text(*d.first_over) + style.off : "never");
    table.row(row);
  }
  std::string out = "\n" + table.text("  ", style.bold, style.off);
  if (shown < differences.size()) {
    out += fmt::format("  and {} more, see --json\n", differences.size() - shown);
  }
  return out;
}

std::string extreme_cell(const Extreme& extreme, bool angle) {
  if (extreme.where.empty()) return angle ? "0°" : "0 m";
  return angle ? angle_text(extreme.value) : length_text(extreme.value);
}

// Backends side by side: one column each, so that figures to compare stand beside each other.
std::string figures_table(const LockstepResult& result, const Style& style) {
  std::vector<TextTable::Align> columns = {TextTable::Align::left};
  std::vector<std::string> head = {""};
  for (const RunEnd& run : result.runs) {
    columns.push_back(TextTable::Align::right);
    head.push_back(run.label);
  }
  TextTable table(columns);
  table.row(head);
  const auto line = [&](const std::string& title, auto cell) {
    std::vector<std::string> row = {title};
    for (std::size_t i = 0; i < result.runs.size(); ++i) {
      row.push_back(cell(result.runs[i], result.comparison.figures[i]));
    }
    table.row(row);
  };
  using Run = const RunEnd&;
  using Figures = const RunFigures&;
  line("ended", [&](Run r, Figures) {
    const bool bad = r.status == RunStatus::diverged || r.status == RunStatus::fault;
    const std::string text = fmt::format("{}, {}", to_string(r.status), time_text(r.time));
    return bad ? style.red + text + style.off : text;
  });
  line("wall time", [](Run r, Figures) { return elapsed_text(r.wall_time); });
  line("times real time", [](Run r, Figures) { return factor_text(r.time / r.wall_time); });
  line("energy at start", [](Run, Figures f) { return quantity_text(f.energy.start, "J"); });
  line("energy at end", [](Run, Figures f) { return quantity_text(f.energy.end, "J"); });
  line("energy drift",
       [](Run, Figures f) { return quantity_text(f.energy.end - f.energy.start, "J"); });
  line("momentum drift, largest",
       [](Run, Figures f) { return quantity_text(f.linear_momentum.largest, "kg m/s"); });
  line("angular momentum drift",
       [](Run, Figures f) { return quantity_text(f.angular_momentum.largest, "kg m²/s"); });
  line("contacts, mean", [](Run, Figures f) { return quantity_text(f.mean_contacts, ""); });
  line("contacts, most", [](Run, Figures f) { return fmt::format("{}", f.most_contacts); });
  line("deepest penetration", [](Run, Figures f) { return extreme_cell(f.penetration, false); });
  line("joint error, distance",
       [](Run, Figures f) { return extreme_cell(f.joint_distance, false); });
  line("joint error, angle", [](Run, Figures f) { return extreme_cell(f.joint_angle, true); });
  return "\n" + table.text("  ", style.bold, style.off);
}

std::string convergence_table(const CompareReport& report, const Style& style) {
  if (report.convergence.empty()) return {};
  TextTable table({TextTable::Align::left, TextTable::Align::right, TextTable::Align::right,
                   TextTable::Align::right});
  table.row({"convergence", "step", "rms change", "order"});
  for (const ConvergenceSeries& series : report.convergence) {
    for (const ConvergencePoint& point : series.points) {
      // A backend's smallest step has nothing smaller to be compared with.
      if (!point.difference) continue;
      table.row({series.name, step_text(point.step), length_text(*point.difference),
                 point.order ? fmt::format("{:.2f}", *point.order) : "-"});
    }
  }
  return "\n" + table.text("  ", style.bold, style.off) +
         "  A backend's change is from its own run at the next smaller step; of two backends it "
         "is\n"
         "  the difference between them. Positions, root mean square over bodies and time.\n";
}

std::string estimate_cell(const Estimate& estimate, std::string (*text)(double)) {
  if (estimate.count == 0) return "-";
  const std::string mean = text(estimate.mean);
  return estimate.half_width ? mean + " ± " + text(*estimate.half_width) : mean;
}

std::string study_table(const CompareReport& report, int rows, const Style& style) {
  const CompareStudy& study = report.study;
  if (study.seeds.size() < 2) return {};
  TextTable table({TextTable::Align::left, TextTable::Align::left, TextTable::Align::right,
                   TextTable::Align::right, TextTable::Align::right, TextTable::Align::right,
                   TextTable::Align::right});
  table.row({fmt::format("{} repetitions", study.seeds.size()), "run", "position max", "at end",
             "σ at end", "diverges at", "diverged"});
  const std::size_t shown = std::min(study.rows.size(), static_cast<std::size_t>(rows));
  for (std::size_t i = 0; i < shown; ++i) {
    const StudyRow& row = study.rows[i];
    table.row({shortened(row.body, kNameWidth), row.run, estimate_cell(row.max, length_text),
               estimate_cell(row.end, length_text),
               row.end.deviation ? length_text(*row.end.deviation) : "-",
               estimate_cell(row.diverges_at, time_text),
               fmt::format("{} of {}", row.diverges_at.count, row.max.count)});
  }
  std::string out = "\n" + table.text("  ", style.bold, style.off);
  if (shown < study.rows.size()) {
    out += fmt::format("  and {} more, see --json\n", study.rows.size() - shown);
  }
  return out +
         "  Mean ± half of its 95 % confidence interval (Student's t); σ: standard deviation of "
         "one "
         "repetition.\n";
}

std::string chaos_line(const CompareReport& report, const Style& style) {
  const auto chaos = chaos_of(report);
  if (!chaos) return {};
  const CompareResult& comparison = report.result->comparison;
  const std::string begin = fmt::format("two runs of {} that begin {} apart",
                                        one_line(comparison.runs[0]), length_text(report.twin));
  if (!chaos->first_over) {
    return fmt::format("  {} stay within {}: larger differences come from the engines\n", begin,
                       length_text(chaos->largest));
  }
  return fmt::format(
      "  {}{} diverge by more than {} at {}: what comes later is chaos, not the engines{}\n",
      style.yellow, begin, thresholds_text(comparison.options), time_text(*chaos->first_over),
      style.off);
}

}  // namespace

std::optional<Chaos> chaos_of(const CompareReport& report) {
  if (!report.result || report.twin <= 0.0) return std::nullopt;
  const CompareResult& comparison = report.result->comparison;
  const std::size_t twin = comparison.runs.size() - 1;
  Chaos out;
  out.run = comparison.runs[twin];
  for (const Difference& difference : comparison.bodies) {
    if (difference.run != twin) continue;
    if (difference.distance) out.largest = std::max(out.largest, difference.distance->max);
    if (!difference.first_over) continue;
    out.first_over =
        std::min(out.first_over.value_or(*difference.first_over), *difference.first_over);
  }
  return out;
}

std::string thresholds_text(const CompareOptions& options) {
  const double metres = options.position_threshold;
  const bool metric = metres >= 1.0;
  const double degrees = options.angle_threshold * 180.0 / 3.14159265358979323846;
  return fmt::format("{:.4g} {} or {:.4g}°", metric ? metres : metres * 1e3, metric ? "m" : "mm",
                     degrees);
}

std::string compare_text(const CompareReport& report, int rows, const Style& style) {
  if (!report.result) return {};
  const LockstepResult& result = *report.result;
  const CompareResult& comparison = result.comparison;
  const std::size_t engines = comparison.runs.size() - comparison.options.twins;
  std::string others = comparison.runs[1];
  for (std::size_t i = 2; i < engines; ++i) others += ", " + comparison.runs[i];
  std::string out = fmt::format("{}{}{}: {} against {}, {} in steps of {}\n", style.bold,
                                report.scene, style.off, others, comparison.runs[0],
                                time_text(comparison.end_time), step_text(result.runs[0].step));
  if (!result.ended_early.empty()) {
    out += fmt::format("  {}compared only up to {}: {}{}\n", style.yellow,
                       time_text(comparison.end_time), result.ended_early, style.off);
  }
  const std::string limits = thresholds_text(comparison.options);
  if (comparison.first_over) {
    out += fmt::format("  {}diverged by more than {} at {}, first {}{}\n", style.red, limits,
                       time_text(*comparison.first_over), comparison.first_over_name, style.off);
  } else {
    out += fmt::format("  {}never diverged by more than {}{}\n", style.green, limits, style.off);
  }
  out += chaos_line(report, style);
  out += fmt::format("  seed {}", report.seed);
  if (report.study.shake > 0.0)
    out += fmt::format(", shaken by {}", length_text(report.study.shake));
  for (const auto& [name, value] : report.set) {
    out += fmt::format(", {}={}", one_line(name), one_line(value));
  }
  out += fmt::format(", CogRSim {}\n\n", result.runs.front().provenance.cogrsim_version);
  for (std::size_t i = 0; i < engines; ++i) {
    const RunEnd& run = result.runs[i];
    out += fmt::format("  {}{}{}\n", style.bold, one_line(run.label), style.off) +
           provenance_lines(run.provenance);
  }
  out += difference_table("body, worst first", "position", comparison.bodies, report, rows, style);
  out += difference_table("joint, worst first", "travel", comparison.joints, report, rows, style);
  if (!comparison.only_in_some.empty()) {
    out += fmt::format("\n  {}not in every run:{}", style.yellow, style.off);
    const std::size_t shown = std::min<std::size_t>(comparison.only_in_some.size(), 10);
    for (std::size_t i = 0; i < shown; ++i) out += " " + comparison.only_in_some[i];
    if (shown < comparison.only_in_some.size()) {
      out += fmt::format(" and {} more, see --json", comparison.only_in_some.size() - shown);
    }
    out += "\n";
  }
  return out + figures_table(result, style) + study_table(report, rows, style) +
         convergence_table(report, style);
}

}  // namespace cogrsim::cli
