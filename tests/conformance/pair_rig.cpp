#include "pair_rig.h"

namespace conformance {
namespace {

constexpr double kHalf = 0.1;   // half height of what stands, radius of what lies
constexpr double kWide = 0.15;  // radius of what stands
constexpr double kLength = 0.3;
constexpr double kPlateTop = 0.05, kTerrainTop = 0.07;

}  // namespace

std::vector<Piece> pieces() {
  const Quat upright(1, 0, 0, 0), lying = z_to(Vec3::UnitY());
  return {
      {"box", ShapeType::box, upright, kHalf, kHalf, true, true},
      {"sphere", ShapeType::sphere, upright, kWide, kWide, false, true},
      {"cylinder (upright)", ShapeType::cylinder, upright, kHalf, kHalf, true, true},
      {"cylinder (lying)", ShapeType::cylinder, lying, kWide, kWide, false, true},
      {"capsule (lying)", ShapeType::capsule, lying, kHalf, kHalf, false, true},
      {"convex mesh", ShapeType::convex_mesh, upright, kHalf, kHalf, true, true},
      {"plane", ShapeType::plane, upright, 0.0, 0.0, true, false},
      {"mesh", ShapeType::mesh, upright, 0.0, kPlateTop, true, false},
      {"heightmap", ShapeType::heightmap, upright, 0.0, kTerrainTop, true, false},
  };
}

int add_piece(ModelBuilder& builder, const Piece& piece, const std::string& name, double mass,
              const Vec3& p, int material) {
  const Pose X_WB(p, piece.q);
  switch (piece.type) {
    case ShapeType::box:
      return builder.box(name, Vec3(kLength, kLength, 2.0 * kHalf), mass, X_WB, material);
    case ShapeType::sphere:
      return builder.sphere(name, kWide, mass, X_WB, material);
    case ShapeType::cylinder:
      return builder.cylinder(name, kWide, piece.flat ? 2.0 * kHalf : kLength, mass, X_WB,
                              material);
    case ShapeType::capsule:
      return builder.capsule(name, kHalf, kLength - 2.0 * kHalf, mass, X_WB, material);
    case ShapeType::convex_mesh:
      return builder.mesh(name, hexagonal_prism(kWide, 2.0 * kHalf), true, mass, X_WB, material);
    case ShapeType::plane:
      return builder.plane(name, X_WB, material);
    case ShapeType::mesh:
      return builder.mesh(name, grid_mesh(2.0, 5, [](double, double) { return kPlateTop; }), false,
                          0.0, X_WB, material);
    case ShapeType::heightmap:
      return builder.heightmap(
          name, grid_heights(2.0, 5, [](double, double) { return kTerrainTop; }), X_WB, material);
  }
  return -1;
}

TriangleMesh hexagonal_prism(double radius, double height) {
  TriangleMesh mesh;
  mesh.name = "hexagonal prism";
  constexpr int kCorners = 6;
  for (const double z : {-0.5 * height, 0.5 * height}) {
    for (int i = 0; i < kCorners; ++i) {
      const double angle = 2.0 * kPi * i / kCorners;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  }
  for (int i = 0; i < kCorners; ++i) {
    const int next = (i + 1) % kCorners;
    mesh.triangles.emplace_back(i, next, kCorners + next);
    mesh.triangles.emplace_back(i, kCorners + next, kCorners + i);
    if (i >= 1 && i + 1 < kCorners) {
      mesh.triangles.emplace_back(0, i + 1, i);                               // bottom
      mesh.triangles.emplace_back(kCorners, kCorners + i, kCorners + i + 1);  // top
    }
  }
  return mesh;
}

TriangleMesh grid_mesh(double size, int cells,
                       const std::function<double(double, double)>& height) {
  TriangleMesh mesh;
  mesh.name = "grid";
  for (int row = 0; row <= cells; ++row) {
    for (int column = 0; column <= cells; ++column) {
      const double x = size * (double(column) / cells - 0.5);
      const double y = size * (double(row) / cells - 0.5);
      mesh.vertices.emplace_back(x, y, height(x, y));
    }
  }
  const int stride = cells + 1;
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      const int corner = row * stride + column;
      mesh.triangles.emplace_back(corner, corner + 1, corner + stride + 1);
      mesh.triangles.emplace_back(corner, corner + stride + 1, corner + stride);
    }
  }
  return mesh;
}

HeightGrid grid_heights(double size, int cells,
                        const std::function<double(double, double)>& height) {
  HeightGrid grid;
  grid.name = "grid";
  grid.columns = grid.rows = cells + 1;
  grid.size_x = grid.size_y = size;
  for (int row = 0; row <= cells; ++row) {
    for (int column = 0; column <= cells; ++column) {
      const double x = size * (double(column) / cells - 0.5);
      const double y = size * (double(row) / cells - 0.5);
      grid.heights.push_back(height(x, y));
    }
  }
  return grid;
}

}  // namespace conformance
