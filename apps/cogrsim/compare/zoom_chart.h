// Curves over time in a page that needs nothing from elsewhere: drawn by dygraphs, which the
// program carries in itself.
#pragma once

#include <string>
#include <vector>

namespace cogrsim::cli {

struct Curve {
  std::string name;
  std::vector<double> y;  ///< against Chart::times; may be shorter; not finite: a gap
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

/// A <figure> with title, space for the curves, and the data that chart_script() draws.
std::string chart_html(const Chart& chart);

/// The page's <script>, once: the library and our few lines.
std::string chart_script();

/// dygraphs' style sheet and code, as the build found them.
extern const char* const kDygraphsStyle;
extern const char* const kDygraphs;

}  // namespace cogrsim::cli
