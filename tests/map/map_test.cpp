// The drawing agrees with pictures of the same frame, and refuses what it cannot draw.
#include <unistd.h>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include <tinyxml2.h>
#include <catch2/catch.hpp>

#include "../support/temporary_folder.h"
#include "cogrsim/core/image.h"
#include "cogrsim/map/map.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/rendering/renderer.h"
#include "cogrsim/sensing/sensor_rays.h"

using namespace cogrsim;

namespace {

Quat turned(double angle, const Vec3& axis) { return Quat(Eigen::AngleAxisd(angle, axis)); }

Frame frame_of(SceneModelPtr model) {
  Frame frame;
  for (const Body& body : model->bodies) frame.state.poses.push_back(body.X_WB);
  frame.state.twists.resize(model->bodies.size());
  frame.model = std::move(model);
  return frame;
}

int color(ModelBuilder& builder, const std::string& name, double r, double g, double b) {
  const int material = builder.material(name, 0.5);
  builder.model.materials[material].color = {r, g, b, 1};
  return material;
}

// One of every kind of shape, none over another.
Frame some_of_everything() {
  ModelBuilder builder("all shapes");
  const int red = color(builder, "red", 0.8, 0.1, 0.1),
            blue = color(builder, "blue", 0.1, 0.2, 0.9);
  const int green = color(builder, "green", 0.1, 0.6, 0.2);
  builder.plane("floor");
  builder.box("box", {0.5, 0.3, 0.2}, 1.0, {{-1.2, 0.8, 0.3}, turned(0.7, {0.6, 0, 0.8})}, red);
  builder.sphere("ball", 0.2, 1.0, {{0, 0.8, 0.2}, Quat(1, 0, 0, 0)}, blue);
  builder.cylinder("drum", 0.15, 0.5, 1.0, {{1.2, 0.8, 0.4}, turned(1.0, {0, 1, 0})}, green);
  builder.capsule("bar", 0.1, 0.4, 1.0, {{-1.2, -0.8, 0.2}, turned(1.57, {1, 0, 0})}, blue);
  TriangleMesh wedge;
  wedge.vertices = {{-0.3, -0.2, 0}, {0.3, -0.2, 0}, {0, 0.3, 0}, {0, 0, 0.4}};
  wedge.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  builder.mesh("wedge", wedge, true, 1.0, {{0, -0.8, 0}, turned(0.5, {0, 0, 1})}, red);
  builder.mesh("tent", wedge, false, 0.0, {{1.2, -0.8, 0}, turned(-0.4, {0, 0, 1})}, green);
  return frame_of(builder.build());
}

bool inside(const std::vector<Eigen::Vector2d>& polygon, double x, double y) {
  bool in = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const auto &a = polygon[i], &b = polygon[j];
    if ((a.y() > y) != (b.y() > y) && x < (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y()) + a.x()) {
      in = !in;
    }
  }
  return in;
}

std::shared_ptr<Renderer> renderer() {
  static const std::shared_ptr<Renderer> made = [] {
    static PluginLoader loader;
    auto loaded = load_renderer(loader);
    if (!loaded) FAIL(loaded.error().text());
    return *loaded;
  }();
  return made;
}

using Folder = cogrsim::test::TemporaryFolder;

}  // namespace

