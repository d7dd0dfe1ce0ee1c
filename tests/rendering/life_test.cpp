// Many cameras, several renderers, models that change.
#include <catch2/catch.hpp>

#include <cmath>
#include <thread>

#include "support.h"

namespace cogrsim::test {
namespace {

SceneModelPtr one_ball(double distance) {
  ModelBuilder builder;
  builder.sphere("ball", 0.5, 1.0, at(distance, 0, 0), colored(builder, 0.9, 0.3, 0.1));
  return builder.build();
}

TEST_CASE("many cameras in one call see what each would see alone", "[rendering]") {
  ModelBuilder builder;
  const int white = colored(builder, 1, 1, 1);
  builder.sphere("ball", 0.5, 1.0, at(0, 0, 0.5), white);
  builder.box("box", Vec3(0.4, 0.6, 0.8), 1.0, at(0, 1.2, 0.4), white);
  builder.plane("floor", {}, white);
  const SceneModelPtr model = builder.build();
  std::vector<RenderRequest> requests;
  for (int i = 0; i < 7; ++i) {
    const double angle = 0.9 * i;
    const Vec3 eye(3 * std::cos(angle), 3 * std::sin(angle), 1.0);
    requests.push_back(request_of(make_camera(look(eye, Vec3(0, 0, 0.3)), 60 + 7 * i, 50, 0.9)));
    requests.back().shadows = i % 2 == 0;
    requests.back().samples = i % 3 == 0 ? 1 : 4;
  }
  const auto all = renderer().render(frame_of(model), requests);
  REQUIRE(all);
  REQUIRE(all->size() == requests.size());
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const Picture alone = take(model, requests[i]);
    CHECK((*all)[i].width == requests[i].camera.width);
    CHECK((*all)[i].color.data == alone.color.data);
    CHECK((*all)[i].depth == alone.depth);
    CHECK((*all)[i].bodies == alone.bodies);
  }
}

TEST_CASE("no request gives no picture", "[rendering]") {
  const auto none = renderer().render(frame_of(one_ball(2)), {});
  REQUIRE(none);
  CHECK(none->empty());
}

TEST_CASE("bodies that move are drawn where they went", "[rendering]") {
  Frame frame = frame_of(one_ball(2));
  const RenderRequest request = request_of(make_camera(Pose(), 32, 32, 0.8));
  const auto near = renderer().render(frame, {request});
  frame.state.poses[0].p.x() = 4.0;
  const auto far = renderer().render(frame, {request});
  REQUIRE((near && far));
  // The pixel's middle lies half a pixel off the axis, where the farther ball is 4 mm rounder.
  CHECK(depth_at((*near)[0], 16, 16) == Approx(1.5).epsilon(2e-3));
  CHECK(depth_at((*far)[0], 16, 16) == Approx(3.5).epsilon(2e-3));
}

TEST_CASE("added bodies appear and removed ones disappear", "[rendering]") {
  const SceneModelPtr first = one_ball(3);
  const RenderRequest request = request_of(make_camera(Pose(), 32, 32, 0.8));
  CHECK(body_at(take(first, request), 16, 16) == 0);
  // As a run does it: the old bodies keep their index, a new one is added at the end.
  auto grown = std::make_shared<SceneModel>(*first);
  Body added = grown->bodies[0];
  added.name = "added";
  added.X_WB.p.x() = 2.0;
  grown->bodies.push_back(added);
  CHECK(body_at(take(grown, request), 16, 16) == 1);
  auto shrunk = std::make_shared<SceneModel>(*grown);
  shrunk->bodies[1].removed = true;
  CHECK(body_at(take(shrunk, request), 16, 16) == 0);
  shrunk = std::make_shared<SceneModel>(*shrunk);
  shrunk->bodies[0].removed = true;
  CHECK(body_at(take(shrunk, request), 16, 16) == -1);
  CHECK(body_at(take(first, request), 16, 16) == 0);
}

TEST_CASE("a scene without bodies is background", "[rendering]") {
  ModelBuilder builder;
  const SceneModelPtr model = builder.build();
  RenderRequest request = request_of(make_camera(Pose(), 32, 32, 0.8));
  request.background.color = {0.2, 0.4, 0.6, 1};
  const Picture plain = take(model, request);
  CHECK(pixel(plain, 5, 5).r == 51);
  CHECK(pixel(plain, 5, 5).g == 102);
  CHECK(pixel(plain, 5, 5).b == 153);
  CHECK(count_body(plain, -1) == 32 * 32);
  // The sky is bluer above than at the horizon.
  request.background.kind = Background::Kind::sky;
  const Picture sky = take(model, request);
  CHECK(pixel(sky, 16, 0).r < pixel(sky, 16, 15).r);
  CHECK(pixel(sky, 16, 0).b > pixel(sky, 16, 0).r);
}

TEST_CASE("two renderers work side by side from two threads", "[rendering]") {
  PluginLoader loader;
  auto one = load_renderer(loader), other = load_renderer(loader, "osmesa");
  REQUIRE((one && other));
  const RenderRequest request = request_of(make_camera(Pose(), 48, 48, 0.8));
  float depths[2] = {0, 0};
  const auto work = [&](Renderer& own, double distance, float& depth) {
    for (int i = 0; i < 5; ++i) {
      const auto pictures = own.render(frame_of(one_ball(distance)), {request});
      depth = pictures ? depth_at((*pictures)[0], 24, 24) : -1.0F;
    }
  };
  std::thread a([&] { work(**one, 2.0, depths[0]); });
  std::thread b([&] { work(**other, 5.0, depths[1]); });
  a.join();
  b.join();
  CHECK(depths[0] == Approx(1.5).epsilon(1e-3));
  CHECK(depths[1] == Approx(4.5).epsilon(1e-3));
  // One goes, the other stays.
  one->reset();
  CHECK((*other)->render(frame_of(one_ball(2)), {request}));
}

TEST_CASE("a renderer can be released with its loader and loaded again", "[rendering]") {
  const RenderRequest request = request_of(make_camera(Pose(), 32, 32, 0.8));
  for (int i = 0; i < 3; ++i) {
    std::shared_ptr<Renderer> made;
    {
      PluginLoader loader;
      auto loaded = load_renderer(loader);
      REQUIRE(loaded);
      made = *loaded;
    }
    const auto pictures = made->render(frame_of(one_ball(2)), {request});
    REQUIRE(pictures);
    CHECK(body_at((*pictures)[0], 16, 16) == 0);
  }
}

TEST_CASE("things behind glass are visible", "[rendering]") {
  ModelBuilder builder;
  const int glass = colored(builder, 0, 0, 1);
  builder.model.materials[glass].color.a = 0.4;
  builder.box("pane", Vec3(0.05, 1, 1), 1.0, at(1, 0, 0), glass);
  builder.box("wall", Vec3(0.1, 9, 9), 1.0, at(3, 0, 0), colored(builder, 1, 0, 0));
  const Picture picture = take(builder.build(), request_of(make_camera(Pose(), 32, 32, 0.5)));
  const Rgb middle = pixel(picture, 16, 16);
  CHECK(middle.r > 60);
  CHECK(middle.b > 40);
  CHECK(middle.g < 10);
  CHECK(body_at(picture, 16, 16) == 0);  // seen by depth and labels as a body
}

}  // namespace
}  // namespace cogrsim::test
