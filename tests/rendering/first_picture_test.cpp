// The first picture of a new user: bodies without a colour on a floor without one, no light, from
// `iso`.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <set>
#include <tuple>
#include <vector>

#include "cogrsim/rendering/looks.h"
#include "cogrsim/rendering/standard_view.h"
#include "support.h"

namespace cogrsim::test {
namespace {

Rgb seen(const Picture& picture, const Camera& camera, const Vec3& point) {
  const Eigen::Vector2d projected = project(camera, point);
  return pixel(picture, static_cast<int>(projected.x()), static_cast<int>(projected.y()));
}

TEST_CASE("no face of a box runs into another or into the floor", "[rendering]") {
  const bool lit = GENERATE(true, false);  // by default; by a lamp that gives nothing
  ModelBuilder builder;
  builder.plane("floor");
  builder.box("box", Vec3(1, 1, 1), 1.0, at(0, 0, 0.5));
  if (!lit) {
    LightModel lamp;
    lamp.intensity = 0.0;
    builder.model.lights.push_back(lamp);
  }
  const SceneModelPtr model = builder.build();
  const Camera camera =
      standard_camera(StandardView::iso, visible_bounds(frame_of(model)), 320, 240);
  const Picture picture = take(model, request_of(camera));
  const std::vector<Rgb> faces = {
      seen(picture, camera, Vec3(0.5, 0.1, 0.5)), seen(picture, camera, Vec3(0.1, 0.5, 0.5)),
      seen(picture, camera, Vec3(0.1, 0.1, 1.0)), seen(picture, camera, Vec3(0.55, -0.45, 0.0))};
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (std::size_t k = i + 1; k < faces.size(); ++k) {
      CAPTURE(lit, i, k, faces[i].r, faces[i].g, faces[i].b, faces[k].r, faces[k].g, faces[k].b);
      CHECK(difference(faces[i], faces[k]) > (lit ? 40 : 20));
    }
  }
  if (!lit) return;
  // The sides that one sees are not the dark ones.
  CHECK(faces[0].g > 100);
  CHECK(faces[1].g > 70);
  CHECK(faces[3].g > 200);
}

TEST_CASE("a floor without a chosen material has a grid", "[rendering]") {
  const bool chosen = GENERATE(false, true);
  ModelBuilder builder;
  builder.plane("floor", {}, chosen ? colored(builder, 0.8, 0.8, 0.8) : 0);
  const Camera camera =
      make_camera(look(Vec3(0.25, 0.25, 2), Vec3(0.2501, 0.25, 0)), 200, 200, 0.6);
  const Picture picture = take(builder.build(), request_of(camera));
  const Rgb line = seen(picture, camera, Vec3(0, 0.25, 0)),
            cell = seen(picture, camera, Vec3(0.05, 0.25, 0));
  CHECK((difference(line, cell) > 30) != chosen);
}

TEST_CASE("bodies without a colour get one by their index, others keep theirs", "[rendering]") {
  ModelBuilder builder;
  const int red = colored(builder, 1, 0, 0);
  std::set<std::tuple<double, double, double>> seen;
  for (int i = 0; i < 8; ++i) builder.sphere("ball" + std::to_string(i), 0.1, 1.0, at(i, 0, 0));
  const int painted = builder.sphere("painted", 0.1, 1.0, at(9, 0, 0), red);
  const int wall = builder.box("wall", Vec3(1, 1, 1), 0.0, at(0, 5, 0));
  const SceneModelPtr model = builder.build();
  const auto color_of = [&](int body) {
    return shown_color(*model, body, model->bodies[body].shapes.front());
  };
  for (int i = 0; i < 8; ++i) seen.insert({color_of(i).r, color_of(i).g, color_of(i).b});
  CHECK(seen.size() == 8);
  CHECK(color_of(painted).r == 1.0);
  CHECK(color_of(painted).g == 0.0);
  const Color grey = color_of(wall);
  CHECK(seen.count({grey.r, grey.g, grey.b}) == 0);
  // The model itself is unchanged: the default look is no part of a state.
  CHECK(!has_looks(model->materials.front()));
}

}  // namespace
}  // namespace cogrsim::test