TEST_CASE("the map agrees with a camera high above", "[map]") {
  const Frame frame = some_of_everything();
  // From 400 m a body 0.6 m high is shifted by at most 0.6 / 400 of its distance from the middle
  // (1.7 m), 2.6 mm; a pixel is 3.4 m / 680 = 5 mm. Pixels within 8 mm of an outline may go either
  // way.
  constexpr double kHeight = 400.0, kWidth = 3.4, kUnsure = 8e-3;
  constexpr int kPixels = 680;
  RenderRequest request;
  Mat3 down;  // looks along -z, y up in the picture, x to the right
  down.col(0) = -Vec3::UnitZ();
  down.col(1) = -Vec3::UnitX();
  down.col(2) = Vec3::UnitY();
  request.camera = make_camera({{0, 0, kHeight}, Quat(down)}, kPixels, kPixels,
                               2.0 * std::atan(0.5 * kWidth / kHeight));
  request.camera.near = kHeight - 5.0;
  request.camera.far = kHeight + 5.0;
  request.color = false;
  request.segmentation = true;
  const auto pictures = renderer()->render(frame, {request});
  REQUIRE(pictures);
  const Picture& picture = pictures->front();

  std::vector<std::vector<std::vector<Eigen::Vector2d>>> outlines;
  for (std::size_t b = 0; b < frame.model->bodies.size(); ++b) {
    const Body& body = frame.model->bodies[b];
    outlines.push_back(plan_outline(*frame.model, body.shapes[0], frame.state.poses[b]));
  }
  const auto body_at = [&](double x, double y) {
    for (std::size_t b = 1; b < outlines.size(); ++b) {
      for (const auto& polygon : outlines[b]) {
        if (inside(polygon, x, y)) return static_cast<int>(b);
      }
    }
    return 0;  // the floor
  };
  std::vector<int> seen(outlines.size(), 0);
  int wrong = 0, unsure = 0;
  for (int row = 0; row < kPixels; ++row) {
    for (int column = 0; column < kPixels; ++column) {
      const double x = ((column + 0.5) / kPixels - 0.5) * kWidth;
      const double y = (0.5 - (row + 0.5) / kPixels) * kWidth;
      const int expected = body_at(x, y);
      bool sure = true;
      for (const double dx : {-kUnsure, 0.0, kUnsure}) {
        for (const double dy : {-kUnsure, 0.0, kUnsure}) {
          sure = sure && body_at(x + dx, y + dy) == expected;
        }
      }
      if (!sure) {
        ++unsure;
        continue;
      }
      ++seen[expected];
      wrong += picture.bodies[row * kPixels + column] != expected;
    }
  }
  CHECK(wrong == 0);
  CHECK(unsure < kPixels * kPixels / 20);
  for (std::size_t b = 0; b < seen.size(); ++b) {
    INFO(frame.model->bodies[b].name);
    CHECK(seen[b] > 500);
  }
}

TEST_CASE("bodies are drawn in their colours, at their positions", "[map]") {
  const Frame frame = some_of_everything();
  MapOptions options;
  options.width = 800;
  options.names = options.grid = false;
  options.area = MapArea{-2, -1.5, 2, 1.5};
  const auto bytes = map_picture(frame, options, ".png");
  REQUIRE(bytes);
  const auto image = decode_image(*bytes);
  REQUIRE(image);
  REQUIRE(image->width == 800);
  REQUIRE(image->height == 600);
  for (std::size_t b = 1; b < frame.model->bodies.size(); ++b) {
    const Body& body = frame.model->bodies[b];
    INFO(body.name);
    const int column = static_cast<int>((frame.state.poses[b].p.x() + 2.0) * 200.0);
    const int row = static_cast<int>((1.5 - frame.state.poses[b].p.y()) * 200.0);
    const std::uint8_t* pixel = image->pixel(column, row);
    const Color& c = frame.model->materials[body.shapes[0].material].color;
    CHECK(std::abs(pixel[0] - 255.0 * c.r) <= 1.0);
    CHECK(std::abs(pixel[1] - 255.0 * c.g) <= 1.0);
    CHECK(std::abs(pixel[2] - 255.0 * c.b) <= 1.0);
  }
}

