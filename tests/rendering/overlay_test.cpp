// Lines pass through their pixels, and walls hide them.
#include <catch2/catch.hpp>

#include <cmath>

#include "support.h"

namespace cogrsim::test {
namespace {

bool is_red(const Rgb& p) { return p.r > 180 && p.g < 80 && p.b < 80; }

int count_red(const Picture& picture) {
  int count = 0;
  for (int row = 0; row < picture.height; ++row) {
    for (int column = 0; column < picture.width; ++column) {
      count += is_red(pixel(picture, column, row)) ? 1 : 0;
    }
  }
  return count;
}

TEST_CASE("a line passes through the pixels it projects to", "[rendering]") {
  ModelBuilder builder;
  builder.box("far", Vec3(0.1, 0.1, 0.1), 1.0, at(50, 0, 0));
  const SceneModelPtr model = builder.build();
  Camera camera = make_camera(look(Vec3(0, 0, 1), Vec3(4, 0.5, 0)), 320, 240, 1.0);
  const bool bent = GENERATE(false, true);
  if (bent) camera.distortion[0] = -0.2;
  RenderRequest request = request_of(camera);
  request.samples = GENERATE(1, 2, 4, 8);
  CAPTURE(bent, request.samples);
  OverlayLine line;
  line.from = Vec3(3, 1, 0.2);
  line.to = Vec3(6, -1, 1.2);
  line.width = 3.0;
  request.overlay.lines = {line};
  const Picture picture = take(model, request);
  for (double t = 0.02; t < 1.0; t += 0.02) {
    const Eigen::Vector2d projected = project(camera, line.from + t * (line.to - line.from));
    REQUIRE(
        is_red(pixel(picture, static_cast<int>(projected.x()), static_cast<int>(projected.y()))));
  }
  // As long as its projection, three pixels wide; its rim is red but in part.
  const double length = (project(camera, line.to) - project(camera, line.from)).norm();
  const int red = count_red(picture);
  CHECK(red > 1.5 * length);
  CHECK(red < 4.0 * length + 12.0);
}

TEST_CASE("a wall hides a line unless it is on top", "[rendering]") {
  ModelBuilder builder;
  builder.box("wall", Vec3(0.1, 4, 4), 0.0, at(2, 0, 0), colored(builder, 0.2, 0.8, 0.2));
  const SceneModelPtr model = builder.build();
  RenderRequest request = request_of(make_camera(Pose(), 100, 100, 0.8));
  OverlayLine line;
  line.from = Vec3(3, -0.5, 0.01);
  line.to = Vec3(3, 0.5, 0.01);
  line.width = 3.0;
  request.overlay.lines = {line};
  CHECK(count_red(take(model, request)) == 0);
  request.overlay.lines[0].on_top = true;
  CHECK(count_red(take(model, request)) > 60);
  // On the wall's face it is seen.
  request.overlay.lines[0].on_top = false;
  request.overlay.lines[0].from.x() = request.overlay.lines[0].to.x() = 1.95;
  CHECK(count_red(take(model, request)) > 60);
}

TEST_CASE("lines behind the camera and broken ones do no harm", "[rendering]") {
  ModelBuilder builder;
  builder.box("wall", Vec3(0.1, 4, 4), 0.0, at(2, 0, 0));
  const SceneModelPtr model = builder.build();
  RenderRequest request = request_of(make_camera(Pose(), 100, 100, 0.8));
  OverlayLine behind, broken, through, point;
  behind.from = Vec3(-1, 0, 0);
  behind.to = Vec3(-2, 1, 0);
  broken.to = Vec3(std::nan(""), 0, 0);
  through.from = Vec3(-1, -0.3, 0.1);  // from behind the camera into the picture
  through.to = Vec3(1.5, 0.2, 0.1);
  point.from = point.to = Vec3(1, 0, 0);
  request.overlay.lines = {behind, broken};
  CHECK(count_red(take(model, request)) == 0);
  request.overlay.lines = {through, point};
  CHECK(count_red(take(model, request)) > 10);
}

TEST_CASE("overlays leave depth and segmentation alone", "[rendering]") {
  ModelBuilder builder;
  builder.sphere("ball", 0.5, 1.0, at(2, 0, 0));
  const SceneModelPtr model = builder.build();
  RenderRequest request = request_of(make_camera(Pose(), 64, 64, 1.0));
  const Picture without = take(model, request);
  OverlayLine line;
  line.from = Vec3(1, -1, 0);
  line.to = Vec3(1, 1, 0);
  request.overlay.lines = {line};
  request.overlay.labels = {{Vec3(1, 0, 0), "label", {}}};
  const Picture with = take(model, request);
  CHECK(with.depth == without.depth);
  CHECK(with.bodies == without.bodies);
  CHECK(with.color.data != without.color.data);
}

TEST_CASE("a label stands right of its anchor, and what is in front hides it", "[rendering]") {
  ModelBuilder builder;
  builder.box("wall", Vec3(0.1, 4, 4), 0.0, at(2, 0, 0), colored(builder, 0.1, 0.1, 0.1));
  const SceneModelPtr model = builder.build();
  RenderRequest request = request_of(make_camera(Pose(), 160, 120, 0.8));
  request.depth = false;
  const Picture without = take(model, request);
  OverlayLabel label;
  label.text = GENERATE("wheel", "Rad \xC3\xA4\xC3\xB6\xC3\xBC", "bad \xFF\xC3 bytes");
  label.at = Vec3(1, 0.1, 0.05);
  request.overlay.labels = {label};
  const Picture with = take(model, request);
  CHECK(with.depth.empty());
  const Eigen::Vector2d projected = project(request.camera, label.at);
  int changed = 0;
  for (int row = 0; row < 120; ++row) {
    for (int column = 0; column < 160; ++column) {
      if (pixel(with, column, row).r == pixel(without, column, row).r) continue;
      ++changed;
      REQUIRE(column + 1 > projected.x());
      REQUIRE(std::abs(row - projected.y()) < 14);
    }
  }
  CHECK(changed > 40);
  request.overlay.labels[0].at.x() = 3;
  CHECK(take(model, request).color.data == without.color.data);
}

}  // namespace
}  // namespace cogrsim::test
