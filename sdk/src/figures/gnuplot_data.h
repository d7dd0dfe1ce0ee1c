// Data files for gnuplot: CSV with one line of column names.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "cogrsim/figures/figure.h"

namespace cogrsim::figures {

/// Limits of drawable values; beyond them the computation of axis ranges in gnuplot overflows.
inline bool drawable(double value) { return std::fabs(value) < 1e300; }
/// Whether a value can be drawn; on a logarithmic axis it must also be above 0.
bool point_drawable(const Figure& figure, double x, double y);

/// x, y and, if there are single points between two gaps, a column with the y of those points.
struct PathData {
  std::string csv;
  std::size_t isolated = 0;
};
PathData path_data(const Figure& figure, const Series& series);

/// Number, q1, median, q3, whisker low and high, notch low and high, samples, mean, label.
std::string box_csv(const Figure& figure);
std::string outlier_csv(const Figure& figure);
/// Outlines of notched boxes.
std::string notch_csv(const Figure& figure);
bool has_outliers(const Figure& figure);

/// Lower and upper edge of a bin, then the counts of each series.
std::string histogram_csv(const Figure& figure);

/// A cell is drawn as a tile with the colour of its value. The height of a corner is the mean of
/// the adjacent cells, so that neighbouring tiles join and a cell without neighbours is visible.
struct SurfaceData {
  std::string csv;                    ///< x, y, height, value at four corners per tile; or empty
  std::string cells_csv;              ///< x, y, value, samples per cell
  std::vector<double> x, y, heights;  ///< of all corners of tiles
};
SurfaceData surface_data(const Figure& figure, const Grid& grid);

}  // namespace cogrsim::figures
