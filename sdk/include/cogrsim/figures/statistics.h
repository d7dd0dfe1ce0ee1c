// The numbers behind figures: quantiles, boxes, bins, cells. Values that are not finite are left
// out and counted; no samples, one sample and constant samples are all fine.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"

namespace cogrsim::figures {

/// The `p` quantile, 0 <= p <= 1, as Matlab's quantile() and prctile() define it by default
/// (Hyndman and Fan 1996, definition 5): the k-th of n sorted samples is the (k - 0.5)/n quantile,
/// between them it is linear, beyond the first and the last it is constant.
/// `sorted`: ascending, finite. NaN when there are none.
COGRSIM_API double quantile(const std::vector<double>& sorted, double p);

/// 1, 2 or 5 times a power of ten: the one nearest to `width`, > 0, by ratio.
COGRSIM_API double rounded_step(double width);

/// What a box plot draws, as Matlab's boxplot documents it: the box from the first to the third
/// quartile with the median in it; whiskers to the most extreme samples within
/// `whisker` * (q3 - q1) of the box (and never inside it); all beyond them are outliers.
struct BoxStatistics {
  std::size_t count = 0;    ///< samples used
  std::size_t omitted = 0;  ///< samples that were not finite
  double q1, median, q3;    ///< NaN when count is 0, as all below
  double whisker_low, whisker_high;
  /// Of the notch, median -+ 1.57 (q3 - q1) / sqrt(count): medians whose notches do not overlap
  /// differ at the 5 % level (McGill, Tukey and Larsen 1978).
  double notch_low, notch_high;
  double mean;
  std::vector<double> outliers;  ///< ascending
  std::string method;            ///< how it was computed, in words
};
COGRSIM_API BoxStatistics box_statistics(const std::vector<double>& samples, double whisker = 1.5);

enum class BinRule {
  automatic,         ///< Scott's, or one bin per integer for few different whole numbers
  scott,             ///< width 3.5 s / n^(1/3), s the standard deviation
  freedman_diaconis  ///< width 2 (q3 - q1) / n^(1/3)
};

/// Edges of a histogram's bins, ascending, one more than bins; empty without finite samples.
struct Bins {
  std::vector<double> edges;
  std::string method;
};

/// Bins for all finite samples. The rule's width, as Matlab's histogram documents it, is rounded to
/// 1, 2 or 5 times a power of ten and edges are multiples of it. A width of zero (half of the
/// samples equal) falls back from freedman_diaconis to scott; constant samples get one bin. There
/// are at most 1000 bins.
COGRSIM_API Bins histogram_bins(std::vector<double> samples, BinRule rule = BinRule::automatic);

/// How many finite samples lie in each bin; a bin owns its lower edge, the last one both.
COGRSIM_API std::vector<double> bin_counts(const std::vector<double>& samples,
                                           const std::vector<double>& edges);

/// Scattered samples gathered on a grid of `columns` x `rows` equal cells.
struct Grid {
  std::vector<double> x, y;    ///< centres of columns and rows
  std::vector<double> z;       ///< mean per cell, row after row from the lowest y; NaN: empty
  std::vector<double> counts;  ///< samples per cell, likewise
  std::string method;
};

/// Triples with a value that is not finite are left out. 0 columns or rows: as many as give cells
/// about 4 samples each, from 4 to 40; but samples that stand again and again (4 times each, on
/// average) on 2 to 40 equally spaced lines get one line of cells each.
COGRSIM_API Grid grid_means(const std::vector<double>& x, const std::vector<double>& y,
                            const std::vector<double>& z, int columns = 0, int rows = 0);

}  // namespace cogrsim::figures
