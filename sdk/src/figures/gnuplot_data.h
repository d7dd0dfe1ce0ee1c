// The data files that gnuplot reads: CSV with one line of column names.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "cogrsim/figures/figure.h"

namespace cogrsim::figures {

/// gnuplot computes with extents of axes: beyond these bounds they would overflow.
inline bool drawable(double value) { return std::fabs(value) < 1e300; }
/// Also above 0 where the axis is logarithmic.
bool point_drawable(const Figure& figure, double x, double y);

/// x, y and, where there are points between two gaps, a column that repeats the y of just those.
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

/// A cell is drawn as a tile: its colour is the cell's value, a corner is as high as the cells
/// around it are on average, so that neighbours meet and a cell without neighbours still shows.
struct SurfaceData {
  std::string csv;                    ///< x, y, height, value at four corners per tile; or empty
  std::string cells_csv;              ///< x, y, value, samples per cell
  std::vector<double> x, y, heights;  ///< of all corners of tiles
};
SurfaceData surface_data(const Figure& figure, const Grid& grid);

}  // namespace cogrsim::figures
