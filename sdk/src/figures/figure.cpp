#include "cogrsim/figures/figure.h"

#include <array>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"

namespace cogrsim::figures {
namespace {

constexpr std::array<const char*, 5> kKinds = {"curve", "box", "histogram", "surface", "map"};

Result<> check_axis(const Axis& axis, const char* name) {
  for (const auto& bound : {axis.minimum, axis.maximum}) {
    if (bound && !std::isfinite(*bound))
      return fail(fmt::format("a bound of the {} axis is not finite", name));
    if (bound && axis.log && *bound <= 0.0)
      return fail(
          fmt::format("the {} axis is logarithmic, so {:g} cannot be a bound", name, *bound), "",
          "give a number above 0");
  }
  if (axis.minimum && axis.maximum && !(*axis.minimum < *axis.maximum))
    return fail(
        fmt::format("the {} axis goes from {:g} to {:g}", name, *axis.minimum, *axis.maximum), "",
        "the lower bound comes first");
  return {};
}

std::string name_of(const Series& series, std::size_t index) {
  return series.label.empty() ? fmt::format("series {}", index + 1)
                              : fmt::format("series '{}'", series.label);
}

Result<> check_series(const Figure& figure, std::size_t index) {
  const Series& series = figure.series[index];
  const bool plane = figure.kind == Kind::curve || figure.kind == Kind::map;
  if (plane && series.x.size() != series.y.size())
    return fail(fmt::format("{} has {} values of x and {} of y", name_of(series, index),
                            series.x.size(), series.y.size()));
  if (figure.kind == Kind::surface && !series.grid &&
      (series.x.size() != series.y.size() || series.x.size() != series.z.size()))
    return fail(fmt::format("{} has {} values of x, {} of y and {} of z", name_of(series, index),
                            series.x.size(), series.y.size(), series.z.size()));
  if (series.grid) {
    const Grid& grid = *series.grid;
    const std::size_t cells = grid.x.size() * grid.y.size();
    if (grid.z.size() != cells || (!grid.counts.empty() && grid.counts.size() != cells))
      return fail(fmt::format("the grid of {} has {} columns and {} rows, but {} values",
                              name_of(series, index), grid.x.size(), grid.y.size(), grid.z.size()));
    for (const auto* positions : {&grid.x, &grid.y})
      for (std::size_t i = 0; i < positions->size(); ++i)
        if (!std::isfinite((*positions)[i]) || (i > 0 && !((*positions)[i - 1] < (*positions)[i])))
          return fail(fmt::format("the positions of the grid's columns and rows must rise ({})",
                                  name_of(series, index)));
  }
  return {};
}

Result<> check_bins(const Figure& figure) {
  const std::vector<double>& edges = figure.bins->edges;
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (!std::isfinite(edges[i]) || (i > 0 && !(edges[i - 1] < edges[i])))
      return fail("the edges of the bins must rise");
  if (edges.size() == 1) return fail("a bin has two edges, found one");
  for (std::size_t i = 0; i < figure.series.size(); ++i) {
    const Series& series = figure.series[i];
    if (!series.counts.empty() && series.counts.size() + 1 != edges.size())
      return fail(fmt::format("{} has {} counts for {} bins", name_of(series, i),
                              series.counts.size(), edges.empty() ? 0 : edges.size() - 1));
  }
  return {};
}

Figure figure_of(Kind kind) {
  Figure figure;
  figure.kind = kind;
  return figure;
}

}  // namespace

const char* to_string(Kind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

Result<Kind> kind_from(const std::string& name) {
  std::string all;
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    if (name == kKinds[i]) return static_cast<Kind>(i);
    all += (i > 0 ? ", " : "") + std::string(kKinds[i]);
  }
  const std::string near = nearest_name(name, {kKinds.begin(), kKinds.end()});
  return fail(fmt::format("there is no figure of kind '{}'", name), "",
              (near.empty() ? "" : "did you mean '" + near + "'? ") + "there are " + all);
}

Series& add_series(Figure& figure, std::vector<double> x, std::vector<double> y,
                   std::string label) {
  Series series;
  series.x = std::move(x);
  series.y = std::move(y);
  series.label = std::move(label);
  figure.series.push_back(std::move(series));
  return figure.series.back();
}

Figure curve(std::vector<double> x, std::vector<double> y, std::string label) {
  Figure figure = figure_of(Kind::curve);
  add_series(figure, std::move(x), std::move(y), std::move(label));
  return figure;
}

Figure map(std::vector<double> x, std::vector<double> y, std::string label) {
  Figure figure = curve(std::move(x), std::move(y), std::move(label));
  figure.kind = Kind::map;
  figure.x = {"x", "m"};
  figure.y = {"y", "m"};
  return figure;
}

Figure box(std::vector<std::vector<double>> groups, std::vector<std::string> labels) {
  Figure figure = figure_of(Kind::box);
  for (std::size_t i = 0; i < groups.size(); ++i)
    add_series(figure, {}, std::move(groups[i]),
               i < labels.size() ? labels[i] : std::to_string(i + 1));
  return figure;
}

Figure histogram(std::vector<double> samples, std::string label, BinRule rule) {
  Figure figure = figure_of(Kind::histogram);
  figure.rule = rule;
  figure.y.label = "count";
  add_series(figure, std::move(samples), {}, std::move(label));
  return figure;
}

Figure surface(std::vector<double> x, std::vector<double> y, std::vector<double> z, int columns,
               int rows) {
  Figure figure = figure_of(Kind::surface);
  figure.columns = columns;
  figure.rows = rows;
  add_series(figure, std::move(x), std::move(y)).z = std::move(z);
  return figure;
}

Figure surface_of(std::vector<double> x, std::vector<double> y, std::vector<double> z) {
  Figure figure = figure_of(Kind::surface);
  Grid grid;
  grid.x = std::move(x);
  grid.y = std::move(y);
  grid.z = std::move(z);
  grid.method = "given";
  add_series(figure, {}, {}).grid = std::move(grid);
  return figure;
}

Result<> complete(Figure& figure) {
  if (const auto good = check_axis(figure.x, "x"); !good) return good;
  if (const auto good = check_axis(figure.y, "y"); !good) return good;
  if (const auto good = check_axis(figure.z, "z"); !good) return good;
  if (figure.kind == Kind::surface && figure.series.size() > 1)
    return fail(fmt::format("a surface shows one series, this one has {}", figure.series.size()));
  for (std::size_t i = 0; i < figure.series.size(); ++i)
    if (const auto good = check_series(figure, i); !good) return good;

  if (figure.kind == Kind::histogram) {
    if (!figure.bins) {
      std::vector<double> all;
      for (const Series& series : figure.series)
        all.insert(all.end(), series.x.begin(), series.x.end());
      figure.bins = histogram_bins(std::move(all), figure.rule);
      for (Series& series : figure.series) series.counts.clear();
    }
    if (const auto good = check_bins(figure); !good) return good;
  }
  for (Series& series : figure.series) {
    if (figure.kind == Kind::box && !series.box)
      series.box = box_statistics(series.y, figure.whisker);
    if (figure.kind == Kind::histogram && series.counts.empty())
      series.counts = bin_counts(series.x, figure.bins->edges);
    if (figure.kind == Kind::surface && !series.grid)
      series.grid = grid_means(series.x, series.y, series.z, figure.columns, figure.rows);
  }
  return {};
}

}  // namespace cogrsim::figures
