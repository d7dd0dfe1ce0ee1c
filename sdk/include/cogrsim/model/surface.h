// How a texture lies on a shape: one rule for pictures, rays and sensors.
//
// u runs to the right and v upwards on the surface seen from outside; the picture's bottom left
// corner is (0, 0), its top right corner (1, 1), and it repeats beyond. Where a rule speaks of one
// copy, `Material::texture_size` (u, v extents of a copy [m]) makes it a tiling instead: u and v
// are then lengths along the surface, divided by it.
//
// | shape     | u, v                                                                             |
// |-----------|----------------------------------------------------------------------------------|
// | box       | one copy on every face; v along +z on the sides, u along +x, v along +y on top;  |
// |           | below u along +x, v along -y. With a size, measured from the face's middle       |
// | sphere    | u = atan2(y, x)/2pi + 1/2, v = latitude/pi + 1/2                                  |
// | cylinder  | side: u as the sphere's, v from bottom to top; caps: one copy over the square     |
// |           | around the circle, as the box's top and bottom                                    |
// | capsule   | side as the cylinder's over the straight part, ends continue by arc length        |
// | plane     | u = x/size_x, v = y/size_y, size 1 m if none is given; (0, 0) at its origin       |
// | mesh      | the file's own coordinates; without any, by the largest component of the normal   |
// |           | as a box's faces, measured from the origin, size 1 m if none is given             |
// | heightmap | one copy over its extent                                                          |
//
// With a size, sphere, cylinder and capsule measure u by arc length at the radius, from u = 1/2.
#pragma once

#include <memory>

#include "cogrsim/core/image.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

using Vec2 = Eigen::Vector2d;

/// (u, v) at `point` (on the surface, shape's frame [m]) with outward unit `normal` there. For a
/// mesh with coordinates of its own `triangle` says in which one the point lies; -1: unknown.
COGRSIM_API Vec2 texture_coordinates(const SceneModel& model, const Shape& shape, const Vec3& point,
                                     const Vec3& normal, int triangle = -1);

/// The pictures a model's materials name, each read once and shared by all who ask.
class COGRSIM_API TextureStore {
 public:
  /// nullptr: the material has none. A file that cannot be read has been refused by the scene
  /// compiler; if it went away since, the answer is nullptr too and problem() says why.
  std::shared_ptr<const Image> texture(const Material& material);
  const std::string& problem() const { return problem_; }

 private:
  std::map<std::string, std::shared_ptr<const Image>> images_;
  std::string problem_;
};

/// Colour of the picture at (u, v): bilinear, repeating; components 0 to 1, sRGB as in the file.
COGRSIM_API Color sample(const Image& image, const Vec2& uv);

}  // namespace cogrsim
