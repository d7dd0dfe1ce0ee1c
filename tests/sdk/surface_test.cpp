#include "cogrsim/model/surface.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"

using namespace cogrsim;

namespace {

constexpr double kPi = 3.14159265358979323846;

/// Materials 0 without and 1 with a texture size of 0.2 m x 0.5 m.
SceneModel scene() {
  SceneModel model;
  model.materials.resize(2);
  model.materials[1].texture_size = Vec2(0.2, 0.5);
  return model;
}

Shape shape_of(ShapeType type, bool sized) {
  Shape shape;
  shape.type = type;
  shape.size = Vec3(2.0, 4.0, 6.0);
  shape.radius = 0.5;
  shape.length = 3.0;
  shape.material = sized ? 1 : 0;
  return shape;
}

Vec2 at(const Shape& shape, const Vec3& point, const Vec3& normal) {
  return texture_coordinates(scene(), shape, point, normal);
}

// All values below are quotients of short decimals and multiples of pi: a few roundings.
void check(const Vec2& uv, double u, double v) {
  CHECK(uv.x() == Approx(u).margin(1e-14));
  CHECK(uv.y() == Approx(v).margin(1e-14));
}

/// Two by two pixels: red, green above blue, white.
Image four() {
  Image image;
  image.width = image.height = 2;
  image.data = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
  return image;
}

void check(const Color& color, double r, double g, double b) {
  CHECK(color.r == Approx(r).margin(1e-12));
  CHECK(color.g == Approx(g).margin(1e-12));
  CHECK(color.b == Approx(b).margin(1e-12));
}

}  // namespace

TEST_CASE("u runs to the right and v upwards on every surface seen from outside", "[surface]") {
  // Right, up and outward are a right-handed frame: (dp/du x dp/dv) . n > 0. Tested by the inverse
  // statement, (grad u x grad v) . n > 0, with differences along two tangents.
  SceneModel model = scene();
  HeightGrid grid;
  grid.columns = grid.rows = 2;
  grid.size_x = 3.0;
  grid.size_y = 5.0;
  grid.heights = {0.0, 0.0, 0.0, 0.0};
  model.heightmaps.push_back(std::make_shared<const HeightGrid>(grid));
  model.meshes.push_back(std::make_shared<const TriangleMesh>());
  const ShapeType type =
      GENERATE(ShapeType::box, ShapeType::sphere, ShapeType::cylinder, ShapeType::capsule,
               ShapeType::plane, ShapeType::mesh, ShapeType::heightmap);
  Shape shape = shape_of(type, GENERATE(false, true));
  shape.mesh = shape.heightmap = 0;
  std::vector<std::pair<Vec3, Vec3>> samples;  // point, normal
  switch (type) {
    case ShapeType::box:
    case ShapeType::mesh:
      for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
          const Vec3 n = sign * Vec3::Unit(axis);
          samples.emplace_back(Vec3(0.1, 0.2, 0.3) + n.cwiseProduct(shape.size / 2), n);
        }
      break;
    case ShapeType::sphere:
      for (const Vec3& n : {Vec3(1, 2, 2), Vec3(2, -1, -2), Vec3(-1, 2, 2)})
        samples.emplace_back(shape.radius * n / 3, n / 3);
      break;
    case ShapeType::cylinder:
      samples.emplace_back(Vec3(0.3, -0.4, 0.7), Vec3(0.6, -0.8, 0));
      samples.emplace_back(Vec3(0.1, 0.1, 1.5), Vec3(0, 0, 1));
      samples.emplace_back(Vec3(0.1, 0.1, -1.5), Vec3(0, 0, -1));
      break;
    case ShapeType::capsule:
      samples.emplace_back(Vec3(0.3, -0.4, 0.7), Vec3(0.6, -0.8, 0));
      samples.emplace_back(Vec3(-1, 2, 2) / 6 + Vec3(0, 0, 1.5), Vec3(-1, 2, 2) / 3);
      samples.emplace_back(Vec3(-1, 2, -2) / 6 - Vec3(0, 0, 1.5), Vec3(-1, 2, -2) / 3);
      break;
    default:
      samples.emplace_back(Vec3(0.3, -0.4, 0), Vec3(0, 0, 1));
  }
  for (const auto& [point, normal] : samples) {
    INFO(to_string(type) << " at " << point.transpose());
    const Vec3 t1 = normal.unitOrthogonal(), t2 = normal.cross(t1);
    const double h = 1e-6;
    const Vec2 here = texture_coordinates(model, shape, point, normal);
    const Vec2 d1 = texture_coordinates(model, shape, point + h * t1, normal) - here;
    const Vec2 d2 = texture_coordinates(model, shape, point + h * t2, normal) - here;
    CHECK(d1.x() * d2.y() - d1.y() * d2.x() > 0.0);
  }
}