TEST_CASE("higher bodies cover lower ones", "[map]") {
  for (const bool swapped : {false, true}) {
    ModelBuilder builder;
    const int red = color(builder, "red", 1, 0, 0), blue = color(builder, "blue", 0, 0, 1);
    builder.box("a", {1, 1, 0.1}, 1.0, {{0, 0, swapped ? 2.0 : 0.0}, Quat(1, 0, 0, 0)}, red);
    builder.box("b", {1, 1, 0.1}, 1.0, {{0, 0, swapped ? 0.0 : 2.0}, Quat(1, 0, 0, 0)}, blue);
    MapOptions options;
    options.names = options.grid = false;
    const auto bytes = map_picture(frame_of(builder.build()), options, ".png");
    REQUIRE(bytes);
    const auto image = decode_image(*bytes);
    REQUIRE(image);
    const std::uint8_t* pixel = image->pixel(image->width / 2, image->height / 2);
    CHECK(pixel[0] == (swapped ? 255 : 0));
    CHECK(pixel[2] == (swapped ? 0 : 255));
  }
}

TEST_CASE("a trail is dashed, with gaps where there is no point", "[map]") {
  ModelBuilder builder;
  builder.box("mark", {0.01, 0.01, 0.01}, 1.0, {{-0.9, -0.9, 0}, Quat(1, 0, 0, 0)});
  MapTrail trail;
  trail.color = {0, 0, 1, 1};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  trail.points = {{-0.8, 0, 0}, {-0.2, 0, 0}, {nan, nan, nan}, {0.2, 0, 0}, {0.8, 0, 0}};
  MapOptions options;
  options.width = 1000;
  options.names = options.grid = false;
  options.area = MapArea{-1, -1, 1, 1};
  options.trails = {trail};
  const auto bytes = map_picture(frame_of(builder.build()), options, ".png");
  REQUIRE(bytes);
  const auto image = decode_image(*bytes);
  REQUIRE(image);
  const auto blue = [&](double x) {
    const std::uint8_t* p = image->pixel(static_cast<int>((x + 1.0) * 500.0), 500);
    return p[2] > 200 && p[0] < 150;
  };
  int on = 0, off = 0, in_the_gap = 0;
  for (double x = -0.75; x < -0.25; x += 0.002) (blue(x) ? on : off) += 1;
  for (double x = -0.15; x < 0.15; x += 0.002) in_the_gap += blue(x);
  // Seven pixels on, four off.
  CHECK(on / static_cast<double>(on + off) == Approx(7.0 / 11.0).margin(0.1));
  CHECK(in_the_gap == 0);
}

