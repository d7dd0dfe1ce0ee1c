// How a texture lies on a shape: one rule for pictures, rays and sensors.
//
// u runs to the right and v upwards on the surface seen from outside; the picture's bottom left
// corner is (0, 0), its top right corner (1, 1), and it repeats beyond. Without a
// `Material::texture_size` the middle column holds, with one (U, V) [m] the right one; there u and
// v are lengths along the surface divided by it. W is the whole extent of a face along u, H along
// v; a and b are the coordinates of the point along u and v, from the middle of the face; x, y, z
// those in the shape's frame; r and l its radius and length; phi = atan2(y, x), -pi to pi.
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
// lat is the sphere's latitude asin(z/r). s is the capsule's height along its middle line: z on the
// straight part, beyond it the arc length on the ends, +-(l/2 + r asin((|z| - l/2)/r)).
//
// Faces of a box, caps of a cylinder, and the side from which a mesh without coordinates is looked
// at go by the largest component of the outward normal (of a mesh: of the flat triangle); z wins
// over y over x where two are equal. Their directions of u and v are
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

/// (u, v) at `point` (on the surface, shape's frame [m]) with outward unit `normal` there. For a
/// mesh with coordinates of its own `triangle` says in which one the point lies; -1: unknown, which
/// gives what a mesh without any has.
COGRSIM_API Vec2 texture_coordinates(const SceneModel& model, const Shape& shape, const Vec3& point,
                                     const Vec3& normal, int triangle = -1);

/// The pictures a model's materials name, each read once and shared by all who ask.
class COGRSIM_API TextureStore {
 public:
  /// nullptr: the material has none. A file that cannot be read has been refused by the scene
  /// compiler; if it went away since, the answer is nullptr too and problem() says why. It is not
  /// tried again.
  std::shared_ptr<const Image> texture(const Material& material);
  /// Why the first picture that could not be read could not; empty: all could.
  const std::string& problem() const { return problem_; }

 private:
  std::map<std::string, std::shared_ptr<const Image>> images_;
  std::string problem_;
};

/// Colour of the picture at (u, v): bilinear between the middles of its pixels, repeating;
/// components 0 to 1, sRGB as in the file, opacity 1 where it has none.
COGRSIM_API Color sample(const Image& image, const Vec2& uv);

}  // namespace cogrsim