TEST_CASE("a box has a copy on each face", "[surface]") {
  const Shape box = shape_of(ShapeType::box, false);  // 2 x 4 x 6
  check(at(box, {1.0, 2.0, 3.0}, {1, 0, 0}), 1.0, 1.0);
  check(at(box, {1.0, -2.0, -3.0}, {1, 0, 0}), 0.0, 0.0);
  check(at(box, {-1.0, 2.0, 1.5}, {-1, 0, 0}), 0.0, 0.75);
  check(at(box, {1.0, 2.0, 3.0}, {0, 1, 0}), 0.0, 1.0);
  check(at(box, {1.0, -2.0, 3.0}, {0, -1, 0}), 1.0, 1.0);
  check(at(box, {0.5, 1.0, 3.0}, {0, 0, 1}), 0.75, 0.75);
  check(at(box, {0.5, 1.0, -3.0}, {0, 0, -1}), 0.75, 0.25);
  const Shape tiled = shape_of(ShapeType::box, true);
  check(at(tiled, {1.0, 0.4, 1.0}, {1, 0, 0}), 2.0, 2.0);
  check(at(tiled, {0.4, 1.0, -3.0}, {0, 0, -1}), 2.0, -2.0);
}

TEST_CASE("round shapes wrap one copy around", "[surface]") {
  const double r = 0.5, l = 3.0, s = std::sqrt(0.5) * r;
  const Shape sphere = shape_of(ShapeType::sphere, false);
  check(at(sphere, {r, 0, 0}, {1, 0, 0}), 0.5, 0.5);
  check(at(sphere, {0, r, 0}, {0, 1, 0}), 0.75, 0.5);
  check(at(sphere, {0, -s, s}, {0, -1, 1}), 0.25, 0.75);
  const Shape sphere_tiled = shape_of(ShapeType::sphere, true);
  check(at(sphere_tiled, {0, r, 0}, {0, 1, 0}), 0.5 + r * kPi / 2 / 0.2, 0.5);
  check(at(sphere_tiled, {s, 0, -s}, {1, 0, -1}), 0.5, 0.5 - r * kPi / 4 / 0.5);

  const Shape cylinder = shape_of(ShapeType::cylinder, false);
  check(at(cylinder, {0, -r, l / 2}, {0, -1, 0}), 0.25, 1.0);
  check(at(cylinder, {r, 0, -l / 2}, {1, 0, 0}), 0.5, 0.0);
  check(at(cylinder, {r / 2, r / 2, l / 2}, {0, 0, 1}), 0.75, 0.75);
  check(at(cylinder, {r / 2, r / 2, -l / 2}, {0, 0, -1}), 0.75, 0.25);
  const Shape cylinder_tiled = shape_of(ShapeType::cylinder, true);
  check(at(cylinder_tiled, {r, 0, 0}, {1, 0, 0}), 0.5, 3.0);
  check(at(cylinder_tiled, {0.3, 0.4, l / 2}, {0, 0, 1}), 1.5, 0.8);

  const Shape capsule = shape_of(ShapeType::capsule, false);
  check(at(capsule, {r, 0, -l / 2}, {1, 0, 0}), 0.5, 0.0);
  check(at(capsule, {r, 0, l / 2}, {1, 0, 0}), 0.5, 1.0);
  check(at(capsule, {s, 0, l / 2 + s}, {1, 0, 1}), 0.5, 1.0 + r * kPi / 4 / l);
  check(at(capsule, {s, 0, -l / 2 - s}, {1, 0, -1}), 0.5, -r * kPi / 4 / l);
  const Shape capsule_tiled = shape_of(ShapeType::capsule, true);
  check(at(capsule_tiled, {r, 0, l / 2}, {1, 0, 0}), 0.5, 6.0);
  check(at(capsule_tiled, {s, 0, l / 2 + s}, {1, 0, 1}), 0.5, 6.0 + r * kPi / 4 / 0.5);
}

