// Triangles of one mesh or heightmap, shared by all shapes that show it.
#pragma once

#include <limits>

#include "cogrsim/model/shapes.h"
#include "rays/box_tree.h"

namespace cogrsim::rays {

class TriangleSet {
 public:
  TriangleSet(const TreeDevice& device, MeshPtr mesh);

  struct Hit {
    double distance = std::numeric_limits<double>::infinity();
    int triangle = -1;
  };
  /// The nearest hit between `from` and `to`, both included; of hits at the same distance the
  /// triangle with the lowest number. Neighbours share their edge: no ray gets through between
  /// them.
  Hit nearest(const Vec3& origin, const Vec3& direction, double from, double to) const;

  /// Unit, from the side on which the corners run counter-clockwise.
  Vec3 normal(int triangle) const;

  const geometry::Bounds& box() const { return box_; }

 private:
  MeshPtr mesh_;
  geometry::Bounds box_;
  BoxTree tree_;
};

}  // namespace cogrsim::rays
