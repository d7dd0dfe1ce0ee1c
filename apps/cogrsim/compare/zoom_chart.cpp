#include "compare/zoom_chart.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/shown_text.h"

namespace cogrsim::cli {
namespace {

struct Scaled {
  double factor = 1.0;
  std::string unit;
};

Scaled scaled_unit(const std::string& unit, double largest) {
  if (unit == "deg") return {1.0, "°"};
  if (largest >= 1e3 && unit != "m") return {1e-3, "k" + unit};
  if (largest >= 1.0 || largest == 0.0) return {1.0, unit};
  if (largest >= 1e-3) return {1e3, "m" + unit};
  if (largest >= 1e-6) return {1e6, "µ" + unit};
  return {1e9, "n" + unit};
}

std::string script_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    // No "<" may reach a script element: it could end it.
    if (byte < 0x20 || c == '"' || c == '\\' || c == '<')
      out += fmt::format("\\u{:04x}", byte);
    else
      out += c;
  }
  return out + "\"";
}

std::string number_list(const std::vector<double>& values, double factor, std::size_t most) {
  std::string out = "[";
  for (std::size_t i = 0; i < values.size() && i < most; ++i) {
    if (i > 0) out += ",";
    out += std::isfinite(values[i]) ? fmt::format("{:.5g}", values[i] * factor) : "null";
  }
  return out + "]";
}

// Of each curve its colour, as the page's style sheet names it.
std::string color_list(std::size_t count) {
  std::string out = "[";
  for (std::size_t i = 0; i < count; ++i) {
    out += fmt::format("{}\"--c{}\"", i > 0 ? "," : "", i % kChartColours);
  }
  return out + "]";
}

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string out;
  for (const char c : printable(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string chart_html(const Chart& chart) {
  double largest = 0.0;
  for (const Curve& curve : chart.curves) {
    for (const double value : curve.y) {
      if (std::isfinite(value)) largest = std::max(largest, std::fabs(value));
    }
  }
  const Scaled scaled = scaled_unit(chart.unit, largest);
  std::string out = fmt::format("<figure class=\"chart\" id=\"{}\">\n<figcaption><b>{}</b>{}",
                                chart.id, html_escaped(chart.title),
                                chart.note.empty() ? "" : " " + html_escaped(chart.note));
  if (chart.may_be_log && largest > 0.0) {
    out += "<label><input type=\"checkbox\" class=\"log\"> logarithmic</label>";
  }
  out += "</figcaption>\n<div class=\"plot\"></div><div class=\"legend\"></div>\n";
  out +=
      fmt::format("<script type=\"application/json\">{{\"unit\":{},\"from_zero\":{},\"colors\":{},",
                  script_string(scaled.unit), chart.may_be_log, color_list(chart.curves.size()));
  out += "\"names\":[";
  for (std::size_t c = 0; c < chart.curves.size(); ++c) {
    out += (c > 0 ? "," : "") + script_string(chart.curves[c].name);
  }
  out +=
      fmt::format("],\"times\":{},\"curves\":[", number_list(chart.times, 1.0, chart.times.size()));
  for (std::size_t c = 0; c < chart.curves.size(); ++c) {
    out += (c > 0 ? "," : "") + number_list(chart.curves[c].y, scaled.factor, chart.times.size());
  }
  return out + "]}</script>\n</figure>\n";
}

std::string chart_script() {
  // Draws every chart of the page; dragging zooms, shift pans, a double click shows all again.
  static constexpr const char* kScript = R"js(
for (const figure of document.querySelectorAll("figure.chart")) {
  const data = JSON.parse(figure.querySelector("script").textContent);
  const rows = data.times.map((t, i) => [t, ...data.curves.map((c) => c[i] ?? NaN)]);
  const style = getComputedStyle(document.documentElement);
  // Names come from scenes: the chart library puts them into the page as they are.
  const plain = (text) => text.replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`);
  const chart = new Dygraph(figure.querySelector(".plot"), rows, {
    labels: ["t", ...data.names.map((name, i) => plain(name) || `${i + 1}`)],
    labelsDiv: figure.querySelector(".legend"), legend: "always",
    colors: data.colors.map((name) => style.getPropertyValue(name).trim()),
    xlabel: "time [s]", ylabel: `[${data.unit}]`, strokeWidth: 1.8, includeZero: data.from_zero,
    axisLineColor: style.getPropertyValue("--soft"), gridLineColor: style.getPropertyValue("--line"),
    highlightCircleSize: 4, animatedZooms: true, xRangePad: 4, yRangePad: 6,
    axes: { y: { axisLabelWidth: 64, valueFormatter: (v) => `${v.toPrecision(4)} ${data.unit}` },
            x: { valueFormatter: (v) => `${v.toPrecision(5)} s` } },
  });
  const log = figure.querySelector(".log");
  if (log) log.addEventListener("change", () => chart.updateOptions({ logscale: log.checked }));
}
)js";
  std::string script = kDygraphs;  // in steps: g++ 12 warns of a sum of them in C++20
  script += '\n';
  return script += kScript;
}

}  // namespace cogrsim::cli
