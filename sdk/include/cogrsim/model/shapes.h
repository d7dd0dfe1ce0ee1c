// Geometry, materials and appearance of bodies.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/export.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/core/types.h"

namespace cogrsim {

/// How one coefficient of a pair of materials is made of theirs, a and b. Where the two materials
/// say different rules, the later one in this list holds; `usual` says none.
enum class CombineRule {
  usual,      ///< that of the other material; of both: see surface_pair()
  geometric,  ///< sqrt(a*b)
  average,    ///< (a + b)/2
  min,        ///< the smaller one
  multiply,   ///< a*b
  max         ///< the larger one
};
/// In the order of CombineRule, as the scene language has them; the first is empty.
inline constexpr std::string_view kCombineRuleNames[] = {"",    "geometric", "average",
                                                         "min", "multiply",  "max"};

/// Physical and visual properties of a shape. A shape that overrides one property gets a material
/// of its own (see `base`), so that a backend needs only one material index per shape.
struct Material {
  std::string name;          ///< empty for the material of an override or a default
  int base = -1;             ///< named material it is derived from; -1: none
  double density = 1000.0;   ///< [kg/m^3], > 0
  double friction = 0.5;     ///< Coulomb coefficient, >= 0
  /// Largest torque of a contact point per normal force, against rolling (about an axis in the
  /// tangent plane) and against spinning (about the normal) [m], >= 0.
  double rolling_friction = 0.0, spinning_friction = 0.0;
  double restitution = 0.0;  ///< coefficient of restitution, 0 to 1
  CombineRule friction_combine = CombineRule::usual, restitution_combine = CombineRule::usual;
  std::optional<double> stiffness;  ///< of a contact point [N/m]; empty: as stiff as possible
  Color color;
  std::string texture;  ///< resolved path of an image that is multiplied by `color`; empty: none
  /// Size of one copy of the texture along u and v [m]; empty: see cogrsim/model/surface.h.
  std::optional<Eigen::Vector2d> texture_size;
  std::map<std::string, Parameters> engine_options;  ///< by engine name: `<NAME …/>` inside it
  SourceSpan origin;
};

/// Contact properties of a pair of materials that replace the general rule, see surface_pair().
struct MaterialPair {
  int a = -1, b = -1;  ///< named materials
  std::optional<double> friction;
  std::optional<double> rolling_friction, spinning_friction;
  std::optional<double> restitution;
  SourceSpan origin;
};

/// A triangle mesh. The triangles run counter-clockwise seen from outside; the vertices are in the
/// frame of the shape [m].
struct TriangleMesh {
  std::string name;  ///< file that it was read from
  std::vector<Vec3> vertices;
  std::vector<Eigen::Vector3i> triangles;
  /// Texture coordinates (3 x ntriangle), one per corner in the order of the triangles; empty:
  /// none.
  std::vector<Eigen::Vector2d> uv;
};

/// Heights over a regular grid that is centred on the origin of the shape; x increases with the
/// column, y with the row. Every cell consists of two triangles that share the diagonal from its
/// lowest x and y to its highest. Cell k = row (columns - 1) + column consists of triangle 2k below
/// and triangle 2k + 1 above this diagonal.
struct HeightGrid {
  std::string name;
  int columns = 0, rows = 0;      ///< numbers of samples, each at least 2
  double size_x = 1, size_y = 1;  ///< extent of the whole grid [m]
  std::vector<double> heights;    ///< [m], (rows x columns), row 0 at the lowest y
};

/// Models share meshes and height grids, which never change; never null in a model.
using MeshPtr = std::shared_ptr<const TriangleMesh>;
using HeightGridPtr = std::shared_ptr<const HeightGrid>;

/// Whether both are the same object, or equal in name and in every number.
COGRSIM_API bool same_geometry(const MeshPtr& a, const MeshPtr& b);
COGRSIM_API bool same_geometry(const HeightGridPtr& a, const HeightGridPtr& b);

/// A convex_mesh is drawn as its mesh and collides as its convex hull. A plane is the half-space
/// z <= 0 of the shape's frame.
enum class ShapeType { box, sphere, cylinder, capsule, plane, convex_mesh, mesh, heightmap };

/// "box", "sphere", …, "convex-mesh".
COGRSIM_API const char* to_string(ShapeType type);

/// One shape of a body, in its own frame S.
struct Shape {
  std::string name;  ///< dotted, unique in the scene
  ShapeType type = ShapeType::box;
  Pose X_BS;                 ///< pose in the body
  Vec3 size = Vec3::Ones();  ///< box: full extents [m]
  double radius = 0.5;       ///< sphere, cylinder, capsule [m]
  double length = 1.0;       ///< cylinder, capsule (without its caps): along z of S [m]
  int mesh = -1;             ///< index into SceneModel::meshes, for convex_mesh and mesh
  int heightmap = -1;        ///< index into SceneModel::heightmaps
  int material = 0;          ///< index into SceneModel::materials
  /// Velocity of the surface against its body, in S [m/s], as of a conveyor belt: friction acts
  /// against the sliding of the surfaces. Its part along the normal of a contact has no effect.
  Vec3 surface_velocity = Vec3::Zero();
  bool collides = true;
  bool visible = true;
  SourceSpan origin;
};

}  // namespace cogrsim
