// Textures lie on every shape as cogrsim/model/surface.h says.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstdio>

#include "cogrsim/core/output_file.h"
#include "cogrsim/model/surface.h"
#include "cogrsim/rays/ray_caster.h"
#include "support.h"

namespace cogrsim::test {
namespace {

/// Four quarters, top left red, top right green, bottom left blue, bottom right white; file path.
std::string quarters() {
  static const std::string path = [] {
    Image image{64, 64, 3, {}};
    for (int row = 0; row < 64; ++row) {
      for (int column = 0; column < 64; ++column) {
        const bool left = column < 32, top = row < 32;
        const std::uint8_t r = top ? (left ? 255 : 0) : (left ? 0 : 255);
        const std::uint8_t g = top ? (left ? 0 : 255) : (left ? 0 : 255);
        const std::uint8_t b = top ? 0 : 255;
        image.data.insert(image.data.end(), {r, g, b});
      }
    }
    std::string file = std::string(COGRSIM_RENDERING_OUTPUT) + "/quarters.png";
    const Result<std::string> png = encode_png(image);
    REQUIRE(png);
    REQUIRE(write_output_file(file, OutputKind::png, *png));
    return file;
  }();
  return path;
}

/// 'r', 'g', 'b', 'w', or '?' for anything between.
char color_of(const Rgb& p) {
  const int most = std::max({p.r, p.g, p.b}), least = std::min({p.r, p.g, p.b});
  if (most < 50) return '?';
  if (least > 0.85 * most) return 'w';
  if (p.r == most && p.g < 0.3 * most && p.b < 0.3 * most) return 'r';
  if (p.g == most && p.r < 0.3 * most && p.b < 0.3 * most) return 'g';
  if (p.b == most && p.r < 0.3 * most && p.g < 0.3 * most) return 'b';
  return '?';
}

int textured_material(ModelBuilder& builder) {
  const int material = colored(builder, 1, 1, 1);
  builder.model.materials[material].texture = quarters();
  return material;
}

TEST_CASE("a picture on a wall is upright and not mirrored", "[rendering]") {
  // The face towards -x, seen from outside.
  ModelBuilder builder;
  builder.box("wall", Vec3(0.2, 2, 2), 0.0, at(3.1, 0, 0), textured_material(builder));
  const Camera camera = make_camera(Pose(), 120, 120, 0.7);
  const Picture picture = take(builder.build(), request_of(camera));
  CHECK(color_of(pixel(picture, 35, 35)) == 'r');
  CHECK(color_of(pixel(picture, 85, 35)) == 'g');
  CHECK(color_of(pixel(picture, 35, 85)) == 'b');
  CHECK(color_of(pixel(picture, 85, 85)) == 'w');
}

TEST_CASE("textures lie on every shape as the rule says", "[rendering]") {
  const ShapeType type =
      GENERATE(ShapeType::box, ShapeType::sphere, ShapeType::cylinder, ShapeType::capsule,
               ShapeType::plane, ShapeType::convex_mesh, ShapeType::mesh, ShapeType::heightmap);
  const bool tiled = GENERATE(false, true);
  const Vec3 eye = GENERATE(Vec3(-2.2, 0.6, 1.4), Vec3(1.5, -1.9, 0.9), Vec3(0.5, 2.0, -1.0));
  if (type == ShapeType::plane && eye.z() < 0.0) return;  // its underside says nothing new
  CAPTURE(to_string(type), tiled, eye.x());
  ModelBuilder builder;
  const int material = textured_material(builder);
  if (tiled) {
    builder.model.materials[material].texture_size = Eigen::Vector2d(0.7, 0.5);
  }
  const Pose pose(Vec3(0.1, -0.05, 0.02), Quat(Eigen::AngleAxisd(0.3, Vec3::UnitX())));
  TriangleMesh mesh;
  mesh.vertices = {{0.7, 0, -0.4}, {-0.4, 0.6, -0.4}, {-0.4, -0.6, -0.4}, {0, 0, 0.7}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  HeightGrid grid;
  grid.columns = grid.rows = 5;
  grid.size_x = grid.size_y = 1.6;
  for (int i = 0; i < 25; ++i) grid.heights.push_back(0.1 * std::sin(2.0 * i));
  switch (type) {
    case ShapeType::box:
      builder.box("shape", Vec3(1, 0.8, 0.9), 1.0, pose, material);
      break;
    case ShapeType::sphere:
      builder.sphere("shape", 0.7, 1.0, pose, material);
      break;
    case ShapeType::cylinder:
      builder.cylinder("shape", 0.5, 1.0, 1.0, pose, material);
      break;
    case ShapeType::capsule:
      builder.capsule("shape", 0.4, 0.7, 1.0, pose, material);
      break;
    case ShapeType::plane:
      builder.plane("shape", pose, material);
      break;
    case ShapeType::mesh:
      for (int i = 0; i < 4; ++i) {
        mesh.uv.insert(mesh.uv.end(), {Vec2(0.1 * i, 0), Vec2(1, 0.2), Vec2(0.4, 0.9)});
      }
      builder.mesh("shape", mesh, false, 0.0, pose, material);
      break;
    case ShapeType::convex_mesh:
      builder.mesh("shape", mesh, true, 1.0, pose, material);
      break;
    case ShapeType::heightmap:
      builder.heightmap("shape", grid, pose, material);
      break;
  }
  // Light from everywhere alike, so that no face is black.
  for (const double side : {-1.0, 1.0}) {
    LightModel light;
    light.name = side < 0 ? "one" : "other";
    light.shadows = false;
    light.intensity = 0.6;
    light.X_WL.q = Quat::FromTwoVectors(Vec3::UnitX(), side * Vec3(1, 0.7, 0.5));
    builder.model.lights.push_back(light);
  }
  const SceneModelPtr model = builder.build();
  const Camera camera = make_camera(look(eye, Vec3(0, 0, 0)), 160, 120, 0.9);
  const Picture picture = take(model, request_of(camera));
  TextureStore store;
  const auto image = store.texture(model->materials[material]);
  REQUIRE(image);
  RayCaster caster;
  caster.update(model, {model->bodies[0].X_WB});
  const Shape& shape = model->bodies[0].shapes[0];
  int right = 0, wrong = 0;
  for (int row = 1; row < 120; row += 3) {
    for (int column = 1; column < 160; column += 3) {
      // Sure of the colour only if it is the same a pixel to every side.
      char expected = 0;
      for (const double dx : {-1.0, 0.0, 1.0}) {
        for (const double dy : {-1.0, 0.0, 1.0}) {
          const Vec3 ray_C(1.0, (camera.cx - column - 0.5 - dx) / camera.fx,
                           (camera.cy - row - 0.5 - dy) / camera.fy);
          Ray ray;
          ray.origin = camera.X_WC.p;
          ray.direction = camera.X_WC.q * ray_C.normalized();
          const RayHit hit = caster.cast(ray);
          char here = '?';
          if (hit && hit.distance < 4.0) {
            const Pose X_SW = (model->bodies[0].X_WB * shape.X_BS).inverse();
            const Vec2 uv = texture_coordinates(*model, shape, X_SW * hit.point,
                                                X_SW.q * hit.normal, hit.triangle);
            const Color c = sample(*image, uv);
            here = color_of({static_cast<int>(255 * c.r), static_cast<int>(255 * c.g),
                             static_cast<int>(255 * c.b)});
          }
          expected = expected == 0 || expected == here ? here : '?';
        }
      }
      if (expected == '?') continue;
      (color_of(pixel(picture, column, row)) == expected ? right : wrong) += 1;
    }
  }
  CAPTURE(right, wrong);
  CHECK(right > 100);
  CHECK(wrong <= right / 50);  // a texel's blur where the texture is seen from the side
}

TEST_CASE("a texture is multiplied by the material's colour", "[rendering]") {
  ModelBuilder builder;
  const int material = textured_material(builder);
  builder.model.materials[material].color = {1, 0, 1, 1};
  builder.box("wall", Vec3(0.2, 2, 2), 0.0, at(3.1, 0, 0), material);
  const Picture picture = take(builder.build(), request_of(make_camera(Pose(), 120, 120, 0.7)));
  const Rgb red = pixel(picture, 35, 35), green = pixel(picture, 85, 35),
            white = pixel(picture, 85, 85);
  CHECK((red.r > 60 && red.g == 0 && red.b < 10));
  CHECK((green.r < 10 && green.g == 0 && green.b < 10));
  CHECK((white.r > 60 && white.g == 0 && white.b > 60));
}

}  // namespace
}  // namespace cogrsim::test
