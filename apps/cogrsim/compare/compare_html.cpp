#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "compare/compare_output.h"
#include "common/provenance_text.h"
#include "compare/zoom_chart.h"

namespace cogrsim::cli {
namespace {

constexpr std::size_t kTableRows = 200;
constexpr double kDegree = 3.14159265358979323846 / 180.0;

constexpr const char* kStyleSheet = R"css(
:root { color-scheme: light dark; --bg:#fcfcfa; --panel:#fff; --text:#1d1d1f; --soft:#63636b;
  --line:#e2e2de; --bad:#b3261e; --good:#1b6e3c;
  --c0:#1f6fb8; --c1:#cf4f0e; --c2:#0a8a5f; --c3:#a63d8f; --c4:#a87900; --c5:#3f9fd1; --c6:#6a55c2;
  --c7:#6c6c6c; }
@media (prefers-color-scheme: dark) { :root { --bg:#16171a; --panel:#1e2024; --text:#e9e9ec;
  --soft:#a2a3ab; --line:#34363c; --bad:#ff8a80; --good:#7fd3a0;
  --c0:#6db3f2; --c1:#ff9a5c; --c2:#4fcf9d; --c3:#e58bd2; --c4:#e6bf4a; --c5:#8fd3f7; --c6:#b3a4ff;
  --c7:#b9b9bd; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--bg); color: var(--text);
  font: 15px/1.45 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 60rem; margin: 0 auto; padding: 1.5rem 1rem 3rem; }
h1 { font-size: 1.5rem; margin: 0 0 .2rem; } h2 { font-size: 1.1rem; margin: 2rem 0 .5rem; }
p { margin: .3rem 0; } .soft { color: var(--soft); } .bad { color: var(--bad); } .good { color: var(--good); }
.verdict { font-size: 1.05rem; font-weight: 600; margin: .8rem 0; }
.scroll { overflow-x: auto; background: var(--panel); border: 1px solid var(--line); border-radius: 6px; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .7rem; text-align: right; white-space: nowrap; border-top: 1px solid var(--line); }
thead tr:first-child th { border-top: 0; } th { font-weight: 600; } thead th { color: var(--soft); }
th:first-child, td:first-child { text-align: left; } .wrap td { white-space: normal; }
.chart { position: relative; margin: 1rem 0; padding: .8rem; background: var(--panel);
  border: 1px solid var(--line); border-radius: 6px; }
figcaption { margin-bottom: .4rem; }
.chart label { float: right; font-size: .85rem; color: var(--soft); margin-left: .25rem; cursor: pointer; }
.chart input { vertical-align: middle; }
.plot { width: 100%; height: 19rem; } .plot .dygraph-axis-label, .plot .dygraph-label { color: var(--soft); }
.legend { font-size: .88rem; min-height: 1.4rem; font-variant-numeric: tabular-nums; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(18rem, 1fr)); gap: .8rem; margin: .8rem 0; }
.pictures figure { margin: 0; } .pictures img { width: 100%; display: block; border: 1px solid var(--line);
  border-radius: 6px; } .map { max-width: 100%; border: 1px solid var(--line); border-radius: 6px; }
.c0{color:var(--c0)} .c1{color:var(--c1)} .c2{color:var(--c2)} .c3{color:var(--c3)}
.c4{color:var(--c4)} .c5{color:var(--c5)} .c6{color:var(--c6)} .c7{color:var(--c7)}
ul.plain { padding-left: 1.1rem; }
)css";

std::string cell(const std::string& text) { return "<td>" + html_escaped(text) + "</td>"; }

std::string spread_cells(const std::optional<Spread>& spread, bool angle) {
  if (!spread) return "<td></td><td></td><td></td>";
  const auto text = [&](double value) { return angle ? angle_text(value) : length_text(value); };
  return cell(text(spread->max)) + cell(text(spread->rms)) + cell(text(spread->end));
}

std::string difference_table(const char* kind, const std::vector<Difference>& differences,
                             const CompareResult& comparison) {
  if (differences.empty()) return {};
  const bool several = comparison.runs.size() > 2;
  std::string out = fmt::format(
      "<h2>{}, worst first</h2>\n<div class=\"scroll\"><table><thead><tr><th "
      "rowspan=\"2\">name</th>{}"
      "<th colspan=\"3\">{} difference</th><th colspan=\"3\">angle difference</th>"
      "<th rowspan=\"2\">diverges at</th></tr><tr><th>max</th><th>rms</th><th>at "
      "end</th><th>max</th>"
      "<th>rms</th><th>at end</th></tr></thead><tbody>\n",
      kind, several ? "<th rowspan=\"2\">backend</th>" : "",
      std::string(kind) == "Bodies" ? "position" : "travel");
  const std::size_t shown = std::min(differences.size(), kTableRows);
  for (std::size_t i = 0; i < shown; ++i) {
    const Difference& d = differences[i];
    out += "<tr>" + cell(d.name);
    if (several) out += cell(comparison.runs[d.run]);
    out += spread_cells(d.distance, false) + spread_cells(d.angle, true);
    out += d.first_over ? fmt::format("<td class=\"bad\">{}</td>", time_text(*d.first_over))
                        : "<td class=\"soft\">never</td>";
    out += "</tr>\n";
  }
  out += "</tbody></table></div>\n";
  if (shown < differences.size()) {
    out += fmt::format("<p class=\"soft\">and {} more, in the JSON of <code>--json</code></p>\n",
                       differences.size() - shown);
  }
  return out;
}

std::string figures_table(const LockstepResult& result) {
  std::string out =
      "<h2>Backends</h2>\n<div class=\"scroll\"><table class=\"wrap\"><thead><tr><th></th>";
  for (const RunEnd& run : result.runs) {
    out += "<th>" + html_escaped(run.label) + "</th>";
  }
  out += "</tr></thead><tbody>\n";
  const auto line = [&](const char* title, auto text) {
    out += fmt::format("<tr><td>{}</td>", title);
    for (std::size_t i = 0; i < result.runs.size(); ++i) {
      out += cell(text(result.runs[i], result.comparison.figures[i]));
    }
    out += "</tr>\n";
  };
  const auto drift = [](const Drift& d, const char* unit) {
    return quantity_text(d.start, "") + " → " + quantity_text(d.end, unit);
  };
  const auto extreme = [](const Extreme& e, bool angle) {
    if (e.where.empty()) return std::string("none");
    return fmt::format("{} at {}, {}", angle ? angle_text(e.value) : length_text(e.value),
                       time_text(e.time), e.where);
  };
  using Run = const RunEnd&;
  using Figures = const RunFigures&;
  line("ended", [](Run r, Figures) {
    return fmt::format("{}, {}", to_string(r.status), time_text(r.time));
  });
  line("steps", [](Run r, Figures) { return fmt::format("{} of {}", r.steps, step_text(r.step)); });
  line("wall time of its own steps", [](Run r, Figures) { return elapsed_text(r.wall_time); });
  line("times real time", [](Run r, Figures) { return factor_text(r.time / r.wall_time); });
  line("energy", [&](Run, Figures f) { return drift(f.energy, "J"); });
  line("energy, largest drift",
       [](Run, Figures f) { return quantity_text(f.energy.largest, "J"); });
  line("momentum", [&](Run, Figures f) { return drift(f.linear_momentum, "kg m/s"); });
  line("momentum, largest drift",
       [](Run, Figures f) { return quantity_text(f.linear_momentum.largest, "kg m/s"); });
  line("angular momentum, largest drift",
       [](Run, Figures f) { return quantity_text(f.angular_momentum.largest, "kg m²/s"); });
  line("contacts, mean and most", [](Run, Figures f) {
    return fmt::format("{}, {}", quantity_text(f.mean_contacts, ""), f.most_contacts);
  });
  line("deepest penetration", [&](Run, Figures f) { return extreme(f.penetration, false); });
  line("largest joint error, distance",
       [&](Run, Figures f) { return extreme(f.joint_distance, false); });
  line("largest joint error, angle", [&](Run, Figures f) { return extreme(f.joint_angle, true); });
  return out + "</tbody></table></div>\n";
}

std::string provenance_table(const LockstepResult& result) {
  std::string out =
      "<h2>Who computed what</h2>\n<div class=\"scroll\"><table "
      "class=\"wrap\"><thead><tr><th></th>";
  std::vector<Provenance> runs;
  for (const RunEnd& run : result.runs) {
    out += "<th>" + html_escaped(run.label) + "</th>";
    runs.push_back(run.provenance);
  }
  out += "</tr></thead><tbody>\n";
  for (const auto& row : provenance_rows(runs)) {
    out += "<tr>";
    for (const std::string& text : row) out += cell(text);
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string convergence_table(const CompareReport& report) {
  if (report.convergence.empty()) return {};
  std::string out =
      "<h2>Convergence</h2>\n<p class=\"soft\">A backend's change is from its own run at the next "
      "smaller "
      "step; of two backends it is the difference between them. Positions, root mean square over "
      "bodies "
      "and time.</p>\n<div class=\"scroll\"><table><thead><tr><th></th><th>step</th><th>rms "
      "change</th>"
      "<th>observed order</th></tr></thead><tbody>\n";
  for (const ConvergenceSeries& series : report.convergence) {
    for (const ConvergencePoint& point : series.points) {
      if (!point.difference) continue;
      out += "<tr>" + cell(series.name) + cell(step_text(point.step)) +
             cell(length_text(*point.difference)) +
             cell(point.order ? fmt::format("{:.2f}", *point.order) : "-") + "</tr>\n";
    }
  }
  return out + "</tbody></table></div>\n";
}

// The worst elements' curves of one kind; nothing when all are zero-length.
std::string difference_chart(const std::string& id, const std::string& title,
                             const std::string& unit, double factor,
                             const std::vector<Difference>& differences,
                             std::optional<Spread> Difference::*part,
                             const CompareResult& comparison) {
  std::vector<const Difference*> worst;
  for (const Difference& d : differences) {
    if (d.*part) worst.push_back(&d);
  }
  std::stable_sort(worst.begin(), worst.end(), [&](const Difference* a, const Difference* b) {
    return (*(a->*part)).max > (*(b->*part)).max;
  });
  if (worst.empty()) return {};
  Chart chart;
  chart.id = id;
  chart.title = title;
  chart.unit = unit;
  chart.times = comparison.times;
  chart.may_be_log = true;
  const auto most = static_cast<std::size_t>(kChartColours);
  if (worst.size() > most) {
    chart.note = fmt::format("the worst {} of {}", most, worst.size());
    worst.resize(most);
  }
  for (const Difference* d : worst) {
    Curve curve;
    curve.name = comparison.runs.size() > 2 ? d->name + ", " + comparison.runs[d->run] : d->name;
    for (const double value : (*(d->*part)).curve) curve.y.push_back(value * factor);
    chart.curves.push_back(std::move(curve));
  }
  return chart_html(chart);
}

std::string energy_chart(const CompareResult& comparison) {
  Chart chart;
  chart.id = "energy";
  chart.title = "Energy";
  chart.note = "kinetic and potential, per backend";
  chart.unit = "J";
  chart.times = comparison.times;
  const std::size_t shown = std::min<std::size_t>(comparison.runs.size(), kChartColours);
  for (std::size_t i = 0; i < shown; ++i) {
    chart.curves.push_back({comparison.runs[i], comparison.figures[i].energy_curve});
  }
  return chart_html(chart);
}

std::string data_uri(const char* type, const std::string& bytes) {
  return fmt::format("data:{};base64,{}", type, base64(bytes));
}

// Every backend's picture of one instant, side by side.
std::string instant_html(const PictureInstant& instant) {
  std::string out =
      fmt::format("<h2>{}</h2>\n<div class=\"pictures\">\n", html_escaped(instant.title));
  for (const auto& [label, png] : instant.pictures) {
    const std::string caption = html_escaped(label);
    out +=
        fmt::format("<figure><img alt=\"{0}\" src=\"{1}\"><figcaption>{0}</figcaption></figure>\n",
                    caption, data_uri("image/png", png));
  }
  return out + "</div>\n";
}

std::string pictures_html(const CompareReport& report) {
  const ReportPictures& pictures = report.pictures;
  std::string out;
  for (const PictureInstant& instant : pictures.instants) out += instant_html(instant);
  if (!pictures.map.empty()) {
    out += fmt::format(
        "<h2>From above, at {}</h2>\n<p class=\"soft\">{} in colour, the others as outlines; "
        "dashed: the path of each.</p>\n<img class=\"map\" alt=\"plan view\" src=\"{}\">\n",
        time_text(report.result->comparison.end_time),
        html_escaped(report.result->runs.front().label), data_uri("image/svg+xml", pictures.map));
  }
  if (!pictures.problem.empty()) {
    out += fmt::format("<p class=\"soft\">No pictures: {}</p>\n", html_escaped(pictures.problem));
  }
  return out.empty()
             ? out
             : out +
                   "<h2>Curves</h2>\n<p class=\"soft\">Drag to zoom, hold shift to pan, click "
                   "twice to see all.</p>\n";
}

std::string messages_list(const CompareReport& report) {
  std::string items;
  for (const Diagnostic& diagnostic : report.diagnostics) {
    items += fmt::format("<li>{} {}</li>\n", html_escaped(diagnostic.code),
                         html_escaped(diagnostic.message));
  }
  std::size_t shown = 0, left = 0;
  for (const RunEnd& run : report.result->runs) {
    for (const RunMessage& message : run.messages) {
      if (++shown > kTableRows) {
        ++left;
        continue;
      }
      items += fmt::format("<li{}>{}, at {}, {}: {}</li>\n",
                           message.severity == Severity::error ? " class=\"bad\"" : "",
                           html_escaped(run.label), time_text(message.time),
                           html_escaped(message.source), html_escaped(message.message));
    }
  }
  if (left > 0) items += fmt::format("<li>and {} more</li>\n", left);
  return items.empty() ? "" : "<h2>Messages</h2>\n<ul class=\"plain\">\n" + items + "</ul>\n";
}

}  // namespace

std::string page_start(const std::string& title) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}</title>\n<style>{}</style></head>\n<body><main>\n",
      html_escaped(title), std::string(kDygraphsStyle) + kStyleSheet);
}

