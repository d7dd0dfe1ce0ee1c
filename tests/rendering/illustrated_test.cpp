// Pictures for people: edges, outlines, floors without an end, and a view that goes along.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstdlib>

#include "cogrsim/rendering/framing.h"
#include "cogrsim/rendering/looks.h"
#include "cogrsim/rendering/standard_view.h"
#include "support.h"

namespace cogrsim::test {
namespace {

RenderRequest illustrated(const Camera& camera) {
  RenderRequest request = request_of(camera);
  request.background.kind = Background::Kind::sky;
  request.illustrated = true;
  return request;
}

int sum(const Rgb& c) { return c.r + c.g + c.b; }

/// The darkest of the 3 x 3 pixels around a point of the world.
int darkest(const Picture& picture, const Camera& camera, const Vec3& point) {
  const Eigen::Vector2d at = project(camera, point);
  int least = 3 * 255;
  for (int row = -1; row <= 1; ++row) {
    for (int column = -1; column <= 1; ++column) {
      least = std::min(least, sum(pixel(picture, static_cast<int>(at.x()) + column,
                                        static_cast<int>(at.y()) + row)));
    }
  }
  return least;
}

/// A body that may move, and where it is in frames that are made by hand.
struct Moving {
  explicit Moving(int balls) {
    ModelBuilder builder;
    for (int i = 0; i < balls; ++i)
      builder.sphere("ball" + std::to_string(i), 0.1, 1.0, at(0, 0, 0));
    frame = frame_of(builder.build());
  }
  const Frame& put(int body, double x) {
    frame.state.poses[static_cast<std::size_t>(body)].p.x() = x;
    return frame;
  }
  Frame frame;
};

TEST_CASE("a body and the floor under it never look alike", "[rendering][illustrated]") {
  ModelBuilder builder;
  const int wood = colored(builder, 0.71, 0.53, 0.39);
  builder.plane("floor", {}, wood);
  builder.box("box", Vec3(1, 1, 1), 1.0, at(0, 0, 0.5), wood);
  const SceneModelPtr model = builder.build();
  const Shape& floor = model->bodies[0].shapes[0];
  const Color pale = floor_color(*model, 0, floor), own = shown_color(*model, 0, floor);
  CHECK(std::abs(pale.b - own.b) > 0.1);
  const Camera camera =
      standard_camera(StandardView::top, visible_bounds(frame_of(model)), 320, 240);
  // The box fills the height; its shadow falls to the left.
  const auto contrast = [&](const Picture& picture) {
    return difference(pixel(picture, 160, 120), pixel(picture, 314, 120));
  };
  CHECK(contrast(take(model, illustrated(camera))) > 100);
  // What a camera of the scene sees keeps the scene's colours.
  CHECK(contrast(take(model, request_of(camera))) < 10);
}

TEST_CASE("shapes have dark edges, and round ones an outline", "[rendering][illustrated]") {
  ModelBuilder builder;
  builder.box("box", Vec3(1, 1, 1), 1.0, at(0, 0, 0.5));
  builder.sphere("ball", 0.5, 1.0, at(0, 3, 0.5));
  const SceneModelPtr model = builder.build();
  const Camera camera =
      standard_camera(StandardView::iso, visible_bounds(frame_of(model)), 640, 480);
  const Picture plain = take(model, request_of(camera)), drawn = take(model, illustrated(camera));
  const Vec3 edge(0.5, 0.1, 1.0), face(0.5, 0.1, 0.5);
  CHECK(darkest(drawn, camera, edge) < 0.75 * darkest(plain, camera, edge));
  CHECK(darkest(drawn, camera, face) > 0.95 * darkest(plain, camera, face));
  // Half a pixel inside of the ball's silhouette, to the right of its middle in the picture.
  const Vec3 right = camera.X_WC.q * Vec3(0, -1, 0);
  const Vec3 ball(0, 3, 0.5);
  const double away = (ball - camera.X_WC.p).norm(), pixel_size = away / camera.fx;
  const Vec3 rim = ball + (0.5 - 0.5 * pixel_size) * right;
  CHECK(darkest(drawn, camera, rim) < 0.8 * darkest(drawn, camera, ball));
}

TEST_CASE("a floor fades into the sky, without an end", "[rendering][illustrated]") {
  ModelBuilder builder;
  builder.plane("floor", {}, colored(builder, 0.4, 0.3, 0.2));
  builder.box("box", Vec3(1, 1, 1), 1.0, at(0, 0, 0.5));
  const SceneModelPtr model = builder.build();
  const Camera camera =
      standard_camera(StandardView::front, visible_bounds(frame_of(model)), 320, 240);
  const auto steepest = [&](const Picture& picture) {
    int most = 0;
    for (int row = 1; row < picture.height; ++row)
      most = std::max(most, difference(pixel(picture, 2, row), pixel(picture, 2, row - 1)));
    return most;
  };
  RenderRequest bare = request_of(camera);
  bare.background.kind = Background::Kind::sky;
  CHECK(steepest(take(model, bare)) > 150);
  CHECK(steepest(take(model, illustrated(camera))) < 100);
}

TEST_CASE("a floor is darker where something stands on it, and bright colours are not cut off",
          "[rendering][illustrated]") {
  ModelBuilder builder;
  const int pale = colored(builder, 0.8, 0.8, 0.8), white = colored(builder, 1.0, 1.0, 1.0);
  builder.plane("floor", {}, pale);
  builder.box("box", Vec3(1, 1, 1), 1.0, at(0, 0, 0.5), white);
  builder.box("other", Vec3(1, 1, 1), 1.0, at(0, 4, 3.0), pale);
  const SceneModelPtr model = builder.build();
  const Camera camera = make_camera(look(Vec3(6, -3, 5), Vec3(0.5, 0.5, 0)), 320, 240, 0.8);
  const Picture drawn = take(model, illustrated(camera)), plain = take(model, request_of(camera));
  const auto brightness = [&](const Picture& picture, const Vec3& point) {
    const Eigen::Vector2d where = project(camera, point);
    return sum(pixel(picture, static_cast<int>(where.x()), static_cast<int>(where.y())));
  };
  // The light comes from +x: beside the box there, nothing is between floor and light. Between the
  // lines of the grid.
  const Vec3 foot(0.545, 0.05, 0.0), away(1.95, 0.05, 0.0), under_hanging(0.0, 4.05, 0.0);
  CHECK(brightness(drawn, foot) < brightness(drawn, away) - 30);
  CHECK(std::abs(brightness(plain, foot) - brightness(plain, away)) <= 6);
  // So high over the floor, a thing darkens nothing right under it; a little haze is between.
  CHECK(std::abs(brightness(drawn, under_hanging) - brightness(drawn, away)) <= 15);
  const Vec3 top(0.2, 0.2, 1.0);
  CHECK(brightness(plain, top) >= 3 * 254);
  CHECK(brightness(drawn, top) < 3 * 252);
  CHECK(brightness(drawn, top) > 3 * 225);
}

TEST_CASE("the view goes along with what moves, and rests where nothing does",
          "[rendering][framing]") {
  Moving one(1);
  Framing framing(one.frame);
  const geometry::Bounds start = framing.follow(one.frame);
  CHECK(framing.follow(one.frame).high == start.high);
  const double width = start.high.x() - start.low.x();
  double before = start.high.x(), fastest = 0.0;
  for (int i = 1; i <= 500; ++i) {
    const double x = 0.002 * i;
    const geometry::Bounds& shown = framing.follow(one.put(0, x));
    REQUIRE(shown.high.x() >= x + 0.1 - 1e-12);
    REQUIRE(shown.low.x() <= x - 0.1 + 1e-12);
    CHECK(shown.high.x() - shown.low.x() == Approx(width));
    fastest = std::max(fastest, shown.high.x() - before);
    before = shown.high.x();
  }
  CHECK(fastest == Approx(0.002).epsilon(0.01));
}

TEST_CASE("one of many that flies off is given up, and a single body never is",
          "[rendering][framing]") {
  Moving three(3);
  Framing framing(three.put(1, 0.5));
  const double limit = 10.0 * visible_bounds(three.frame).half().norm();
  CHECK(framing.follow(three.put(2, 1000.0)).half().norm() <= limit);
  CHECK(framing.single(three.frame).half().norm() <= limit);
  Moving one(1);
  Framing alone(one.frame);
  CHECK(alone.follow(one.put(0, 1000.0)).high.x() == Approx(1000.1));
}

}  // namespace
}  // namespace cogrsim::test
