#include "cogrsim/figures/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"

namespace cogrsim::figures {
namespace {

constexpr std::size_t kMostBins = 1000;

void keep_finite(std::vector<double>& samples) {
  samples.erase(std::remove_if(samples.begin(), samples.end(),
                               [](double value) { return !std::isfinite(value); }),
                samples.end());
}

// Mean and standard deviation (n - 1), scaled so that no square overflows.
struct Moments {
  double mean = 0.0, deviation = 0.0;
};
Moments moments(const std::vector<double>& samples) {
  double scale = 0.0;
  for (const double value : samples) scale = std::max(scale, std::fabs(value));
  if (samples.empty() || scale == 0.0) return {};
  const auto n = static_cast<double>(samples.size());
  double sum = 0.0;
  for (const double value : samples) sum += value / scale;
  const double mean = sum / n;
  double squares = 0.0;
  for (const double value : samples) squares += (value / scale - mean) * (value / scale - mean);
  return {mean * scale, samples.size() < 2 ? 0.0 : scale * std::sqrt(squares / (n - 1.0))};
}

// Few different integers: each gets its own bin.
bool are_few_integers(const std::vector<double>& sorted) {
  constexpr double kMostIntegers = 50.0;
  return sorted.back() - sorted.front() <= kMostIntegers && std::fabs(sorted.front()) < 1e15 &&
         std::fabs(sorted.back()) < 1e15 &&
         std::all_of(sorted.begin(), sorted.end(),
                     [](double value) { return value == std::floor(value); });
}

std::vector<double> even_edges(double first, double width, std::size_t bins) {
  std::vector<double> edges;
  for (std::size_t i = 0; i <= bins; ++i) edges.push_back(first + static_cast<double>(i) * width);
  return edges;
}

}  // namespace

double rounded_step(double width) {
  const double power = std::pow(10.0, std::floor(std::log10(width)));
  const double digits = width / power;
  const double nice = digits < std::sqrt(2.0)    ? 1.0
                      : digits < std::sqrt(10.0) ? 2.0
                      : digits < std::sqrt(50.0) ? 5.0
                                                 : 10.0;
  return nice * power;
}

double quantile(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) return kNaN;
  assert(p >= 0.0 && p <= 1.0);
  // Position of the quantile among the samples, from 0.
  const double at = p * static_cast<double>(sorted.size()) - 0.5;
  if (at <= 0.0) return sorted.front();
  const auto below = static_cast<std::size_t>(at);
  if (below + 1 >= sorted.size()) return sorted.back();
  const double part = at - static_cast<double>(below);
  // Not a + w (b - a), because the difference of two finite numbers may overflow.
  return sorted[below] * (1.0 - part) + sorted[below + 1] * part;
}

BoxStatistics box_statistics(const std::vector<double>& samples, double whisker) {
  assert(whisker >= 0.0);
  std::vector<double> sorted = samples;
  keep_finite(sorted);
  std::sort(sorted.begin(), sorted.end());
  BoxStatistics box;
  box.count = sorted.size();
  box.omitted = samples.size() - sorted.size();
  box.method = fmt::format(
      "quartiles: linear between (k - 0.5)/n quantiles; whiskers: most extreme samples within {:g} "
      "interquartile ranges of the box; notch: median -+ 1.57 interquartile ranges / sqrt(n)",
      whisker);
  box.q1 = quantile(sorted, 0.25);
  box.median = quantile(sorted, 0.5);
  box.q3 = quantile(sorted, 0.75);
  box.whisker_low = box.whisker_high = box.notch_low = box.notch_high = box.mean = kNaN;
  if (sorted.empty()) return box;

  const double range = box.q3 - box.q1;
  const double low = box.q1 - whisker * range;
  const double high = box.q3 + whisker * range;
  box.whisker_low = box.q1;
  box.whisker_high = box.q3;
  for (const double value : sorted) {
    if (value < low || value > high) {
      box.outliers.push_back(value);
    } else {
      box.whisker_low = std::min(box.whisker_low, value);
      box.whisker_high = std::max(box.whisker_high, value);
    }
  }
  const double notch = 1.57 * range / std::sqrt(static_cast<double>(sorted.size()));
  box.notch_low = box.median - notch;
  box.notch_high = box.median + notch;
  box.mean = moments(sorted).mean;
  return box;
}

Bins histogram_bins(std::vector<double> samples, BinRule rule) {
  keep_finite(samples);
  std::sort(samples.begin(), samples.end());
  Bins bins;
  if (samples.empty()) {
    bins.method = "no samples";
    return bins;
  }
  const double low = samples.front();
  const double high = samples.back();
  const auto one_bin = [&](double width) {
    bins.edges = {low - 0.5 * width, low + 0.5 * width};
    bins.method = "one bin around the constant samples";
    return bins;
  };
  const bool integers = rule == BinRule::automatic && are_few_integers(samples);
  if (integers) {
    bins.edges = even_edges(low - 0.5, 1.0, static_cast<std::size_t>(high - low) + 1);
    bins.method = "one bin per whole number";
    return bins;
  }
  const double root = std::cbrt(static_cast<double>(samples.size()));
  double width = 0.0;
  if (rule == BinRule::freedman_diaconis) {
    width = 2.0 * (quantile(samples, 0.75) - quantile(samples, 0.25)) / root;
    bins.method = "Freedman-Diaconis: width 2 (q3 - q1) / n^(1/3)";
  }
  if (!(width > 0.0)) {
    width = 3.5 * moments(samples).deviation / root;
    bins.method = "Scott: width 3.5 s / n^(1/3)";
  }
  // Samples that differ only by rounding count as constant: bins must be wider than rounding
  // errors.
  const double digit = std::max(std::fabs(low), std::fabs(high)) * 1e-14;
  if (!(high - low > digit)) return one_bin(low == 0.0 ? 1.0 : 0.1 * std::fabs(low));
  if (std::isfinite(width) && width > digit) width = rounded_step(width);
  const double span = high - low;
  const auto count = [&] { return std::ceil(high / width) - std::floor(low / width); };
  if (!(width > digit) || !std::isfinite(span) || !(count() <= kMostBins)) {
    // Distant outliers next to a narrow distribution.
    bins.edges.clear();
    for (std::size_t i = 0; i <= kMostBins; ++i) {
      const double part = static_cast<double>(i) / static_cast<double>(kMostBins);
      bins.edges.push_back(low * (1.0 - part) + high * part);
    }
    bins.edges.back() = high;
    bins.method += fmt::format("; more than {0} bins, so {0} equal ones", kMostBins);
    return bins;
  }
  bins.method += ", rounded to 1, 2 or 5 times a power of ten";
  const double first = std::floor(low / width);
  for (double k = first; k <= first + std::max(1.0, count()); k += 1.0)
    bins.edges.push_back(k * width);
  // Rounding of k * width must not exclude a sample.
  bins.edges.front() = std::min(bins.edges.front(), low);
  bins.edges.back() = std::max(bins.edges.back(), high);
  return bins;
}

