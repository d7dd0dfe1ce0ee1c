#include "gnuplot_script.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "gnuplot_data.h"

namespace cogrsim::figures {
namespace {

// Colours that are distinguishable in print, too; after seven series the dash pattern changes.
constexpr const char* kColors[] = {"#0072bd", "#d95319", "#edb120", "#7e2f8e",
                                   "#77ac30", "#4dbeee", "#a2142f"};
constexpr std::size_t kColorCount = std::size(kColors);
constexpr std::size_t kInnerLegend = 6;  // series in a legend that still fits inside the axes

// Typographic form of a unit: "m/s^2" -> "m/s²", "N*m" -> "N·m".
std::string printed_unit(const std::string& unit) {
  std::string out;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const bool power = unit[i] == '^' && i + 1 < unit.size() &&
                       (unit[i + 1] == '2' || unit[i + 1] == '3') &&
                       (i + 2 == unit.size() || unit[i + 2] < '0' || unit[i + 2] > '9');
    if (power)
      out += unit[++i] == '2' ? "²" : "³";
    else if (unit[i] == '*')
      out += "·";
    else
      out += unit[i];
  }
  return out;
}

std::string axis_title(const Axis& axis) {
  if (axis.unit.empty() || axis.unit == "1") return axis.label;
  return axis.label + (axis.label.empty() ? "[" : " [") + printed_unit(axis.unit) + "]";
}

// Range of the drawable values along an axis.
class Extent {
 public:
  explicit Extent(const Axis& axis) : axis_(axis) {}
  void add(double value) {
    if (!drawable(value) || (axis_.log && value <= 0.0)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  void add(const std::vector<double>& values) {
    for (const double value : values) add(value);
  }
  bool empty() const { return low_ > high_; }

  /// `[low:high]` for gnuplot; "*" lets gnuplot choose an end as a round number. With a `margin`
  /// both ends are set, at that fraction of the extent beyond the data.
  std::string range(double margin = 0.0) const {
    double low = low_, high = high_;
    if (empty()) {
      low = axis_.log ? 1.0 : 0.0;
      high = axis_.log ? 10.0 : 1.0;
    } else if (axis_.log) {
      if (high / low > 1.0 + 1e-9) return text("*", "*");
      low /= 10.0;
      high *= 10.0;
    } else if (high - low > 1e-12 * std::max(std::fabs(low), std::fabs(high)) &&
               high - low > 1e-290) {
      if (margin == 0.0) return text("*", "*");
      const double more = margin * (high - low);
      low -= more;
      high += more;
    } else {
      // Constant data: the line is in the middle of a readable range.
      const double half = std::fabs(low) > 1e-290 ? 0.5 * std::fabs(low) : 1.0;
      low -= half;
      high += half;
    }
    return text(fmt::format("{}", low), fmt::format("{}", high));
  }

  /// Step for about five labels; 0: gnuplot chooses it.
  double tic_step() const {
    if (empty() || axis_.log ||
        !(high_ - low_ > 1e-9 * std::max(std::fabs(low_), std::fabs(high_))))
      return 0.0;
    return rounded_step((high_ - low_) / 5.0);
  }

  /// Range for bars, which start at 0, or below the last decade on a logarithmic axis.
  std::string range_from_zero() const {
    if (!axis_.log) return text("0", "*");
    return text(fmt::format("{}", low_ / 2.0), low_ < high_ ? "*" : fmt::format("{}", high_ * 10));
  }

 private:
  std::string text(const std::string& low, const std::string& high) const {
    return fmt::format("[{}:{}]", axis_.minimum ? fmt::format("{}", *axis_.minimum) : low,
                       axis_.maximum ? fmt::format("{}", *axis_.maximum) : high);
  }
  const Axis& axis_;
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
};

class Writer {
 public:
  Writer(const Figure& figure, const std::string& stem, const std::string& format,
         const DrawOptions& options)
      : figure_(figure), stem_(stem), format_(format), options_(options) {}

  GnuplotJob write() {
    head();
    axes();
    switch (figure_.kind) {
      case Kind::curve:
        curves();
        break;
      case Kind::map:
        maps();
        break;
      case Kind::box:
        boxes();
        break;
      case Kind::histogram:
        histograms();
        break;
      case Kind::surface:
        surface();
        break;
    }
    job_.script = {stem_ + ".gp", std::move(script_)};
    return std::move(job_);
  }

 private:
  template <class... Args>
  void line(fmt::format_string<Args...> text, Args&&... args) {
    script_ += fmt::format(text, std::forward<Args>(args)...) + "\n";
  }

  // "./" prevents gnuplot from interpreting a name as a pipe or an option.
  std::string file(const std::string& ending) const {
    return gnuplot_string("./" + stem_ + ending);
  }
  std::string data(const std::string& ending, std::string text) {
    job_.data.push_back({stem_ + ending, std::move(text)});
    return file(ending);
  }

  static std::string style(std::size_t series) { return std::to_string(series + 1); }

  void head() {
    const double scale = options_.width / 960.0;
    line("# CogRSim, for gnuplot: run it on this file, in this folder, to draw the picture again.");
    line("format = \"{}\"  # or \"png\", \"svg\", \"pdf\"", format_);
    line("set encoding utf8");
    line(
        "if (format eq \"png\") set terminal pngcairo noenhanced size {},{} font \"Sans,{:.3g}\" "
        "linewidth {:.3g} background \"white\"",
        options_.width, options_.height, options_.font_size * scale, 1.2 * scale);
    line(
        "if (format eq \"svg\") set terminal svg noenhanced size {},{} font \"Sans,{:.3g}\" "
        "linewidth {:.3g} background \"white\"",
        options_.width, options_.height, options_.font_size * scale * 4 / 3, 1.2 * scale);
    line(
        "if (format eq \"pdf\") set terminal pdfcairo noenhanced size {:.4g}in,{:.4g}in "
        "font \"Sans,{:.3g}\" linewidth {:.3g}",
        options_.width / 150.0, options_.height / 150.0, options_.font_size * scale * 0.75,
        1.2 * scale);
    line("set output {}.format", file("."));
    line("set datafile separator comma");
    line("");
    for (std::size_t i = 0; i < std::max<std::size_t>(figure_.series.size(), 1); ++i)
      line("set style line {} lc rgb \"{}\" lw 1.5 dt {} pt 7 ps 0.5", i + 1,
           kColors[i % kColorCount], 1 + (i / kColorCount) % 5);
    line("set style line 1000 lc rgb \"#262626\" lw 1    # axes");
    line("set style line 1001 lc rgb \"#dfdfdf\" lw 0.6  # grid");
    line("set border 31 ls 1000");
    line("set tics scale 0.6 textcolor rgb \"#262626\"");
    line("set format \"%g\"");
    line("set grid ls 1001");
    line("set title {} font \":Bold\"", gnuplot_string(figure_.title, true));
    line("set xlabel {}", gnuplot_string(axis_title(figure_.x)));
    line("set ylabel {}", gnuplot_string(axis_title(figure_.y)));
    const bool legend = figure_.legend.value_or(figure_.series.size() > 1);
    if (figure_.kind == Kind::map && figure_.legend.value_or(true))
      line("set key below center horizontal Left reverse samplen 2.5 height 1.5");
    else if (!legend || figure_.kind == Kind::box || figure_.kind == Kind::surface)
      line("unset key");
    else if (figure_.series.size() > kInnerLegend)
      line("set key outside right top Left reverse samplen 2");
    else
      line(
          "set key inside right top opaque box ls 1001 Left reverse samplen 2.5 width 1 "
          "height 0.4");
  }

  void axes() {
    std::string log;
    if (figure_.x.log && figure_.kind != Kind::box) log += "x";
    if (figure_.y.log) log += "y";
    if (figure_.z.log && figure_.kind == Kind::surface) log += "z";
    if (!log.empty()) line("set logscale {}", log);
    if (!log.empty() && log.back() == 'z') line("set logscale cb");
  }

  /// Axes with the text "no data".
  void nothing(const std::string& command = "plot") {
    line("set label 9 \"no data\" at {} center front textcolor rgb \"#808080\"",
         command == "plot" ? "graph 0.5, graph 0.5" : "screen 0.5, screen 0.5");
    line("{} NaN notitle", command);
  }

  void plot(const std::vector<std::string>& elements, const char* command = "plot") {
    script_ += std::string(command) + " ";
    for (std::size_t i = 0; i < elements.size(); ++i)
      script_ += (i > 0 ? ", \\\n     " : "\\\n     ") + elements[i];
    script_ += "\n";
  }

  std::string title(std::size_t series) const {
    const std::string& label = figure_.series[series].label;
    return "title " + gnuplot_string(label.empty() ? std::to_string(series + 1) : label);
  }

  std::string ending(std::size_t series) const {
    return figure_.series.size() > 1 ? fmt::format("-{}.csv", series + 1) : ".csv";
  }

  /// Data of one line. Single points between two gaps are drawn as points, because a line does not
  /// show
/// them.
  void add_line(std::size_t i, const std::string& dash, std::vector<std::string>& elements) {
    const Series& series = figure_.series[i];
    const PathData path = path_data(figure_, series);
    const std::string name = data(ending(i), path.csv);
    elements.push_back(
        fmt::format("{} skip 1 using 1:2 with lines ls {}{} {}", name, style(i), dash, title(i)));
    if (path.isolated > 0)
      elements.push_back(
          fmt::format("{} skip 1 using 1:3 with points ls {} notitle", name, style(i)));
  }

  void ranges(const Extent& x, const Extent& y, double margin = 0.0) {
    line("set xrange {}", x.range(margin));
    line("set yrange {}", y.range(margin));
  }

  void curves() {
    Extent x(figure_.x), y(figure_.y);
    std::vector<std::string> elements;
    for (std::size_t i = 0; i < figure_.series.size(); ++i) {
      const Series& series = figure_.series[i];
      for (std::size_t k = 0; k < series.x.size(); ++k) {
        if (!point_drawable(figure_, series.x[k], series.y[k])) continue;
        x.add(series.x[k]);
        y.add(series.y[k]);
      }
      add_line(i, "", elements);
    }
    ranges(x, y);
    x.empty() ? nothing() : plot(elements);
  }

  void maps() {
    Extent x(figure_.x), y(figure_.y);
    std::vector<std::string> elements;
    std::string ends;
    for (std::size_t i = 0; i < figure_.series.size(); ++i) {
      const Series& series = figure_.series[i];
      std::size_t first = series.x.size(), last = 0;
      for (std::size_t k = 0; k < series.x.size(); ++k) {
        if (!point_drawable(figure_, series.x[k], series.y[k])) continue;
        x.add(series.x[k]);
        y.add(series.y[k]);
        first = std::min(first, k);
        last = k;
      }
      if (first < series.x.size())
        ends += fmt::format("{},{},{},{},{}\n", series.x[first], series.y[first], series.x[last],
                            series.y[last], i + 1);
      add_line(i, " dt 2", elements);
    }
    line("set size ratio -1");
    ranges(x, y, 0.06);
    if (x.empty()) return nothing();
    line("\n# first and last point of every path, and its style\n$ends << END\n{}END\n", ends);
    elements.push_back(
        "$ends using 1:2:(color($5)) with points lc rgb variable pt 6 ps 1.6 lw 1.6 notitle");
    elements.push_back(
        "$ends using 3:4:(color($5)) with points lc rgb variable pt 5 ps 1.3 notitle");
    elements.push_back("NaN with points lc rgb \"#606060\" pt 6 ps 1.6 lw 1.6 title \"start\"");
    elements.push_back("NaN with points lc rgb \"#606060\" pt 5 ps 1.3 title \"end\"");
    // Numbers, because variable colours must be numbers.
    std::string colors;
    for (const char* color : kColors)
      colors += (colors.empty() ? "0x" : ", 0x") + std::string(color + 1);
    line("array colors[{}] = [{}]", kColorCount, colors);
    line("color(i) = colors[1 + (int(i) - 1) % {}]", kColorCount);
    plot(elements);
  }

  void boxes() {
    Extent y(figure_.y);
    std::string tics;
    std::size_t label_length = 0;
    for (std::size_t i = 0; i < figure_.series.size(); ++i) {
      const Series& series = figure_.series[i];
      const BoxStatistics& box = *series.box;
      for (const double value : {box.q1, box.median, box.q3, box.whisker_low, box.whisker_high})
        y.add(value);
      if (figure_.notches) {
        y.add(box.notch_low);
        y.add(box.notch_high);
      }
      y.add(box.outliers);
      const std::string label = series.label.empty() ? std::to_string(i + 1) : series.label;
      label_length = std::max(label_length, label.size());
      tics += fmt::format("{}{} {}", i > 0 ? ", " : "", tic_label(label), i + 1);
    }
    const std::size_t count = std::max<std::size_t>(figure_.series.size(), 1);
    line("set xrange [0.5:{}.5]", count);
    line("set yrange {}", y.range(y.empty() ? 0.0 : 0.06));
    if (tics.empty())
      line("unset xtics");
    else
      line("set xtics ({}){}", tics, label_length * count > 90 ? " rotate by -30" : "");
    line("set grid noxtics ytics");
    if (y.empty()) return nothing();
    line("half = {}  # half a box' width", 0.25);
    const std::string name = data(".csv", box_csv(figure_));
    std::vector<std::string> elements;
    const auto whisker = [&](int from, int to) {
      elements.push_back(fmt::format(
          "{} skip 1 using 1:{}:(0):(${} - ${}) with vectors nohead dt 2 lw 1 lc rgb \"#262626\"",
          name, from, to, from));
      elements.push_back(
          fmt::format("{} skip 1 using ($1 - half/2):{}:(half):(0) with vectors nohead lw 1 "
                      "lc rgb \"#262626\"",
                      name, to));
    };
    whisker(4, 6);
    whisker(2, 5);
    const std::string look =
        "fc rgb \"#0072bd\" fs transparent solid 0.12 border lc rgb "
        "\"#0072bd\" lw 1.5";
    std::string median_width = "half";
    if (figure_.notches) {
      elements.push_back(fmt::format("{} skip 1 using 1:2 with filledcurves closed {}",
                                     data("-outlines.csv", notch_csv(figure_)), look));
      median_width = "half/2";
    } else {
      elements.push_back(fmt::format(
          "{} skip 1 using 1:3:($1 - half):($1 + half):2:4 with boxxyerror {}", name, look));
    }
    elements.push_back(
        fmt::format("{0} skip 1 using ($1 - {1}):3:(2*{1}):(0) with vectors nohead lw 2 "
                    "lc rgb \"#d95319\"",
                    name, median_width));
    if (has_outliers(figure_))
      elements.push_back(
          fmt::format("{} skip 1 using 1:2 with points pt 1 ps 0.9 lw 1.2 "
                      "lc rgb \"#a2142f\"",
                      data("-outliers.csv", outlier_csv(figure_))));
    plot(elements);
  }

  // Labels of tics are also format strings.
  static std::string tic_label(const std::string& label) {
    std::string doubled;
    for (const char c : label) doubled += c == '%' ? std::string("%%") : std::string(1, c);
    return gnuplot_string(doubled);
  }

  void histograms() {
    Extent x(figure_.x), y(figure_.y);
    x.add(figure_.bins->edges);
    double most = 0.0;
    for (const Series& series : figure_.series) {
      y.add(series.counts);
      for (std::size_t i = 0; i < series.counts.size(); ++i)
        if (drawable(figure_.bins->edges[i]) && drawable(figure_.bins->edges[i + 1]))
          most = std::max(most, series.counts[i]);
    }
    line("set xrange {}", x.range());
    line("set yrange {}", most == 0.0 ? (figure_.y.log ? "[1:10]" : "[0:1]") : y.range_from_zero());
    line("set grid noxtics ytics");
    if (x.empty() || most == 0.0) return nothing();
    const std::string name = data(".csv", histogram_csv(figure_));
    std::vector<std::string> elements;
    for (std::size_t i = 0; i < figure_.series.size(); ++i)
      elements.push_back(fmt::format(
          "{} skip 1 using (($1 + $2)/2):{}:($2 - $1) with boxes fc rgb \"{}\" fs transparent "
          "solid {} border lc rgb \"#404040\" lw 0.8 {}",
          name, i + 3, kColors[i % kColorCount], figure_.series.size() > 1 ? 0.45 : 0.7, title(i)));
    plot(elements);
  }

  void surface() {
    Extent x(figure_.x), y(figure_.y), z(figure_.z);
    SurfaceData tiles;
    if (!figure_.series.empty()) {
      tiles = surface_data(figure_, *figure_.series[0].grid);
      x.add(tiles.x);
      y.add(tiles.y);
      z.add(tiles.heights);
    }
    line("set zlabel {} rotate parallel", gnuplot_string(axis_title(figure_.z)));
    line("set xrange {}", x.range());
    line("set yrange {}", y.range());
    line("set zrange {}", z.range());
    // Labels along slanted axes need more space than gnuplot provides.
    for (const auto& [axis, extent] : {std::pair{'x', &x}, std::pair{'y', &y}})
      if (const double step = extent->tic_step(); step > 0.0) line("set {}tics {}", axis, step);
    line("set view 55, 322");
    line("set xyplane relative 0");
    line("set border 895 ls 1000 lw 0.5");
    line("set xtics offset 0,-0.3\nset ytics offset 0,-0.4");
    line("set grid x y z back ls 1001");
    line("set xlabel rotate parallel\nset ylabel rotate parallel");
    if (tiles.csv.empty()) {
      line("unset colorbox");
      return nothing("splot");
    }
    line("set cbrange {}", z.range());
    // Viridis (CC0), about every sixteenth colour.
    line(
        "set palette defined (0 \"#440154\", 1 \"#482878\", 2 \"#3e4989\", 3 \"#31688e\", "
        "4 \"#26828e\", 5 \"#1f9e89\", 6 \"#35b779\", 7 \"#6ece58\", 8 \"#b5de2b\", "
        "9 \"#fde725\")");
    line("set pm3d depthorder corners2color mean border lc rgb \"#303030\" lw 0.4");
    data("-cells.csv", tiles.cells_csv);
    plot({data(".csv", tiles.csv) + " skip 1 using 1:2:3:4 with pm3d notitle"}, "splot");
  }

  const Figure& figure_;
  const std::string& stem_;
  const std::string& format_;
  const DrawOptions& options_;
  std::string script_;
  GnuplotJob job_;
};

}  // namespace

GnuplotJob gnuplot_job(const Figure& figure, const std::string& stem, const std::string& format,
                       const DrawOptions& options) {
  return Writer(figure, stem, format, options).write();
}

}  // namespace cogrsim::figures
