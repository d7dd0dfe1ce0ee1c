// Curves over time as SVG, for a page that needs nothing from elsewhere.
#pragma once

#include <string>
#include <vector>

namespace cogrsim::cli {

struct Curve {
  std::string name;
  std::vector<double> y;  ///< against Chart::times; may be shorter; what is not finite is a gap
};

struct Chart {
  std::string id;  ///< unique on the page, letters only
  std::string title;
  std::string unit;           ///< SI: "m", "J" get a prefix that fits; "deg" stays
  std::string note;           ///< a sentence under the title; may be empty
  std::vector<double> times;  ///< [s]
  std::vector<Curve> curves;  ///< at most kChartColours
  bool may_be_log = false;    ///< differences: offers a logarithmic scale too
};

/// Colours that the page's style sheet defines, .c0 to .c7.
inline constexpr int kChartColours = 8;

/// `text` as HTML, and safe in attributes.
std::string html_escaped(const std::string& text);

/// A <figure> with title, scale switch, SVG, legend, and the data that the page's script reads for
/// the read-out under the pointer.
std::string chart_html(const Chart& chart);

/// Round numbers that divide [low, high] into `wanted` parts or a few more or less.
std::vector<double> nice_ticks(double low, double high, int wanted);

}  // namespace cogrsim::cli
