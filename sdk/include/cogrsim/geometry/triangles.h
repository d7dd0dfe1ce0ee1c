// The triangles of meshes and heightmaps. All functions are pure.
#pragma once

#include <array>

#include "cogrsim/geometry/bounds.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::geometry {

using Triangle = std::array<Vec3, 3>;

inline Bounds bounds_of(const Triangle& triangle) {
  Bounds out;
  for (const Vec3& corner : triangle) out.add(corner);
  return out;
}

inline Triangle triangle(const TriangleMesh& mesh, std::size_t index) {
  const Eigen::Vector3i& t = mesh.triangles[index];
  const auto vertex = [&](int i) { return mesh.vertices[i]; };
  return {vertex(t[0]), vertex(t[1]), vertex(t[2])};
}

/// The point of a grid's sample, in the shape's frame [m].
inline Vec3 sample_point(const HeightGrid& grid, int row, int column) {
  return {grid.size_x * (static_cast<double>(column) / (grid.columns - 1) - 0.5),
          grid.size_y * (static_cast<double>(row) / (grid.rows - 1) - 0.5),
          grid.heights[static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) +
                       static_cast<std::size_t>(column)]};
}

/// The triangles of a grid's cells that may lie over or in `where`, in the shape's frame; of a cell
/// the lower one first, see HeightGrid.
template <class Use>
void for_triangles(const HeightGrid& grid, const Bounds& where, const Use& use) {
  if (!(where.low.array() <= where.high.array()).all()) return;
  // One cell more on each side than rounding can need; outside of the grid there are none.
  const auto range = [](double low, double high, double size, int samples) {
    const int cells = samples - 1;
    const auto cell = [&](double at) {
      return static_cast<int>(std::clamp((at / size + 0.5) * cells, -2.0, cells + 1.0));
    };
    return std::pair(std::max(cell(low) - 1, 0), std::min(cell(high) + 1, cells - 1));
  };
  const auto [left, right] = range(where.low.x(), where.high.x(), grid.size_x, grid.columns);
  const auto [bottom, top] = range(where.low.y(), where.high.y(), grid.size_y, grid.rows);
  for (int row = bottom; row <= top; ++row)
    for (int column = left; column <= right; ++column) {
      const Vec3 a = sample_point(grid, row, column), b = sample_point(grid, row, column + 1),
                 c = sample_point(grid, row + 1, column + 1),
                 d = sample_point(grid, row + 1, column);
      use(Triangle{a, b, c});
      use(Triangle{a, c, d});
    }
}

/// Everywhere.
inline Bounds all_bounds() { return {Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity)}; }

/// Those of a shape that is a mesh or a heightmap.
template <class Use>
void for_triangles(const SceneModel& model, const Shape& shape, const Bounds& where,
                   const Use& use) {
  if (shape.type == ShapeType::heightmap)
    return for_triangles(*model.heightmaps[shape.heightmap], where, use);
  const TriangleMesh& mesh = *model.meshes[shape.mesh];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) use(triangle(mesh, i));
}

/// All of them: 2k and 2k + 1 are those of the cell k, counted along the rows.
COGRSIM_API TriangleMesh triangles_of(const HeightGrid& grid);

/// Ground height at (x, y) [m] in the shape's frame, on the cell's triangle; -infinity beyond the
/// edge.
COGRSIM_API double ground_height(const HeightGrid& grid, double x, double y);

}  // namespace cogrsim::geometry
