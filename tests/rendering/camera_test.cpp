// Cameras that cannot be rendered are refused with the error and the limit.
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "support.h"

namespace cogrsim::test {
namespace {

using Catch::Matchers::Contains;

SceneModelPtr one_ball() {
  ModelBuilder builder;
  builder.sphere("ball", 0.5, 1.0, at(2, 0, 0));
  return builder.build();
}

std::string refusal(const RenderRequest& request) {
  const auto pictures = renderer().render(frame_of(one_ball()), {request});
  return pictures ? "" : pictures.error().text();
}

TEST_CASE("make_camera has the field of view asked for", "[rendering]") {
  const Camera camera = make_camera(Pose(), 640, 480, 1.0);
  CHECK(std::atan(camera.cx / camera.fx) == Approx(0.5));
  CHECK(camera.fx == camera.fy);
  CHECK(camera.cx == 320.0);
  CHECK(camera.cy == 240.0);
  CHECK(check_camera(camera));
}

TEST_CASE("bad cameras are refused", "[rendering]") {
  RenderRequest request;
  request.camera = make_camera(Pose(), 64, 48, 1.0);
  REQUIRE(refusal(request).empty());
  Camera& camera = request.camera;
  std::string expected;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  SECTION("zero width") {
    camera.width = 0;
    expected = "0 x 48 pixels: width and height must be at least 1";
  }
  SECTION("negative height") {
    camera.height = -3;
    expected = "64 x -3";
  }
  SECTION("100 megapixels") {
    camera.width = camera.height = 10000;
    expected = "100000000 pixels exceed the limit of 64000000";
  }
  SECTION("sizes whose product overflows") {
    camera.width = camera.height = std::numeric_limits<int>::max();
    expected = "exceed the limit of 64000000";
  }
  SECTION("near beyond far") {
    camera.near = 5.0;
    camera.far = 2.0;
    expected = "near 5 m and far 2 m";
  }
  SECTION("near equals far") {
    camera.near = camera.far = 2.0;
    expected = "near 2 m and far 2 m";
  }
  SECTION("near at zero") {
    camera.near = 0.0;
    expected = "0 < near < far";
  }
  SECTION("infinite far") {
    camera.far = infinity;
    expected = "both finite";
  }
  SECTION("focal length") {
    camera.fy = 0.0;
    expected = "focal length fy = 0";
  }
  SECTION("field of view beyond half a turn") {
    camera = make_camera(Pose(), 64, 48, 3.5);
    expected = "focal length fx";
  }
  SECTION("principal point") {
    camera.cx = nan;
    expected = "cx";
  }
  SECTION("distortion") {
    camera.distortion[3] = nan;
    expected = "distortion";
  }
  SECTION("pose") {
    camera.X_WC.p.y() = infinity;
    expected = "pose is not finite";
  }
  SECTION("orientation") {
    camera.X_WC.q = Quat(2, 0, 0, 0);
    expected = "orientation has length 2";
  }
  SECTION("samples") {
    request.samples = 3;
    expected = "3 samples per pixel, expected 1, 2, 4 or 8";
  }
  CHECK_THAT(refusal(request), Contains(expected));
}

TEST_CASE("the offender among several requests is named", "[rendering]") {
  RenderRequest good, bad;
  good.camera = bad.camera = make_camera(Pose(), 16, 16, 1.0);
  bad.camera.width = 0;
  const auto pictures = renderer().render(frame_of(one_ball()), {good, bad});
  REQUIRE_FALSE(pictures);
  CHECK_THAT(pictures.error().message, Contains("request 1: "));
}

TEST_CASE("frames that cannot be drawn are refused", "[rendering]") {
  RenderRequest request;
  request.camera = make_camera(Pose(), 16, 16, 1.0);
  CHECK_FALSE(renderer().render(Frame(), {request}));
  Frame frame = frame_of(one_ball());
  frame.state.poses.clear();
  CHECK_FALSE(renderer().render(frame, {request}));
}

TEST_CASE("a texture that went away is named", "[rendering]") {
  ModelBuilder builder;
  builder.sphere("ball", 0.5, 1.0, at(2, 0, 0), colored(builder, 1, 1, 1));
  builder.model.materials.back().texture = "/nowhere/bricks.png";
  RenderRequest request;
  request.camera = make_camera(Pose(), 16, 16, 1.0);
  const auto pictures = renderer().render(frame_of(builder.build()), {request});
  REQUIRE_FALSE(pictures);
  CHECK_THAT(pictures.error().text(), Contains("bricks.png"));
}

TEST_CASE("a camera inside a body sees it from within", "[rendering]") {
  ModelBuilder builder;
  const int room = builder.box("room", Vec3(4, 4, 4), 1.0, at(0, 0, 0));
  builder.sphere("ball", 0.4, 1.0, at(1, 0, 0));
  const Picture picture = take(builder.build(), request_of(make_camera(Pose(), 64, 64, 1.4)));
  CHECK(body_at(picture, 2, 2) == room);
  CHECK(depth_at(picture, 2, 2) == Approx(2.0).epsilon(1e-3));
  CHECK(depth_at(picture, 32, 32) == Approx(0.6).epsilon(2e-3));
  CHECK(count_body(picture, -1) == 0);
}

}  // namespace
}  // namespace cogrsim::test
