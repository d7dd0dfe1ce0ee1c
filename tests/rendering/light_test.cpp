// Light and shadows agree with their geometry.
#include <catch2/catch.hpp>

#include <cmath>

#include "support.h"

namespace cogrsim::test {
namespace {

LightModel lamp(LightModel::Type type, const Vec3& position, const Vec3& direction) {
  LightModel light;
  light.name = "lamp";
  light.type = type;
  light.X_WL.p = position;
  light.X_WL.q = Quat::FromTwoVectors(Vec3::UnitX(), direction);
  light.cone = 0.6;
  return light;
}

/// Brightness (red of a white scene) where a point of the world is seen.
int brightness(const Picture& picture, const Camera& camera, const Vec3& point) {
  const Eigen::Vector2d projected = project(camera, point);
  return pixel(picture, static_cast<int>(projected.x()), static_cast<int>(projected.y())).r;
}

TEST_CASE("the side that faces the light is the bright one", "[rendering]") {
  const LightModel::Type type =
      GENERATE(LightModel::Type::directional, LightModel::Type::point, LightModel::Type::spot);
  const double side = GENERATE(1.0, -1.0);
  ModelBuilder builder;
  builder.sphere("ball", 0.5, 1.0, at(3, 0, 0), colored(builder, 1, 1, 1));
  builder.model.lights.push_back(lamp(type, Vec3(3, 4 * side, 0), Vec3(0, -side, 0)));
  const Camera camera = make_camera(Pose(), 120, 120, 0.6);
  const Picture picture = take(builder.build(), request_of(camera));
  const int lit = brightness(picture, camera, Vec3(2.7, 0.35 * side, 0));
  const int dark = brightness(picture, camera, Vec3(2.7, -0.35 * side, 0));
  CHECK(lit > dark + 60);
}

TEST_CASE("a shadow lies where its geometry puts it", "[rendering]") {
  // A ball at 1 m over the floor, lit from above and aside.
  const LightModel::Type type =
      GENERATE(LightModel::Type::directional, LightModel::Type::point, LightModel::Type::spot);
  CAPTURE(static_cast<int>(type));
  const Vec3 ball(0, 0, 1.0), source(-0.8, 0.5, 3.0);
  const double radius = 0.2;
  ModelBuilder builder;
  const int white = colored(builder, 1, 1, 1);
  builder.sphere("ball", radius, 1.0, {ball, Quat(1, 0, 0, 0)}, white);
  builder.plane("floor", {}, white);
  // Something far off, so that the map must span more than the ball.
  builder.box("far", Vec3(0.2, 0.2, 0.2), 1.0, at(3, 3, 0.1), white);
  const Vec3 direction = (ball - source).normalized();
  builder.model.lights.push_back(lamp(type, source, direction));
  const SceneModelPtr model = builder.build();
  const Camera camera =
      make_camera(look(Vec3(-2.5, -1.5, 2.5), Vec3(0.4, -0.25, 0)), 320, 240, 0.9);
  RenderRequest request = request_of(camera);
  const Picture with = take(model, request);
  request.shadows = false;
  const Picture without = take(model, request);

  const bool parallel = type == LightModel::Type::directional;
  // How near the ray from a floor point to the light passes the ball's middle.
  const auto miss = [&](const Vec3& point) {
    const Vec3 to_light = parallel ? Vec3(-direction) : (source - point).normalized();
    return (ball - point).cross(to_light).norm();
  };
  int dark = 0, lit = 0;
  for (double x = -0.8; x < 1.6; x += 0.05) {
    for (double y = -1.2; y < 0.6; y += 0.05) {
      const Vec3 point(x, y, 0.0);
      const Eigen::Vector2d projected = project(camera, point);
      const int column = static_cast<int>(projected.x()), row = static_cast<int>(projected.y());
      if (body_at(with, column, row) != 1) continue;
      const int now = brightness(with, camera, point), bare = brightness(without, camera, point);
      // The edge is soft over a few texels: the map spans at most 8 m in 1024, so 4 cm are ample.
      if (miss(point) < radius - 0.04) {
        REQUIRE(now < bare - 30);
        ++dark;
      } else if (miss(point) > radius + 0.04) {
        REQUIRE(std::abs(now - bare) <= 2);
        ++lit;
      }
    }
  }
  CHECK(dark > 20);
  CHECK(lit > 500);
}

TEST_CASE("surfaces do not shade themselves", "[rendering]") {
  // A lit ball and box without anything between them and the sun: the same with and without.
  const double grazing = GENERATE(0.3, 1.0);  // height of the sun
  ModelBuilder builder;
  const int white = colored(builder, 1, 1, 1);
  builder.box("box", Vec3(1, 1, 0.4), 1.0, at(0, 0, 0.2), white);
  builder.sphere("ball", 0.4, 1.0, at(0, 4, 0.4), white);
  builder.model.lights.push_back(
      lamp(LightModel::Type::directional, Vec3(0, 0, 5), Vec3(1, 0, -grazing)));
  const SceneModelPtr model = builder.build();
  RenderRequest request =
      request_of(make_camera(look(Vec3(-3, 2, 2), Vec3(0, 2, 0.2)), 320, 240, 1.2));
  const Picture with = take(model, request);
  request.shadows = false;
  const Picture without = take(model, request);
  int differ = 0, seen = 0;
  for (int row = 0; row < 240; ++row) {
    for (int column = 0; column < 320; ++column) {
      const int now = pixel(with, column, row).r, bare = pixel(without, column, row).r;
      seen += body_at(with, column, row) >= 0 ? 1 : 0;
      differ += std::abs(now - bare) > 8 ? 1 : 0;
    }
  }
  CHECK(seen > 3000);
  // The line where a ball turns away from the sun may lose a little.
  CHECK(differ < 0.01 * seen);
}

TEST_CASE("a spot lights its cone and nothing else", "[rendering]") {
  ModelBuilder builder;
  builder.plane("floor", {}, colored(builder, 1, 1, 1));
  builder.model.lights.push_back(lamp(LightModel::Type::spot, Vec3(0, 0, 2), Vec3(0, 0, -1)));
  const Camera camera = make_camera(look(Vec3(-3, 0, 3), Vec3(0, 0, 0)), 200, 200, 1.0);
  const Picture picture = take(builder.build(), request_of(camera));
  const double edge = 2.0 * std::tan(0.6);  // [m]
  const int middle = brightness(picture, camera, Vec3(0, 0, 0));
  const int outside = brightness(picture, camera, Vec3(0, edge + 0.1, 0));
  CHECK(middle > outside + 60);
  CHECK(brightness(picture, camera, Vec3(0, 0.7 * edge, 0)) > outside + 40);
  CHECK(brightness(picture, camera, Vec3(0, -edge - 0.1, 0)) == outside);
}

TEST_CASE("colour of light and matter multiply", "[rendering]") {
  ModelBuilder builder;
  builder.box("wall", Vec3(0.2, 9, 9), 1.0, at(3.1, 0, 0), colored(builder, 1, 1, 0));
  LightModel light = lamp(LightModel::Type::directional, Vec3(0, 0, 0), Vec3(1, 0, 0));
  light.color = {0, 1, 1, 1};
  builder.model.lights.push_back(light);
  const Picture picture = take(builder.build(), request_of(make_camera(Pose(), 16, 16, 0.5)));
  const Rgb middle = pixel(picture, 8, 8);
  CHECK(middle.g > 240);            // lit: both have it
  CHECK(middle.r < middle.g - 80);  // the light has no red: only what is everywhere
  CHECK(middle.b == 0);             // the wall has no blue
}

TEST_CASE("without lights there is one sun, with dark ones there is a rest", "[rendering]") {
  ModelBuilder builder;
  builder.plane("floor", {}, colored(builder, 1, 1, 1));
  const Camera camera = make_camera(look(Vec3(-1, 0, 1), Vec3(0, 0, 0)), 32, 32, 0.5);
  SECTION("none") { CHECK(pixel(take(builder.build(), request_of(camera)), 16, 16).r > 200); }
  SECTION("one of no intensity") {
    LightModel light = lamp(LightModel::Type::point, Vec3(0, 0, 3), Vec3(0, 0, -1));
    light.intensity = 0.0;
    builder.model.lights.push_back(light);
    const int rest = pixel(take(builder.build(), request_of(camera)), 16, 16).r;
    CHECK(rest > 60);
    CHECK(rest < 160);
  }
}

TEST_CASE("more lights than can be drawn do no harm", "[rendering]") {
  ModelBuilder builder;
  builder.plane("floor", {}, colored(builder, 1, 1, 1));
  builder.sphere("ball", 0.2, 1.0, at(0, 0, 0.2));
  for (int i = 0; i < 20; ++i) {
    LightModel light = lamp(LightModel::Type::point, Vec3(i, 0, 3), Vec3(0, 0, -1));
    light.intensity = 0.1;
    builder.model.lights.push_back(light);
  }
  const Picture picture = take(
      builder.build(), request_of(make_camera(look(Vec3(-1, 0, 1), Vec3(0, 0, 0)), 32, 32, 0.5)));
  CHECK(pixel(picture, 2, 30).r > 60);
}

}  // namespace
}  // namespace cogrsim::test
