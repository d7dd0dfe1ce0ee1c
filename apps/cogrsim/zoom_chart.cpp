#include "svg_chart.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace cogrsim::cli {
namespace {

// Layout in SVG units; the page scales the whole.
constexpr double kWidth = 760, kHeight = 290;
constexpr double kLeft = 70, kRight = 16, kTop = 12, kBottom = 38;

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

struct Axis {
  double low = 0.0, high = 1.0;
  bool log = false;
  double at(double value) const {
    if (log) value = std::log10(std::max(value, std::pow(10.0, low)));
    return std::clamp((value - low) / (high - low), -0.02, 1.02);
  }
};

double x_of(const Axis& axis, double value) {
  return kLeft + axis.at(value) * (kWidth - kLeft - kRight);
}
double y_of(const Axis& axis, double value) {
  return kHeight - kBottom - axis.at(value) * (kHeight - kTop - kBottom);
}

template <class Visit>
void each_value(const Chart& chart, double factor, Visit visit) {
  for (const Curve& curve : chart.curves) {
    for (const double value : curve.y) {
      if (std::isfinite(value)) visit(value * factor);
    }
  }
}

Axis linear_axis(const Chart& chart, double factor) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  each_value(chart, factor, [&](double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  });
  if (chart.may_be_log) low = 0.0;
  if (!(low <= high)) return {0.0, 1.0};
  const double room = high > low ? 0.05 * (high - low) : std::max(1e-12, 0.05 * std::fabs(high));
  return {chart.may_be_log ? 0.0 : low - room, high + room};
}

Axis log_axis(const Chart& chart, double factor) {
  double low = std::numeric_limits<double>::infinity(), high = 0.0;
  each_value(chart, factor, [&](double value) {
    if (value <= 0.0) return;
    low = std::min(low, value);
    high = std::max(high, value);
  });
  if (high <= 0.0) return {-1.0, 0.0, true};
  // Rounding noise at the start would squeeze everything else.
  low = std::max(low, high * 1e-8);
  return {std::floor(std::log10(low)), std::ceil(std::log10(high) + 1e-9), true};
}

std::string tick_text(double value, double step) {
  if (value == 0.0) return "0";
  const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  if (std::fabs(value) >= 1e6) return fmt::format("{:.3g}", value);
  return fmt::format("{:.{}f}", value, digits);
}

std::string grid(const Axis& x, const Axis& y) {
  std::string out;
  const auto horizontal = [&](double position, const std::string& label) {
    out += fmt::format(
        "<line class=\"grid\" x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>"
        "<text class=\"tick\" text-anchor=\"end\" x=\"{}\" y=\"{:.1f}\">{}</text>",
        kLeft, kWidth - kRight, position, position, kLeft - 8, position + 4, label);
  };
  if (y.log) {
    const int decades = static_cast<int>(y.high - y.low);
    const int stride = std::max(1, (decades + 5) / 6);
    for (int d = static_cast<int>(y.low); d <= static_cast<int>(y.high); d += stride) {
      const double value = std::pow(10.0, d);
      horizontal(y_of(y, value),
                 d > -4 && d < 4 ? fmt::format("{:g}", value) : fmt::format("1e{}", d));
    }
  } else {
    const auto ticks = nice_ticks(y.low, y.high, 5);
    const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
    for (const double tick : ticks) horizontal(y_of(y, tick), tick_text(tick, step));
  }
  const auto ticks = nice_ticks(x.low, x.high, 8);
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
  for (const double tick : ticks) {
    out +=
        fmt::format("<text class=\"tick\" text-anchor=\"middle\" x=\"{:.1f}\" y=\"{}\">{}</text>",
                    x_of(x, tick), kHeight - kBottom + 18, tick_text(tick, step));
  }
  return out;
}

