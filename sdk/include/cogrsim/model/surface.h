// Texture mapping of the shapes, the same for rendering, ray casting and sensors.
//
// Seen from outside the surface, u points to the right and v upwards. The bottom left corner of the
// image is (0, 0), its top right corner (1, 1), and the image repeats beyond them. The middle
// column of the table applies without a `Material::texture_size`, the right column with a size (U,
// V) [m]; there u and v are lengths along the surface divided by the size. W and H are the extents
// of a face along u and v; a and b are the coordinates of the point along u and v from the middle
// of the face; x, y, z are its coordinates in the frame of the shape; r and l are the radius and
// length of the shape; phi = atan2(y, x), from -pi to pi.
//
// | shape           | u, v: one copy               | u, v: with a size (U, V)                   |
// |-----------------|------------------------------|--------------------------------------------|
// | box, each face  | a/W + 1/2, b/H + 1/2         | a/U, b/V                                   |
// | sphere          | phi/2pi + 1/2, lat/pi + 1/2  | r phi/U + 1/2, r lat/V + 1/2               |
// | cylinder, side  | phi/2pi + 1/2, z/l + 1/2     | r phi/U + 1/2, (z + l/2)/V                 |
// | cylinder, caps  | a/2r + 1/2, b/2r + 1/2       | a/U, b/V                                   |
// | capsule         | phi/2pi + 1/2, s/l + 1/2     | r phi/U + 1/2, (s + l/2)/V                 |
// | plane           | x, y (a size of 1 m)         | x/U, y/V                                   |
// | heightmap       | x/W + 1/2, y/H + 1/2         | x/U, y/V                                   |
// | mesh, convex    | the file's own               | the file's own                             |
// | ... without own | a, b (a size of 1 m)         | a/U, b/V; a, b from the origin             |
//
// lat is the latitude asin(z/r) of the sphere. s is the height along the outline of the capsule: z
// on the cylindrical part, and the arc length +-(l/2 + r asin((|z| - l/2)/r)) on the caps.
//
// The face of a box, the cap of a cylinder, and the projection direction of a mesh without texture
// coordinates follow from the largest component of the outward normal (for a mesh: the normal of
// the flat triangle); of equal components z precedes y and y precedes x. The directions of u and v
// are
//
// | face | +x  | -x  | +y  | -y  | +z  | -z  |
// |------|-----|-----|-----|-----|-----|-----|
// | u    | +y  | -y  | -x  | +x  | +x  | +x  |
// | v    | +z  | +z  | +z  | +z  | +y  | -y  |
#pragma once

#include <map>
#include <memory>
#include <string>

#include "cogrsim/core/image.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

using Vec2 = Eigen::Vector2d;

/// Texture coordinates (u, v) of a `point` on the surface (in the frame of the shape [m]) with the
/// outward unit `normal`. For a mesh with texture coordinates, `triangle` is the index of the
/// triangle that contains the point; -1 (unknown) gives the coordinates of a mesh without any.
COGRSIM_API Vec2 texture_coordinates(const SceneModel& model, const Shape& shape, const Vec3& point,
                                     const Vec3& normal, int triangle = -1);

/// Cache of the texture images of a model; each file is read once. Not thread-safe.
class COGRSIM_API TextureStore {
 public:
  /// The image of a material, or nullptr if it has none or the file cannot be read. The scene
  /// compiler rejects unreadable files, so that occurs only if a file has disappeared since;
  /// problem() then states the reason, and the file is not read again.
  std::shared_ptr<const Image> texture(const Material& material);
  /// The error of the first file that could not be read; empty: none.
  const std::string& problem() const { return problem_; }

 private:
  std::map<std::string, std::shared_ptr<const Image>> images_;
  std::string problem_;
};

/// Colour of the image at (u, v): bilinear interpolation between the pixel centres, with
/// repetition. The components are between 0 and 1, in sRGB as in the file; the opacity is 1 if the
/// image has no alpha channel.
COGRSIM_API Color sample(const Image& image, const Vec2& uv);

}  // namespace cogrsim
