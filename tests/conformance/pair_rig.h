// Shapes that can be set on each other, with the heights at which they touch.
#pragma once

#include "support.h"

namespace conformance {

/// One shape in one posture, its body frame's origin in the middle.
struct Piece {
  std::string name;  ///< "cylinder (lying)"
  ShapeType type = ShapeType::box;
  Quat q = Quat(1, 0, 0, 0);  ///< of the body
  double below = 0.0;         ///< lowest point under the origin [m]
  double above = 0.0;         ///< highest point over the origin [m]
  bool flat = false;          ///< others stand on it without being guided
  bool mobile = false;        ///< may have mass
};

std::vector<Piece> pieces();

/// Adds the piece with its origin at `p`; mass 0: static.
int add_piece(ModelBuilder& builder, const Piece& piece, const std::string& name, double mass,
              const Vec3& p, int material);

/// Prism of six corners of `radius` [m], `height` [m], along z, centred.
TriangleMesh hexagonal_prism(double radius, double height);

/// Square grid of `cells` x `cells` over `size` [m] whose height is `height(x, y)`; every square is
/// cut into two triangles, seen from above counter-clockwise.
TriangleMesh grid_mesh(double size, int cells, const std::function<double(double, double)>& height);

/// The same surface as a heightmap.
HeightGrid grid_heights(double size, int cells,
                        const std::function<double(double, double)>& height);

}  // namespace conformance
