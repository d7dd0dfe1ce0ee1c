#include "cogrsim/geometry/triangles.h"

#include <cmath>

namespace cogrsim::geometry {

TriangleMesh triangles_of(const HeightGrid& grid) {
  TriangleMesh out;
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column)
      out.vertices.push_back(sample_point(grid, row, column));
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const int low = row * grid.columns + column, high = low + grid.columns;
      out.triangles.emplace_back(low, low + 1, high + 1);
      out.triangles.emplace_back(low, high + 1, high);
    }
  }
  return out;
}

double ground_height(const HeightGrid& grid, double x, double y) {
  const double u = (x / grid.size_x + 0.5) * (grid.columns - 1);
  const double v = (y / grid.size_y + 0.5) * (grid.rows - 1);
  if (!(u >= 0.0 && v >= 0.0 && u <= grid.columns - 1 && v <= grid.rows - 1)) return -kInfinity;
  const int column = std::min(static_cast<int>(u), grid.columns - 2);
  const int row = std::min(static_cast<int>(v), grid.rows - 2);
  const auto at = [&](int i, int j) { return sample_point(grid, row + j, column + i).z(); };
  const double s = u - column, t = v - row;
  const double low = at(0, 0), high = at(1, 1);
  // From the lower left sample to the upper right one both triangles agree.
  return s >= t ? low + s * (at(1, 0) - low) + t * (high - at(1, 0))
                : low + t * (at(0, 1) - low) + s * (high - at(0, 1));
}

}  // namespace cogrsim::geometry
