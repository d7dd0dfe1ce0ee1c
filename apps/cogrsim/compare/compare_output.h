// A comparison as a table for the terminal, as JSON, and as a page for a browser.
#pragma once

#include <cstdint>
#include <map>

#include <string>
#include <vector>

#include "compare/compare_study.h"
#include "compare/convergence.h"
#include "common/json_text.h"
#include "compare/lockstep.h"
#include "compare/report_pictures.h"
#include "common/terminal.h"

namespace cogrsim::cli {

struct CompareReport {
  std::string scene;  ///< its name; empty when it did not compile
  std::string file;
  std::string status = "failed";  ///< completed, stopped, diverged, fault; failed: never started
  double duration = 0.0;          ///< asked for [s]
  std::uint64_t seed = 0;
  std::map<std::string, std::string> set;  ///< `--set`
  std::vector<std::string> backends;       ///< asked for
  std::optional<LockstepResult> result;
  std::vector<ConvergenceSeries> convergence;  ///< empty: one step only
  CompareStudy study;                          ///< of all repetitions; `result` is the first
  double twin = 0.0;                           ///< see LockstepOptions
  ReportPictures pictures;                     ///< for the page
  std::vector<Diagnostic> diagnostics;
};

/// `rows`: of each table, the rest is counted.
std::string compare_text(const CompareReport& report, int rows, const Style& style);

/// When two runs of the reference that hardly differ part: from then on chaos decides, not the engine.
struct Chaos {
  std::string run;                   ///< label of the twin
  std::optional<double> first_over;  ///< [s]; empty: never
  double largest = 0.0;              ///< distance [m]
};
/// Empty: there is no twin.
std::optional<Chaos> chaos_of(const CompareReport& report);

enum class TableFormat { markdown, latex };
/// `text` for a cell.
std::string table_escaped(const std::string& text, TableFormat format);
/// A mean in `unit`s with as many digits as its uncertainty deserves: two of that, else three.
std::string estimate_text(const Estimate& estimate, double unit, TableFormat format);
/// Cells, the first row the head, below comments that say what they are about. The first `texts` columns
/// are texts, the others numbers.
std::string table_text(const std::vector<std::string>& about,
                       const std::vector<std::vector<std::string>>& cells, std::size_t texts,
                       TableFormat format);
/// The differences as a table for a paper, below a comment with the command that makes them
/// again. `rows`: at most.
std::string compare_table(const CompareReport& report, TableFormat format, int rows);

/// Keys: scene, file, status, duration, time, samples, thresholds, first_over, ended_early, runs
/// (one per backend), bodies, joints, convergence, chaos, study, diagnostics.
Json to_json(const CompareReport& report);

/// One HTML file that needs nothing else: figures, tables and curves, light and dark.
std::string compare_html(const CompareReport& report);

/// A page's start, with the style sheet of reports, up to its content; and what follows that.
std::string page_start(const std::string& title);
std::string page_end();

/// "10 mm or 1°": what counts as divergence.
std::string thresholds_text(const CompareOptions& options);

}  // namespace cogrsim::cli