TEST_CASE("planes and heightmaps are seen from above", "[surface]") {
  check(at(shape_of(ShapeType::plane, false), {2.5, -1.25, 0}, {0, 0, 1}), 2.5, -1.25);
  check(at(shape_of(ShapeType::plane, true), {2.5, -1.25, 0}, {0, 0, 1}), 12.5, -2.5);
  SceneModel model = scene();
  HeightGrid grid;
  grid.columns = grid.rows = 2;
  grid.size_x = 4.0;
  grid.size_y = 2.0;
  model.heightmaps.push_back(std::make_shared<const HeightGrid>(grid));
  Shape shape = shape_of(ShapeType::heightmap, false);
  shape.heightmap = 0;
  const Vec3 point(1.0, -0.5, 0.3);
  check(texture_coordinates(model, shape, point, {0, 0, 1}), 0.75, 0.25);
  shape.material = 1;
  check(texture_coordinates(model, shape, point, {0, 0, 1}), 5.0, -1.0);
}

TEST_CASE("a mesh uses its own coordinates where it has them", "[surface]") {
  SceneModel model = scene();
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}};
  mesh.uv = {{0, 0}, {0, 1}, {1, 0}, {0.5, 0.5}, {0.7, 0.5}, {0.5, 0.9}};
  model.meshes.push_back(std::make_shared<const TriangleMesh>(mesh));
  Shape shape = shape_of(ShapeType::mesh, false);
  shape.mesh = 0;
  const Vec3 down(0, 0, -1);
  check(texture_coordinates(model, shape, {0.5, 1.0, 0}, down, 0), 0.25, 0.5);
  check(texture_coordinates(model, shape, {1.0, 0, 1.0}, {0, -1, 0}, 1), 0.6, 0.7);
  // An unknown triangle, one that does not exist, and a mesh without coordinates: by the normal.
  check(texture_coordinates(model, shape, {0.5, 1.0, 0}, down), 0.5, -1.0);
  check(texture_coordinates(model, shape, {0.5, 1.0, 0}, down, 7), 0.5, -1.0);
  mesh.uv.clear();
  model.meshes[0] = std::make_shared<const TriangleMesh>(mesh);
  check(texture_coordinates(model, shape, {0.5, 1.0, 0}, down, 0), 0.5, -1.0);
  shape.material = 1;
  check(texture_coordinates(model, shape, {0.5, 1.0, 0}, down, 0), 2.5, -2.0);
  // Of equal components z wins over y, y over x.
  const double c = std::sqrt(0.5);
  shape.material = 0;
  check(texture_coordinates(model, shape, {1, 2, 3}, {c, 0, c}, 0), 1.0, 2.0);
  check(texture_coordinates(model, shape, {1, 2, 3}, {c, c, 0}, 0), -1.0, 3.0);
}

TEST_CASE("a picture has the right orientation and repeats", "[surface]") {
  const Image image = four();
  check(sample(image, {0.25, 0.75}), 1, 0, 0);
  check(sample(image, {0.75, 0.75}), 0, 1, 0);
  check(sample(image, {0.25, 0.25}), 0, 0, 1);
  check(sample(image, {0.75, 0.25}), 1, 1, 1);
  check(sample(image, {-2.75, 5.75}), 1, 0, 0);
  // Half way, and a corner, where all four meet
  check(sample(image, {0.5, 0.75}), 0.5, 0.5, 0);
  check(sample(image, {0.25, 0.5}), 0.5, 0, 0.5);
  check(sample(image, {0.0, 0.0}), 0.5, 0.5, 0.5);
  check(sample(image, {1.0, 1.0}), 0.5, 0.5, 0.5);
  check(sample(image, {0.0, 0.75}), 0.5, 0.5, 0);
  check(sample(image, {-1e-17, 1e-17}), 0.5, 0.5, 0.5);
  // Undefined input, but no crash
  check(sample(image, {std::nan(""), 0.0}), 1, 1, 1);
  check(sample(Image{}, {0.0, 0.0}), 1, 1, 1);
}

TEST_CASE("grey and transparent pictures are sampled too", "[surface]") {
  Image image;
  image.width = 1;
  image.height = 1;
  image.channels = 1;
  image.data = {51};
  check(sample(image, {0.3, 0.8}), 0.2, 0.2, 0.2);
  CHECK(sample(image, {0.3, 0.8}).a == 1.0);
  image.channels = 4;
  image.data = {51, 102, 153, 204};
  check(sample(image, {0.3, 0.8}), 0.2, 0.4, 0.6);
  CHECK(sample(image, {0.3, 0.8}).a == Approx(0.8));
}

TEST_CASE("a texture store reads each file once and reports errors", "[surface]") {
  TextureStore store;
  Material material;
  CHECK(store.texture(material) == nullptr);
  CHECK(store.problem().empty());
  material.texture = "/nonexistent/floor.png";
  CHECK(store.texture(material) == nullptr);
  CHECK(store.problem() ==
        "texture /nonexistent/floor.png: cannot be opened: No such file or directory");
}
