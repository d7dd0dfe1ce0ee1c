// Distorted pictures show points where the formula puts them.
#include <catch2/catch.hpp>

#include <cmath>

#include "support.h"

namespace cogrsim::test {
namespace {

TEST_CASE("a known point lands where the lens puts it", "[rendering]") {
  const std::array<double, 5> lens =
      GENERATE(std::array<double, 5>{-0.25, 0.06, 0, 0, 0}, std::array<double, 5>{0.2, 0, 0, 0, 0},
               std::array<double, 5>{-0.1, 0.02, 0.01, -0.008, 0.003});
  // Small bright balls in front of nothing; the middle of each one's pixels is where it is seen.
  ModelBuilder builder;
  std::vector<Vec3> positions;
  for (const double y : {-1.2, -0.5, 0.0, 0.7, 1.3}) {
    for (const double z : {-0.8, 0.0, 0.75}) {
      positions.emplace_back(3.0, y, z);
      builder.sphere("ball" + std::to_string(positions.size()), 0.03, 1.0,
                     {positions.back(), Quat(1, 0, 0, 0)});
    }
  }
  Camera camera = make_camera(Pose(), 480, 360, 1.1);
  camera.cx += 7.5;
  camera.cy -= 4.25;
  camera.distortion = lens;
  const Picture picture = take(builder.build(), request_of(camera));
  int seen = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector2d expected = project(camera, positions[i]);
    if (expected.x() < 8 || expected.y() < 8 || expected.x() > 472 || expected.y() > 352) continue;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    int count = 0;
    for (int row = 0; row < 360; ++row) {
      for (int column = 0; column < 480; ++column) {
        if (body_at(picture, column, row) != static_cast<int>(i)) continue;
        middle += Eigen::Vector2d(column + 0.5, row + 0.5);
        ++count;
        // From the ball's front to its rim, which lies a little behind the middle off the axis.
        REQUIRE(depth_at(picture, column, row) > 2.97F - 3e-3F);
        REQUIRE(depth_at(picture, column, row) < 3.02F);
      }
    }
    REQUIRE(count > 20);
    middle /= count;
    CAPTURE(i, expected.x(), expected.y(), middle.x(), middle.y());
    CHECK((middle - expected).norm() < 0.5);
    ++seen;
  }
  CHECK(seen >= 9);
}

TEST_CASE("no distortion is the same as a zero one", "[rendering]") {
  ModelBuilder builder;
  builder.box("box", Vec3(0.5, 0.5, 0.5), 1.0,
              {Vec3(2, 0.1, 0.2), Quat(Eigen::AngleAxisd(0.5, Vec3::UnitZ()))});
  const SceneModelPtr model = builder.build();
  Camera camera = make_camera(Pose(), 160, 120, 0.9);
  const Picture straight = take(model, request_of(camera));
  camera.distortion[0] = 1e-12;
  const Picture bent = take(model, request_of(camera));
  int differ = 0;
  for (std::size_t i = 0; i < straight.bodies.size(); ++i) {
    differ += straight.bodies[i] != bent.bodies[i] ? 1 : 0;
  }
  CHECK(differ <= 3);  // corners are put on a grid of 1/256 pixel, another one in each
  for (std::size_t i = 0; i < straight.color.data.size(); ++i) {
    REQUIRE(std::abs(int{straight.color.data[i]} - int{bent.color.data[i]}) <= 1);
  }
}

TEST_CASE("pixels outside of a lens are black, far and of no body", "[rendering]") {
  // 1 - 0.5 r^2 folds back at r = 0.816, where r' = 0.544; the picture's corners lie beyond.
  ModelBuilder builder;
  builder.box("room", Vec3(4, 4, 4), 1.0, at(0, 0, 0), colored(builder, 1, 1, 1));
  Camera camera = make_camera(Pose(), 100, 100, 1.57);
  camera.distortion[0] = -0.5;
  const Picture picture = take(builder.build(), request_of(camera));
  CHECK(body_at(picture, 0, 0) == -1);
  CHECK(std::isinf(depth_at(picture, 0, 0)));
  CHECK(pixel(picture, 0, 0).r == 0);
  CHECK(body_at(picture, 50, 50) == 0);
  CHECK(depth_at(picture, 50, 50) == Approx(2.0).epsilon(1e-3));
}

TEST_CASE("a lens that sees nothing at all is refused", "[rendering]") {
  ModelBuilder builder;
  builder.sphere("ball", 0.3, 1.0, at(2, 0, 0));
  Camera camera = make_camera(Pose(), 64, 48, 1.0);
  camera.cx = 5e4;  // the whole picture lies far off the axis
  camera.distortion[0] = -0.3;
  const auto pictures = renderer().render(frame_of(builder.build()), {request_of(camera)});
  REQUIRE_FALSE(pictures);
  CHECK_THAT(pictures.error().message, Catch::Matchers::Contains("lens distortion"));
}

}  // namespace
}  // namespace cogrsim::test