std::vector<double> bin_counts(const std::vector<double>& samples,
                               const std::vector<double>& edges) {
  if (edges.size() < 2) return {};
  std::vector<double> counts(edges.size() - 1, 0.0);
  for (const double value : samples) {
    if (!(value >= edges.front() && value <= edges.back())) continue;
    const auto above = std::upper_bound(edges.begin(), edges.end(), value) - edges.begin();
    counts[std::min(static_cast<std::size_t>(above) - 1, counts.size() - 1)] += 1.0;
  }
  return counts;
}

namespace {

// Lower end and cell size of a grid along one axis.
struct Axis1 {
  double low = 0.0, high = 0.0, cell = 1.0;
  int cells = 1;

  Axis1(const std::vector<double>& values, int count) : cells(count) {
    if (values.empty()) return;
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    low = *least;
    high = *most;
    // Computed with halves, because the difference of two finite numbers may overflow.
    cell = (*most / cells - *least / cells);
    if (cell > 1e-14 * std::max(std::fabs(*least), std::fabs(*most))) return;
    // Without extent there is one line of cells of a suitable width.
    cells = 1;
    cell = low == 0.0 ? 1.0 : 0.1 * std::fabs(low);
    low -= 0.5 * cell;
    high = low + cell;
  }
  // Samples on a few equally spaced lines get one line of cells each; cells of any other size would
  // leave empty cells between them.
  static std::optional<Axis1> on_lines(std::vector<double> values) {
    const std::size_t count = values.size();
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    const std::size_t lines = values.size();
    if (lines < 2 || lines > 40 || count < 4 * lines) return std::nullopt;
    const double pitch = values.back() / static_cast<double>(lines - 1) -
                         values.front() / static_cast<double>(lines - 1);
    for (std::size_t i = 0; i < lines; ++i) {
      const double there = values.front() + static_cast<double>(i) * pitch;
      if (!(std::fabs(values[i] - there) < 1e-6 * pitch)) return std::nullopt;
    }
    Axis1 axis({}, static_cast<int>(lines));
    axis.low = values.front() - 0.5 * pitch;
    axis.high = values.back() + 0.5 * pitch;
    axis.cell = pitch;
    return axis;
  }
  std::size_t index(double value) const {
    return static_cast<std::size_t>(
        std::clamp(std::floor(value / cell - low / cell), 0.0, static_cast<double>(cells - 1)));
  }
  std::vector<double> centres() const {
    std::vector<double> all;
    for (int i = 0; i < cells; ++i) {
      const double part = (i + 0.5) / cells;
      all.push_back(low * (1.0 - part) + high * part);
    }
    return all;
  }
};

}  // namespace

Grid grid_means(const std::vector<double>& x, const std::vector<double>& y,
                const std::vector<double>& z, int columns, int rows) {
  const std::size_t n = std::min({x.size(), y.size(), z.size()});
  std::vector<double> xs, ys, zs;
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i]) || !std::isfinite(z[i])) continue;
    xs.push_back(x[i]);
    ys.push_back(y[i]);
    zs.push_back(z[i]);
  }
  const int usual =
      std::clamp(static_cast<int>(std::sqrt(static_cast<double>(xs.size()) / 4.0)), 4, 40);
  const auto axis = [&](const std::vector<double>& values, int count) {
    if (count > 0) return Axis1(values, count);
    return Axis1::on_lines(values).value_or(Axis1(values, usual));
  };
  const Axis1 across = axis(xs, columns), along = axis(ys, rows);
  Grid grid;
  grid.method = fmt::format("mean per cell, {} x {} cells", across.cells, along.cells);
  if (xs.empty()) {
    grid.method = "no samples";
    return grid;
  }
  grid.x = across.centres();
  grid.y = along.centres();
  grid.z.assign(grid.x.size() * grid.y.size(), 0.0);
  grid.counts.assign(grid.z.size(), 0.0);
  for (std::size_t i = 0; i < xs.size(); ++i) {
    const std::size_t cell = along.index(ys[i]) * grid.x.size() + across.index(xs[i]);
    grid.counts[cell] += 1.0;
    // A running mean cannot overflow, in contrast to the sum.
    grid.z[cell] += zs[i] / grid.counts[cell] - grid.z[cell] / grid.counts[cell];
  }
  for (std::size_t i = 0; i < grid.z.size(); ++i)
    if (grid.counts[i] == 0.0) grid.z[i] = kNaN;
  return grid;
}

}  // namespace cogrsim::figures
