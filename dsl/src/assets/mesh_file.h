// Triangle meshes and height grids from files.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/model/shapes.h"

namespace cogrsim::dsl {

inline constexpr std::size_t kMaxMeshVertices = 2'000'000;
inline constexpr std::size_t kMaxMeshTriangles = 4'000'000;
inline constexpr std::size_t kMaxHeightSamples = 4'000'000;

/// Errors: the file cannot be read, or has more than `limit` bytes.
Result<std::string> read_whole_file(const std::string& path, std::size_t limit);

/// Wavefront OBJ: `v`, `vt` and `f` (polygons are cut into fans, negative indices count backwards).
/// Faces without texture coordinates among others that have them show the picture's corner (0, 0).
/// Normals are checked and skipped, groups and materials skipped: the orientation of the surface
/// follows from its corners. Errors name the line: a bad number, an index out of range, corners
/// with and without texture coordinates in one face, free-form surfaces, no triangle at all, too
/// many.
Result<TriangleMesh> parse_obj(std::string_view text);

/// A mesh as OBJ, its numbers in full.
std::string obj_text(const TriangleMesh& mesh);

/// STL, ASCII or binary; distinguished by length, since binary files may begin with "solid" too.
/// Equal vertices become one. Errors name the line or the triangle.
Result<TriangleMesh> parse_stl(std::string_view bytes);

/// COLLADA 1.4: the triangles of the visual scene, in metres by its <unit>. The up axis is not applied,
/// as in ROS. Errors name the line or what is wrong.
Result<TriangleMesh> parse_collada(const std::string& bytes);

/// A mesh, and what else its file says.
struct LoadedMesh {
  TriangleMesh mesh;
  std::vector<std::string> files;  ///< canonical paths of others that it was read from
  std::optional<Color> color;      ///< of its material, of glTF only
  std::string differs;             ///< what of its appearance is not read, of glTF only
};

/// glTF 2.0, as text or as GLB: the triangles of its scene, y up turned to z up, equal positions made one.
/// Buffers are in the file, in Base64, or files of `folder` (empty: none) or below it. No more than
/// `max_bytes` are held of the file and its buffers. Errors: what of the file is wrong, or needs an
/// extension that is not read, such as a compression.
Result<LoadedMesh> parse_gltf(std::string_view bytes, const std::string& folder,
                              std::size_t max_bytes);

/// Whether a file is glTF, by its ending.
bool is_gltf(const std::string& path);

/// The file formats of meshes, as messages name them.
inline constexpr const char* kMeshFormats = ".obj, .stl, .dae, .gltf and .glb";

/// By the ending of `path`, one of kMeshFormats. `name` becomes the mesh's name. No more than `max_bytes`
/// are ever held of the file.
Result<LoadedMesh> read_mesh(const std::string& path, const std::string& name,
                             std::size_t max_bytes);

/// The mesh of read_mesh() alone.
Result<TriangleMesh> load_mesh(const std::string& path, const std::string& name,
                               std::size_t max_bytes);

/// The work of holding a mesh beyond the `bytes` of its file, in the units of kMostWork: two for each
/// byte, so that one budget is some 250 MB. Most files are larger than what is made of them.
std::size_t work_beyond(const TriangleMesh& mesh, std::size_t bytes);

/// Number of edges that do not have exactly one partner in the other direction; 0: the surface is
/// closed and consistently wound, so that it has a volume.
std::size_t open_edges(const TriangleMesh& mesh);

/// A grid of heights. Either a PGM picture (P2 or P5, 8 or 16 bits), whose white is 1, or lines of
/// numbers with as many in each line ('#' begins a comment). The first row is the one with the
/// largest y, as on a map. `height` [m] multiplies every sample. Errors name the line.
Result<HeightGrid> parse_heightmap(std::string_view bytes, double size_x, double size_y,
                                   double height);

/// parse_heightmap() of a file.
Result<HeightGrid> load_heightmap(const std::string& path, const std::string& name, double size_x,
                                  double size_y, double height, std::size_t max_bytes);

}  // namespace cogrsim::dsl
