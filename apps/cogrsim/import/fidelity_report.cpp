#include "import/fidelity_report.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <map>

#include "common/arguments.h"
#include "common/output_file.h"
#include "common/terminal.h"
#include "compare/zoom_chart.h"

namespace cogrsim::cli {

using dsl::Fidelity;

namespace {

/// Light and dark; the bar shows the shares, the buttons choose the rows.
constexpr const char* kStyle =
    ":root{color-scheme:light dark;--exact:#2a7a2a;--approximate:#9a6a00;--left:#b02a2a;"
    "--line:#8884}@media(prefers-color-scheme:dark){:root{--exact:#6ecb6e;--approximate:#e0b040;"
    "--left:#ff8a80}}body{font:15px/1.5 system-ui,sans-serif;max-width:72em;margin:2em auto;"
    "padding:0 1em}h1{font-size:1.4em;overflow-wrap:anywhere}table{border-collapse:collapse;"
    "width:100%}td,th{text-align:left;padding:.3em .6em;border-bottom:1px solid var(--line);"
    "vertical-align:top;overflow-wrap:anywhere}.exact{color:var(--exact)}"
    ".approximate{color:var(--approximate)}.left{color:var(--left)}.bar{display:flex;height:.8em;"
    "border-radius:.4em;overflow:hidden;margin:.6em 0}.bar span{background:currentColor}"
    "label{margin-right:1.2em;white-space:nowrap}td:first-child{white-space:nowrap}"
    "td:last-child{font-family:ui-monospace,monospace;font-size:.85em}"
    "body:has(#s-exact:not(:checked)) tr.r-exact,"
    "body:has(#s-approximate:not(:checked)) tr.r-approximate,"
    "body:has(#s-left:not(:checked)) tr.r-left{display:none}";

const char* css_class(Fidelity fidelity) {
  return fidelity == Fidelity::left_out ? "left" : dsl::fidelity_name(fidelity);
}

}  // namespace

void add_report_options(CLI::App& command, std::string& report, bool& strict) {
  command
      .add_option("--report", report,
                  "Write what is exact, approximate and left out, element by element")
      ->type_name("FILE.json|.html");
  command.add_flag("--strict", strict, "Fail if anything is left out");
}

void check_report_name(const std::string& file) {
  if (!file.empty() && !file.ends_with(".json") && !file.ends_with(".html"))
    throw UsageError("--report", Error("'" + file + "' ends neither in .json nor in .html"));
}

OutputKind report_kind(const std::string& file) {
  return file.ends_with(".html") ? OutputKind::html : OutputKind::json;
}

void print_fidelity(const dsl::FidelityReport& report) {
  const Style style = style_of(STDERR_FILENO);
  const std::vector<const dsl::ImportEntry*> entries = report.by_weight();
  for (const Fidelity fidelity : {Fidelity::left_out, Fidelity::approximate}) {
    const std::size_t count = report.count(fidelity);
    if (count == 0) continue;
    std::string text = fmt::format("{}{}{}, {}:\n", style.cyan, dsl::fidelity_name(fidelity),
                                   style.off, count_text(count, "element", "elements"));
    // Elements of which the same is said share a line.
    std::map<std::string, std::size_t> like;
    for (const dsl::ImportEntry* e : entries)
      if (e->fidelity == fidelity) ++like[e->message];
    // All that changes the motion is listed.
    constexpr std::size_t kMostOthers = 10;
    std::size_t others = 0, hidden = 0;
    for (const dsl::ImportEntry* e : entries) {
      if (e->fidelity != fidelity) continue;
      std::size_t& alike = like[e->message];
      if (alike == 0) continue;
      if (!e->moves && ++others > kMostOthers) {
        hidden += alike;
      } else {
        text += fmt::format("  {}{}{}{}: {}\n", one_line(e->position_text()), e->file.empty() ? "" : ": ",
                            one_line(e->element),
                            alike > 1 ? fmt::format(" and {} more", alike - 1) : std::string(),
                            one_line(e->message));
      }
      alike = 0;
    }
    if (hidden > 0)
      text += fmt::format(
          "  and {} more, which change no motion; --report FILE.html lists all\n", hidden);
    std::fputs(text.c_str(), stderr);
  }
}

Json fidelity_json(const ConversionTitle& title, const dsl::FidelityReport& report,
                   const std::vector<Diagnostic>& diagnostics) {
  Json entries = Json::array();
  for (const dsl::ImportEntry* e : report.by_weight())
    entries.push_back({{"fidelity", dsl::fidelity_name(e->fidelity)},
                       {"changes_motion", e->moves && e->fidelity != Fidelity::exact},
                       {"element", e->element},
                       {"message", e->message},
                       {"file", e->file},
                       {"line", e->line},
                       {"column", e->column}});
  return {{"source", title.source},
          {"format", title.format},
          {"imported", title.done},
          {"exact", report.count(Fidelity::exact)},
          {"approximate", report.count(Fidelity::approximate)},
          {"left_out", report.count(Fidelity::left_out)},
          {"entries", std::move(entries)},
          {"diagnostics", Json::parse(dsl::to_json(diagnostics))}};
}

std::string fidelity_html(const ConversionTitle& title, const dsl::FidelityReport& report,
                          const std::vector<Diagnostic>& diagnostics) {
  std::string out = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>\n"
      "<style>{1}</style></head><body>\n<h1>{0}</h1>\n<p>{2}</p>\n",
      html_escaped(title.text), kStyle,
      html_escaped(!title.format.empty() ? title.format : "not converted"));
  constexpr Fidelity kAll[] = {Fidelity::left_out, Fidelity::approximate, Fidelity::exact};
  std::string bar, boxes;
  for (const Fidelity f : kAll) {
    const std::size_t count = report.count(f);
    if (count > 0)
      bar += fmt::format("<span class=\"{}\" style=\"flex:{}\"></span>", css_class(f), count);
    boxes += fmt::format(
        "<label class=\"{0}\"><input type=\"checkbox\" id=\"s-{0}\" checked> <b>{1} {2}</b>"
        "</label>",
        css_class(f), count, dsl::fidelity_name(f));
  }
  out += "<div class=\"bar\">" + bar + "</div>\n<p>" + boxes + "</p>\n";
  for (const Diagnostic& d : diagnostics)
    out += fmt::format("<p class=\"left\"><b>{}: {}</b> {}</p>\n", html_escaped(d.position_text()),
                       html_escaped(d.message), html_escaped(d.help));
  out +=
      "<table><tr><th>fidelity</th><th>changes the motion</th><th>element</th><th>note</th>"
      "<th>source</th></tr>\n";
  for (const dsl::ImportEntry* e : report.by_weight())
    out += fmt::format(
        "<tr class=\"r-{0}\"><td class=\"{0}\">{1}</td><td>{2}</td><td>{3}</td><td>{4}</td>"
        "<td>{5}</td></tr>\n",
        css_class(e->fidelity), dsl::fidelity_name(e->fidelity),
        e->moves && e->fidelity != Fidelity::exact ? "yes" : "", html_escaped(e->element),
        html_escaped(e->message), html_escaped(e->position_text()));
  return out + "</table></body></html>\n";
}

Result<> write_fidelity(const std::string& file, const ConversionTitle& title,
                        const dsl::FidelityReport& report,
                        const std::vector<Diagnostic>& diagnostics) {
  if (file.empty()) return {};
  return write_output(file, report_kind(file),
                      file.ends_with(".html")
                          ? fidelity_html(title, report, diagnostics)
                          : json_text(fidelity_json(title, report, diagnostics)));
}

}  // namespace cogrsim::cli