std::string svg(const Chart& chart, const Scaled& scaled, const Axis& y, const char* scale_class) {
  const Axis x{chart.times.empty() ? 0.0 : std::min(0.0, chart.times.front()),
               chart.times.empty() || chart.times.back() <= 0.0 ? 1.0 : chart.times.back()};
  std::string out = fmt::format(
      "<svg class=\"plot {}\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" "
      "data-left=\"{}\" "
      "data-right=\"{}\" data-t0=\"{:.9g}\" data-t1=\"{:.9g}\">",
      scale_class, kWidth, kHeight, html_escaped(chart.title), kLeft, kWidth - kRight, x.low,
      x.high);
  out += grid(x, y);
  out += fmt::format("<text class=\"tick\" text-anchor=\"end\" x=\"{}\" y=\"{}\">time [s]</text>",
                     kWidth - kRight, kHeight - 4);
  out += fmt::format("<text class=\"tick\" x=\"4\" y=\"{}\">[{}]</text>", kHeight - kBottom + 18,
                     html_escaped(scaled.unit));
  // The worst comes first in the legend and is drawn last, above the others.
  for (std::size_t c = chart.curves.size(); c-- > 0;) {
    std::string path;
    bool drawing = false;
    const auto& values = chart.curves[c].y;
    for (std::size_t i = 0; i < values.size() && i < chart.times.size(); ++i) {
      const double value = values[i] * scaled.factor;
      if (!std::isfinite(value)) {
        drawing = false;
        continue;
      }
      path += fmt::format("{}{:.1f} {:.1f}", drawing ? "L" : "M", x_of(x, chart.times[i]),
                          y_of(y, value));
      drawing = true;
    }
    out += fmt::format("<path class=\"curve c{}\" d=\"{}\"/>", c, path);
  }
  return out +
         fmt::format("<line class=\"cursor\" y1=\"{}\" y2=\"{}\"/></svg>", kTop, kHeight - kBottom);
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

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
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

std::vector<double> nice_ticks(double low, double high, int wanted) {
  if (!(high > low)) return {low};
  const double raw = (high - low) / wanted;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * power;
  for (const double candidate : {1.0, 2.0, 5.0}) {
    if (candidate * power >= raw * (1.0 - 1e-9)) {
      step = candidate * power;
      break;
    }
  }
  std::vector<double> ticks;
  const double first = std::ceil(low / step - 1e-9);
  for (double i = first; i * step <= high + 1e-9 * step; i += 1.0) ticks.push_back(i * step);
  return ticks;
}

std::string chart_html(const Chart& chart) {
  double largest = 0.0;
  each_value(chart, 1.0, [&](double value) { largest = std::max(largest, std::fabs(value)); });
  const Scaled scaled = scaled_unit(chart.unit, largest);
  const bool both = chart.may_be_log && largest > 0.0;

  std::string out = fmt::format("<figure class=\"chart\" id=\"{}\">\n", chart.id);
  if (both) {
    // Floated to the right, so the last comes first.
    out += fmt::format(
        "<label for=\"{0}-log\">logarithmic</label>"
        "<input type=\"radio\" class=\"to-log\" name=\"{0}-scale\" id=\"{0}-log\">"
        "<label for=\"{0}-linear\">linear</label>"
        "<input type=\"radio\" class=\"to-linear\" name=\"{0}-scale\" id=\"{0}-linear\" checked>\n",
        chart.id);
  }
  out += fmt::format("<figcaption><b>{}</b>{}</figcaption>\n", html_escaped(chart.title),
                     chart.note.empty() ? "" : " " + html_escaped(chart.note));
  out += svg(chart, scaled, linear_axis(chart, scaled.factor), "linear") + "\n";
  if (both) out += svg(chart, scaled, log_axis(chart, scaled.factor), "log") + "\n";
  out += "<ul class=\"legend\">";
  for (std::size_t c = 0; c < chart.curves.size(); ++c) {
    out += fmt::format("<li><i class=\"c{}\"></i>{} <span></span></li>", c,
                       html_escaped(chart.curves[c].name));
  }
  out += "</ul>\n";
  out += fmt::format("<script type=\"application/json\">{{\"unit\":{},\"times\":{},\"curves\":[",
                     script_string(scaled.unit), number_list(chart.times, 1.0, chart.times.size()));
  for (std::size_t c = 0; c < chart.curves.size(); ++c) {
    out += (c > 0 ? "," : "") + number_list(chart.curves[c].y, scaled.factor, chart.times.size());
  }
  return out + "]}</script>\n</figure>\n";
}

}  // namespace cogrsim::cli