std::string page_end() {
  return "</main>\n<script>" + chart_script() + "</script>\n</body></html>\n";
}

std::string compare_html(const CompareReport& report) {
  if (!report.result) return {};
  const LockstepResult& result = *report.result;
  const CompareResult& comparison = result.comparison;
  std::string others = comparison.runs[1];
  for (std::size_t i = 2; i < comparison.runs.size(); ++i) others += ", " + comparison.runs[i];

  const std::string name = html_escaped(report.scene);
  std::string out =
      page_start(fmt::format("{}: {} against {}", report.scene, others, comparison.runs[0]));
  out += fmt::format("<h1>{}</h1>\n<p class=\"soft\">{} against {}, {} in steps of {}, {}</p>\n",
                     name, html_escaped(others), html_escaped(comparison.runs[0]),
                     time_text(comparison.end_time), step_text(result.runs[0].step),
                     html_escaped(report.file));
  const std::string limits = html_escaped(thresholds_text(comparison.options));
  if (comparison.first_over) {
    out += fmt::format("<p class=\"verdict bad\">Diverged by more than {} at {}, first {}</p>\n",
                       limits, time_text(*comparison.first_over),
                       html_escaped(comparison.first_over_name));
  } else {
    out += fmt::format("<p class=\"verdict good\">Never diverged by more than {}</p>\n", limits);
  }
  if (!result.ended_early.empty()) {
    out += fmt::format("<p class=\"bad\">Compared only up to {}: {}</p>\n",
                       time_text(comparison.end_time), html_escaped(result.ended_early));
  }
  out += pictures_html(report);
  out += difference_chart("position", "Position difference", "m", 1.0, comparison.bodies,
                          &Difference::distance, comparison);
  out += difference_chart("angle", "Angle difference", "deg", 1.0 / kDegree, comparison.bodies,
                          &Difference::angle, comparison);
  out += difference_chart("jointangle", "Joint angle difference", "deg", 1.0 / kDegree,
                          comparison.joints, &Difference::angle, comparison);
  out += difference_chart("jointtravel", "Joint travel difference", "m", 1.0, comparison.joints,
                          &Difference::distance, comparison);
  out += energy_chart(comparison);
  out += provenance_table(result);
  out += figures_table(result);
  out += difference_table("Bodies", comparison.bodies, comparison);
  out += difference_table("Joints", comparison.joints, comparison);
  out += convergence_table(report);
  out += messages_list(report);
  out += fmt::format(
      "<p class=\"soft\">{} instants were compared; a curve shows the largest difference in each "
      "of its "
      "{} intervals. Wall time is counted around each backend's own steps.</p>\n",
      comparison.samples, comparison.times.size());
  return out + page_end();
}

}  // namespace cogrsim::cli
