// What a body looks like and what it is made of.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/export.h"
#include "cogrsim/core/types.h"

namespace cogrsim {

/// Matter and looks. A shape that overrides one property gets a material of its own (see `base`),
/// so that a backend needs to look at one index only.
struct Material {
  std::string name;          ///< empty for one made by an override or a default
  int base = -1;             ///< the named material it was made from; -1: none, or itself named
  double density = 1000.0;   ///< [kg/m^3], > 0
  double friction = 0.5;     ///< Coulomb coefficient, >= 0
  double restitution = 0.0;  ///< coefficient of restitution, 0 to 1
  std::optional<double> stiffness;  ///< of a contact point [N/m]; empty: as stiff as the engine can
  Color color;
  std::string texture;  ///< file path, resolved; empty: none. Multiplied by `color`
  /// Extent of one copy of the texture along u and v [m]; empty: see cogrsim/model/surface.h.
  std::optional<Eigen::Vector2d> texture_size;
  SourceSpan origin;
};

/// What holds for a pair of materials whatever the general rule says.
struct MaterialPair {
  int a = -1, b = -1;  ///< named materials
  std::optional<double> friction;
  std::optional<double> restitution;
  SourceSpan origin;
};

/// Triangles, counter-clockwise seen from outside. Vertices in the shape's frame [m].
struct TriangleMesh {
  std::string name;  ///< file it came from
  std::vector<Vec3> vertices;
  std::vector<Eigen::Vector3i> triangles;
  /// Texture coordinates (3 x ntriangle), three to a triangle in its order; empty: the file has
  /// none.
  std::vector<Eigen::Vector2d> uv;
};

/// Heights over a regular grid, centred on the shape's origin, x to the right, y up the rows. Every
/// cell is two triangles that share the diagonal from its lowest x and y to its highest. Cell
/// k = row (columns - 1) + column is made of the triangles 2k, below, and 2k + 1, above the line
/// from its lower left to its upper right sample.
struct HeightGrid {
  std::string name;
  int columns = 0, rows = 0;      ///< samples, each at least 2
  double size_x = 1, size_y = 1;  ///< whole extent [m]
  std::vector<double> heights;    ///< [m], (rows x columns), row 0 at the lowest y
};

/// A convex_mesh looks like its mesh and is touched as the convex hull of it.
enum class ShapeType { box, sphere, cylinder, capsule, plane, convex_mesh, mesh, heightmap };

/// "box", "sphere", …, "convex-mesh".
COGRSIM_API const char* to_string(ShapeType type);

/// One piece of a body's geometry, in the frame S of its own.
struct Shape {
  std::string name;  ///< dotted, unique in the scene
  ShapeType type = ShapeType::box;
  Pose X_BS;                 ///< in the body
  Vec3 size = Vec3::Ones();  ///< box: full extents [m]
  double radius = 0.5;       ///< sphere, cylinder, capsule [m]
  double length = 1.0;       ///< cylinder: whole, capsule: without caps; along S's z [m]
  int mesh = -1;             ///< SceneModel::meshes, of convex_mesh and mesh
  int heightmap = -1;        ///< SceneModel::heightmaps
  int material = 0;          ///< SceneModel::materials
  bool collides = true;
  bool visible = true;
  SourceSpan origin;
  // A plane is the half-space z <= 0 of S.
};

}  // namespace cogrsim
