// Small expected pictures, checked by eye once and kept. Renew them with
// COGRSIM_RENEW_EXPECTED=1, and look again.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstdlib>

#include "cogrsim/core/output_file.h"
#include "support.h"

namespace cogrsim::test {
namespace {

SceneModelPtr still_life(const std::string& light) {
  ModelBuilder builder;
  const int white = colored(builder, 0.95, 0.95, 0.95), red = colored(builder, 0.85, 0.2, 0.15),
            green = colored(builder, 0.2, 0.65, 0.25), blue = colored(builder, 0.15, 0.35, 0.8);
  builder.plane("floor", {}, colored(builder, 0.6, 0.6, 0.62));
  builder.box("box", Vec3(0.6, 0.4, 0.5), 1.0,
              {Vec3(0, 0, 0.25), Quat(Eigen::AngleAxisd(0.4, Vec3::UnitZ()))}, red);
  builder.sphere("ball", 0.3, 1.0, at(0.2, 0.8, 0.3), blue);
  builder.cylinder("post", 0.2, 0.7, 1.0, at(0.3, -0.8, 0.35), green);
  builder.capsule(
      "pill", 0.12, 0.5, 1.0,
      {Vec3(-0.7, 0.4, 0.12), Quat(Eigen::AngleAxisd(1.5708, Vec3(1, 1, 0).normalized()))}, white);
  builder.box("wall", Vec3(0.1, 4, 1.2), 0.0, at(2, 0, 0.6), white);
  HeightGrid grid;
  grid.columns = grid.rows = 20;
  grid.size_x = grid.size_y = 1.5;
  for (int i = 0; i < 400; ++i) {
    grid.heights.push_back(0.15 + 0.12 * std::sin(0.6 * (i % 20)) * std::cos(0.05 * i));
  }
  builder.heightmap("hill", grid, at(0.2, 2.2, 0), green);
  if (light != "sun") {
    LightModel lamp;
    lamp.name = light;
    lamp.type = light == "spot" ? LightModel::Type::spot : LightModel::Type::point;
    lamp.cone = 0.6;
    lamp.X_WL = {Vec3(-0.4, 0.1, 2.0), Quat::FromTwoVectors(Vec3::UnitX(), Vec3(0.2, 0.1, -1))};
    builder.model.lights.push_back(lamp);
  }
  return builder.build();
}

TEST_CASE("pictures look as they did", "[rendering]") {
  const std::string name = GENERATE("sun", "point", "spot");
  RenderRequest request;
  request.camera = make_camera(look(Vec3(-2.6, -0.9, 1.5), Vec3(0.2, 0.3, 0.2)), 160, 120, 1.0);
  if (name == "point") {
    OverlayLine ray;
    ray.from = Vec3(-0.4, 0.1, 2.0);
    ray.to = Vec3(0.3, -0.8, 0.7);
    request.overlay.lines = {ray};
  }
  if (name == "spot") request.camera.distortion[0] = -0.2;
  const Picture picture = take(still_life(name), request);
  const std::string path = std::string(COGRSIM_EXPECTED_PICTURES) + "/" + name + ".png";
  if (std::getenv("COGRSIM_RENEW_EXPECTED") != nullptr) {
    const Result<std::string> png = encode_png(picture.color);
    REQUIRE(png);
    REQUIRE(write_output_file(path, OutputKind::png, *png));
  }
  const Result<Image> expected = load_image(path);
  REQUIRE(expected);
  REQUIRE(expected->width == 160);
  REQUIRE(expected->height == 120);
  REQUIRE(expected->channels == 3);
  // Another release of the graphics library may round otherwise and place samples elsewhere: a few
  // steps anywhere, more in the pixels along edges, of which there are about 1500.
  int differ = 0;
  double sum = 0.0;
  for (std::size_t i = 0; i < picture.color.data.size(); ++i) {
    const int difference = std::abs(int{picture.color.data[i]} - int{expected->data[i]});
    differ += difference > 6 ? 1 : 0;
    sum += difference;
  }
  CHECK(differ < 3 * 600);
  CHECK(sum / static_cast<double>(picture.color.data.size()) < 1.0);
}

}  // namespace
}  // namespace cogrsim::test
