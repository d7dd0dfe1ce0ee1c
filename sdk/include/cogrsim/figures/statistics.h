// Statistics for figures: quantiles, box plots, bins and cells. Values that are not finite are
// omitted and counted. No samples, a single sample and constant samples are valid input.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"

namespace cogrsim::figures {

/// The p-quantile, 0 <= p <= 1, with the default definition of quantile() and prctile() in Matlab
/// (Hyndman and Fan 1996, definition 5): the k-th of n sorted samples is the (k - 0.5)/n quantile,
/// with linear interpolation between samples and constant values beyond the first and the last.
/// `sorted` must be ascending and finite. NaN without samples.
COGRSIM_API double quantile(const std::vector<double>& sorted, double p);

/// The number of the form 1, 2 or 5 times a power of ten with the ratio to `width` > 0 closest to
/// 1.
COGRSIM_API double rounded_step(double width);

/// Statistics of a box plot as in boxplot() of Matlab: the box extends from the first to the third
/// quartile and contains the median; the whiskers extend to the most extreme samples within
/// `whisker` * (q3 - q1) of the box (never inside it); samples beyond the whiskers are outliers.
struct BoxStatistics {
  std::size_t count = 0;    ///< samples used
  std::size_t omitted = 0;  ///< samples that were not finite
  double q1, median, q3;    ///< these and all following numbers are NaN if `count` is 0
  double whisker_low, whisker_high;
  /// Ends of the notch, median -+ 1.57 (q3 - q1) / sqrt(count). Medians whose notches do not
  /// overlap differ at a significance level of 5 % (McGill, Tukey and Larsen 1978).
  double notch_low, notch_high;
  double mean;
  std::vector<double> outliers;  ///< ascending
  std::string method;            ///< description of the computation
};
COGRSIM_API BoxStatistics box_statistics(const std::vector<double>& samples, double whisker = 1.5);

/// Rule for the width of the bins of a histogram.
enum class BinRule {
  automatic,         ///< scott, or one bin per integer for samples with few different integers
  scott,             ///< width 3.5 s / n^(1/3), s the standard deviation
  freedman_diaconis  ///< width 2 (q3 - q1) / n^(1/3)
};

/// Bins of a histogram.
struct Bins {
  std::vector<double> edges;  ///< ascending, one more than the number of bins; empty: no samples
  std::string method;         ///< description of the computation
};

/// Computes bins for all finite samples. The width of the rule, as in histogram() of Matlab, is
/// rounded to 1, 2 or 5 times a power of ten, and the edges are multiples of it. If
/// freedman_diaconis gives a width of zero (half of the samples are equal), scott is used; constant
/// samples get one bin. The number of bins is at most 1000.
COGRSIM_API Bins histogram_bins(std::vector<double> samples, BinRule rule = BinRule::automatic);

/// Number of finite samples in each bin; a bin includes its lower edge, and the last bin both
/// edges.
COGRSIM_API std::vector<double> bin_counts(const std::vector<double>& samples,
                                           const std::vector<double>& edges);

/// Means of scattered samples on a grid of equal cells.
struct Grid {
  std::vector<double> x, y;    ///< centres of the columns and rows
  std::vector<double> z;       ///< mean per cell (rows x columns), lowest y first; NaN: no samples
  std::vector<double> counts;  ///< number of samples per cell (rows x columns)
  std::string method;          ///< description of the computation
};

/// Computes the means of samples z at (x, y) on a grid. Samples with a non-finite value are
/// omitted. For 0 columns or rows the number is chosen so that a cell has about 4 samples, from 4
/// to 40. If the samples repeatedly (4 times each on average) have 2 to 40 equally spaced
/// coordinates, each of these coordinates gets its own column or row.
COGRSIM_API Grid grid_means(const std::vector<double>& x, const std::vector<double>& y,
                            const std::vector<double>& z, int columns = 0, int rows = 0);

}  // namespace cogrsim::figures
