// The differences of a comparison as a table for a paper.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "compare/compare_output.h"
#include "common/provenance_text.h"

namespace cogrsim::cli {

std::string table_escaped(const std::string& text, TableFormat format) {
  std::string out;
  for (const char c : one_line(text)) {
    if (format == TableFormat::markdown) {
      if (c == '|' || c == '\\' || c == '`' || c == '*' || c == '_' || c == '<') out += '\\';
      out += c;
      continue;
    }
    switch (c) {
      case '\\':
        out += "\\textbackslash{}";
        break;
      case '~':
        out += "\\textasciitilde{}";
        break;
      case '^':
        out += "\\textasciicircum{}";
        break;
      case '&':
      case '%':
      case '$':
      case '#':
      case '_':
      case '{':
      case '}':
        out += '\\';
        out += c;
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string estimate_text(const Estimate& estimate, double unit, TableFormat format) {
  if (estimate.count == 0) return format == TableFormat::latex ? "--" : "–";
  const double mean = estimate.mean / unit;
  if (!estimate.half_width) return fmt::format("{:.3g}", mean);
  const double half = *estimate.half_width / unit;
  int decimals = 2;
  if (half > 0.0) decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(half))), 0, 12);
  return format == TableFormat::latex
             ? fmt::format("${:.{}f} \\pm {:.{}f}$", mean, decimals, half, decimals)
             : fmt::format("{:.{}f} ± {:.{}f}", mean, decimals, half, decimals);
}

namespace {

std::vector<std::string> about(const CompareReport& report) {
  const LockstepResult& result = *report.result;
  const std::size_t engines = result.runs.size() - result.comparison.options.twins;
  std::vector<std::string> out;
  std::string seeds;
  for (const std::uint64_t seed : report.study.seeds) seeds += fmt::format(" {}", seed);
  std::string set;
  for (const auto& [name, value] : report.set) set += fmt::format(" --set {}={}", name, value);
  out.push_back(fmt::format("scene {} ({}), {} in steps of {}, seeds{}{}", report.scene,
                            report.file, time_text(result.comparison.end_time),
                            step_text(result.runs[0].step), seeds, set));
  if (report.study.shake > 0.0) {
    out.push_back(fmt::format("start shaken by {}", length_text(report.study.shake)));
  }
  for (std::size_t i = 0; i < engines; ++i) {
    const RunEnd& run = result.runs[i];
    const std::string options = options_text(run.provenance);
    const std::string left_out = to_text(run.provenance.left_out);
    out.push_back(fmt::format("{}: {}{}{}{}{}", run.label, summary_text(run.provenance),
                              options.empty() ? "" : ", ", options,
                              left_out.empty() ? "" : ", without ", left_out));
  }
  out.push_back("reference: " + result.runs[0].label);
  out.push_back("diverged: more than " + thresholds_text(result.comparison.options));
  if (report.study.seeds.size() > 1) {
    out.push_back("mean and half of its 95 % confidence interval (Student's t)");
  }
  out.push_back("CogRSim " + result.runs[0].provenance.cogrsim_version);
  return out;
}

}  // namespace

std::string compare_table(const CompareReport& report, TableFormat format, int rows) {
  std::vector<std::vector<std::string>> cells;
  cells.push_back(
      {"body", "run", "largest [mm]", "rms [mm]", "at end [mm]", "diverges at [s]",
       "diverged"});
  const CompareStudy& study = report.study;
  const std::size_t shown = std::min(study.rows.size(), static_cast<std::size_t>(rows));
  for (std::size_t i = 0; i < shown; ++i) {
    const StudyRow& row = study.rows[i];
    cells.push_back({table_escaped(row.body, format), table_escaped(row.run, format),
                     estimate_text(row.max, 1e-3, format), estimate_text(row.rms, 1e-3, format),
                     estimate_text(row.end, 1e-3, format),
                     estimate_text(row.diverges_at, 1.0, format),
                     fmt::format("{} of {}", row.diverges_at.count, row.max.count)});
  }
  return table_text(about(report), cells, 2, format);
}

std::string table_text(const std::vector<std::string>& about,
                       const std::vector<std::vector<std::string>>& cells, std::size_t texts,
                       TableFormat format) {
  const bool latex = format == TableFormat::latex;
  std::string out;
  for (const std::string& line : about) {
    std::string plain = one_line(line);
    // "--" ends a comment of markdown's.
    for (std::size_t at = 0; !latex && (at = plain.find("--", at)) != std::string::npos;) {
      plain.replace(at, 2, "- -");
    }
    out += latex ? "% " + plain + "\n" : "<!-- " + plain + " -->\n";
  }
  std::string columns, rule = "|";
  for (std::size_t c = 0; c < cells.front().size(); ++c) {
    columns += c < texts ? 'l' : 'r';
    rule += c < texts ? "---|" : "---:|";
  }
  if (latex) out += "\\begin{tabular}{" + columns + "}\n\\hline\n";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::string line;
    for (const std::string& cell : cells[i]) {
      line += latex ? (line.empty() ? "" : " & ") + cell : (line.empty() ? "| " : " | ") + cell;
    }
    out += line + (latex ? " \\\\\n" : " |\n");
    if (i == 0) out += latex ? "\\hline\n" : rule + "\n";
  }
  if (latex) out += "\\hline\n\\end{tabular}\n";
  // The mark of CogRSim's files.
  return out + (latex ? "%CogRSim\n" : "<!-- CogRSim -->\n");
}

}  // namespace cogrsim::cli