TEST_CASE("the fan of a lidar lies where it measured, and over no wall that it met", "[map]") {
  ModelBuilder builder;
  const int red = color(builder, "red", 1, 0, 0);
  const int body = builder.box("robot", {0.1, 0.1, 0.1}, 1.0, {{0, 0, 0.05}, Quat(1, 0, 0, 0)});
  builder.box("wall", {0.2, 4, 0.4}, 0.0, {{1.1, 0, 0.2}, Quat(1, 0, 0, 0)}, red);
  builder.box("step", {0.2, 0.2, 0.1}, 0.0, {{0.6, 0, 0.05}, Quat(1, 0, 0, 0)}, red);
  SensorModel lidar;
  lidar.name = lidar.type = "lidar";
  lidar.body = body;
  lidar.X_BS = {{0, 0, 0.1}, Quat(1, 0, 0, 0)};
  constexpr int kRays = 3;
  lidar.parameters["rays"] = std::int64_t{kRays};
  lidar.parameters["fov"] = 1.0;
  builder.model.sensors.push_back(lidar);
  Frame frame = frame_of(builder.build());
  // It measured the wall, 1 m in front of it, and has turned and moved on since.
  Reading reading;
  reading.sensor = 0;
  reading.sequence = 1;
  reading.valid = true;
  reading.values = {1.0 / std::cos(0.5), 1.0, 1.0 / std::cos(0.5)};
  reading.pose = Pose({0, 0, 0.15}, Quat(1, 0, 0, 0));
  frame.readings = {reading};
  frame.state.poses[body] = {{-0.3, -0.9, 0.05}, turned(0.4, {0, 0, 1})};
  MapOptions options;
  options.width = 800;
  options.names = options.grid = false;
  options.area = MapArea{-2, -2, 2, 2};
  options.rays = sensor_rays(frame);
  REQUIRE(options.rays.size() == kRays);
  const auto bytes = map_picture(frame, options, ".png");
  REQUIRE(bytes);
  const auto image = decode_image(*bytes);
  REQUIRE(image);
  const auto at = [&](double x, double y) {
    return image->pixel(static_cast<int>((x + 2.0) * 200.0), static_cast<int>((2.0 - y) * 200.0));
  };
  const auto fan = [&](double x, double y) { return at(x, y)[2] > at(x, y)[0] + 20; };
  for (const double x : {0.1, 0.4, 0.9}) {
    const double edge = x * std::tan(0.5);
    CHECK(fan(x, 0.8 * edge));
    CHECK(fan(x, -0.8 * edge));
    CHECK_FALSE(fan(x, 1.2 * edge));
    CHECK_FALSE(fan(x, -1.2 * edge));
  }
  CHECK_FALSE(fan(-0.3, -0.8));
  // Nothing of it in the wall; the step, which is lower than the lidar, is seen through it.
  for (double y = -0.5; y < 0.5; y += 0.1) {
    CHECK(at(1.1, y)[0] == 255);
    CHECK(at(1.1, y)[2] == 0);
  }
  CHECK(at(0.6, 0.0)[0] > 150);
  CHECK(at(0.6, 0.0)[2] > 20);
  // The points that were hit are dark.
  CHECK(at(1.0, 0.0)[2] > 60);
  CHECK(at(1.0, 0.0)[0] < 150);
}

TEST_CASE("SVG and PDF files are valid", "[map]") {
  const Frame frame = some_of_everything();
  MapOptions options;
  options.title = "<all> & \"every\" shape";
  const auto svg = map_picture(frame, options, ".svg");
  REQUIRE(svg);
  tinyxml2::XMLDocument document;
  REQUIRE(document.Parse(svg->data(), svg->size()) == tinyxml2::XML_SUCCESS);
  CHECK(std::string(document.RootElement()->Name()) == "svg");
  const auto pdf = map_picture(frame, options, ".pdf");
  REQUIRE(pdf);
  CHECK(pdf->compare(0, 5, "%PDF-") == 0);
}

TEST_CASE("impossible maps are refused with a remedy", "[map]") {
  const Frame frame = some_of_everything();
  const Folder folder;
  const auto message = [](const Result<>& result) {
    REQUIRE_FALSE(result);
    return result.error().text();
  };
  MapOptions options;
  CHECK_THAT(message(draw_map(frame, options, folder / "map.bmp")),
             Catch::Contains("'.bmp'") && Catch::Contains(".svg, .png or .pdf"));
  CHECK_THAT(message(draw_map(frame, options, folder / "none/map.png")),
             Catch::Contains("none/map.png"));
  options.width = 10;
  CHECK_THAT(message(draw_map(frame, options, folder / "map.png")), Catch::Contains("64 to 8000"));
  options.width = 400;
  options.area = MapArea{1, 0, 1, 1};
  CHECK_THAT(message(draw_map(frame, options, folder / "map.png")), Catch::Contains("empty"));
  options.area = MapArea{0, 0, std::numeric_limits<double>::infinity(), 1};
  CHECK_THAT(message(draw_map(frame, options, folder / "map.png")), Catch::Contains("empty"));
  CHECK_FALSE(std::filesystem::exists(folder / "map.png"));
}

TEST_CASE("a body that flew off to infinity does not spoil the map", "[map]") {
  Frame frame = some_of_everything();
  frame.state.poses[1].p.x() = std::numeric_limits<double>::quiet_NaN();
  const auto bytes = map_picture(frame, {}, ".png");
  REQUIRE(bytes);
  CHECK(decode_image(*bytes));
}
