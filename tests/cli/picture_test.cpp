// The subcommands that draw, as a user meets them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

#include <png.h>

#include <catch2/catch.hpp>

#include "cogrsim/core/image.h"
#include "process.h"

using Catch::Contains;
using cogrsim::Image;

namespace {

const std::string kRoom = std::string(COGRSIM_SCENES) + "/room.scene.xml";

using Arguments = std::vector<std::string>;

Outcome drawn(Arguments arguments) {
  arguments.insert(arguments.end(), {"--plugin-path", COGRSIM_TOYS});
  return cogrsim_run(arguments);
}

// One channel of 16 bits of a PNG, as `--depth` writes millimetres. load_image() keeps eight, which are 257 mm.
int depth_at(const std::string& path, png_uint_32 column, png_uint_32 row) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  INFO(path);
  REQUIRE(png_image_begin_read_from_file(&png, path.c_str()));
  REQUIRE((png.format & PNG_FORMAT_FLAG_LINEAR) != 0);  // else it has fewer bits
  png.format = PNG_FORMAT_LINEAR_Y;
  std::vector<png_uint_16> pixels(std::size_t{png.width} * png.height);
  REQUIRE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr));
  REQUIRE((column < png.width && row < png.height));
  return pixels[std::size_t{row} * png.width + column];
}

Image picture(const std::string& path) {
  const auto image = cogrsim::load_image(path);
  if (!image) FAIL(image.error().text());
  return *image;
}

}  // namespace

TEST_CASE("a picture is taken through a camera at a time", "[cli][pictures]") {
  const TemporaryFolder folder;
  const Outcome eye =
      drawn({"render", kRoom, "--camera", "eye", "--at", "0.5", "-o", folder / "eye.png"});
  INFO(eye.err);
  REQUIRE(eye.status == 0);
  CHECK(picture(folder / "eye.png").width == 64);
  CHECK(picture(folder / "eye.png").height == 48);

  const Outcome large = drawn({"render", kRoom, "--camera", "eye", "--at", "0.5", "--size",
                               "128x96", "-o", folder / "large.jpg"});
  REQUIRE(large.status == 0);
  CHECK(picture(folder / "large.jpg").width == 128);

  const Outcome bodies = drawn({"render", kRoom, "--view", "top", "--at", "0", "--segmentation",
                                "-o", folder / "bodies.png"});
  REQUIRE(bodies.status == 0);
  CHECK_THAT(bodies.out, Contains("pixels  crate") && Contains("pixels  floor"));

  // After 0.5 s the camera is at x = 0.45 m, the wall's near face at 1.95 m: 1500 mm, rounded to a whole one.
  const Outcome depth = drawn(
      {"render", kRoom, "--camera", "eye", "--at", "0.5", "--depth", "-o", folder / "depth.png"});
  REQUIRE(depth.status == 0);
  CHECK(std::abs(depth_at(folder / "depth.png", 32, 24) - 1500) <= 1);
}

TEST_CASE("a view on a body goes where the body goes", "[cli][pictures]") {
  const TemporaryFolder folder;
  // A cart flies along x at 1 m/s to a wall. Both views look along x from the same position at the
  // start, 3 m before the wall's near face; `front` alone is on the cart.
  const std::string scene = folder / "cart.scene.xml";
  std::ofstream(scene) << R"(<scene name="cart" version="1">
    <physics gravity="0 0 0"/>
    <box name="wall" size="0.1 4 4" xyz="3.25 0 0" static="true"/>
    <box name="cart" size="10 10 10 cm" mass="1 kg" linear-velocity="1 0 0"/>
    <view name="front" frame="cart" xyz="20 cm 0 0"/>
    <view name="start" xyz="20 cm 0 0"/>
  </scene>)";
  const auto depth = [&](const std::string& view, const std::string& at) {
    const std::string png = folder / (view + at + ".png");
    const Outcome outcome = drawn({"render", scene, "--backend", "toy", "--view", view, "--at", at,
                                   "--depth", "--size", "64x48", "-o", png});
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    return depth_at(png, 32, 24);  // [mm]
  };
  CHECK(std::abs(depth("front", "0") - 3000) <= 1);
  CHECK(std::abs(depth("front", "2") - 1000) <= 1);
  // The other sees the cart's back, 2 m - 5 cm - 20 cm ahead.
  CHECK(std::abs(depth("start", "2") - 1750) <= 1);

  // A recording knows it too.
  const std::string run = folder / "cart.mcap";
  REQUIRE(drawn({"run", scene, "--backend", "toy", "--duration", "2s", "--record", run}).status ==
          0);
  const std::string png = folder / "recorded.png";
  REQUIRE(drawn({"render", run, "--view", "front", "--at", "2", "--depth", "--size", "64x48", "-o",
                 png})
              .status == 0);
  CHECK(std::abs(depth_at(png, 32, 24) - 1000) <= 1);
}

TEST_CASE("a lidar's rays are a pale fan that hides nothing", "[cli][pictures]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "fan.scene.xml";
  std::ofstream(scene) << R"(<scene name="fan" version="1">
    <physics gravity="0 0 0" step="10 ms" duration="1 s"/>
    <plane name="floor"/>
    <box name="wall" size="0.1 4 1" xyz="2 0 0.5" static="true" color="#4070b0"/>
    <box name="cart" size="20 20 10 cm" mass="1 kg" xyz="0 0 0.2" color="#4070b0"/>
    <lidar name="scan" on="cart" xyz="0 0 0.1" rays="181" fov="180 deg" range="0.1 .. 5 m" rate="50 Hz"/>
  </scene>)";
  const std::string png = folder / "fan.png", bare = folder / "bare.png", map = folder / "map.png";
  const Arguments at = {"--backend", "toy", "--at", "0.1"};
  const auto make = [&](Arguments arguments) {
    arguments.insert(arguments.end(), at.begin(), at.end());
    const Outcome outcome = drawn(arguments);
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
  };
  make({"render", scene, "--size", "320x240", "--overlay", "rays", "-o", png});
  make({"render", scene, "--size", "320x240", "-o", bare});
  make({"map", scene, "--width", "320", "-o", map});
  const auto count = [](const Image& image, const auto& is) {
    int n = 0;
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < image.width; ++column) {
        n += is(image.pixel(column, row), column, row) ? 1 : 0;
      }
    }
    return n;
  };
  const auto red = [](const std::uint8_t* p, int, int) { return p[0] > p[2] + 60; };
  const Image with = picture(png), without = picture(bare), plan = picture(map);
  CHECK(count(with, red) == 0);
  CHECK(count(with, [&](const std::uint8_t* p, int column, int row) {
          return std::abs(p[0] - without.pixel(column, row)[0]) > 8;
        }) > 500);
  // On the map too, bluish over the light floor.
  CHECK(count(plan, red) == 0);
  CHECK(count(plan, [](const std::uint8_t* p, int, int) {
          return p[2] > p[0] + 15 && p[0] > 150;
        }) > 1000);
}

TEST_CASE("labels stand above what they name, and nothing hides them", "[render]") {
  const TemporaryFolder folder;
  const std::string scene = folder.write("names.scene.xml", R"(<scene name="names" version="1">
    <plane name="floor"/>
    <sphere name="ball" radius="0.5" xyz="0 -1.5 0.5"/>
    <assembly name="tower" xyz="0 1.5 0">
      <box name="low" size="1 1 1" xyz="0 0 0.5"/> <box name="high" size="1 1 1" xyz="0 0 1.5"/>
    </assembly>
  </scene>)");
  const auto with = [&](const Arguments& more) {
    Arguments all = {"render",     scene,   "--backend", "toy",     "--at", "0",
                     "--view",     "front", "--size",    "320x240", "-o",   folder / "names.png",
                     "--overwrite"};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = drawn(all);
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    return picture(folder / "names.png");
  };
  const Image bare = with({}), named = with({"--overlay", "labels"});
  // Columns in which something was written, in each half of the picture, and the lowest row of it.
  int columns[2] = {0, 0}, lowest[2] = {0, 0};
  for (int column = 0; column < bare.width; ++column) {
    bool written = false;
    const int half = column < bare.width / 2 ? 0 : 1;
    for (int row = 0; row < bare.height; ++row) {
      if (std::equal(bare.pixel(column, row), bare.pixel(column, row) + 3,
                     named.pixel(column, row)))
        continue;
      written = true;
      lowest[half] = std::max(lowest[half], row);
    }
    columns[half] += written ? 1 : 0;
  }
  CHECK(columns[0] > 10);
  CHECK(columns[1] > 10);
  // The tower is twice as high as the ball.
  CHECK(std::abs(lowest[0] - lowest[1]) > bare.height / 8);
}

TEST_CASE("maps and films of a scene", "[cli][pictures]") {
  const TemporaryFolder folder;
  const Outcome map = drawn({"map", kRoom, "--at", "0.5", "-o", folder / "map.png", "--width",
                             "300", "--trail", "crate"});
  INFO(map.err);
  REQUIRE(map.status == 0);
  CHECK(picture(folder / "map.png").width == 300);

  const Outcome gif = drawn(
      {"map", kRoom, "--at", "0.3", "--every", "0.1", "-o", folder / "map.gif", "--width", "200"});
  INFO(gif.err);
  REQUIRE(gif.status == 0);
  CHECK(read_file(folder / "map.gif").substr(0, 4) == "GIF8");
  const Outcome film = drawn({"render", kRoom, "--at", "0.2", "--every", "0.1", "--size", "65x49",
                              "-o", folder / "room.mp4"});
  INFO(film.err);
  REQUIRE(film.status == 0);
  CHECK(read_file(folder / "room.mp4").substr(4, 4) == "ftyp");
}

TEST_CASE("a report carries pictures of both backends and their maps", "[cli][pictures]") {
  const TemporaryFolder folder;
  const Outcome outcome = drawn({"compare", kRoom, "--backends", "toy,toy_euler", "--duration",
                                 "1s", "--threshold", "1mm", "--report", folder / "report.html"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const std::string page = read_file(folder / "report.html");
  CHECK_THAT(page, Contains("Divergence at") && Contains("The end, at 1 s") &&
                       Contains("data:image/png;base64,") && Contains("From above"));
  CHECK(page.find("No pictures") == std::string::npos);
}

TEST_CASE("wrong options for pictures are refused with a remedy", "[cli][pictures]") {
  const TemporaryFolder folder;
  const std::string png = folder / "x.png";
  const struct {
    Arguments arguments;
    int status;
    const char* text;
  } cases[] = {
      {{"render", kRoom}, 2, "output is required"},
      {{"render", kRoom, "-o", folder / "x.tiff"}, 2, "end it with .png"},
      {{"render", kRoom, "-o", folder / "x.gif"}, 2, "--every"},
      {{"render", kRoom, "-o", png, "--every", "0.1"}, 2, "for films"},
      {{"render", kRoom, "-o", png, "--size", "big"}, 2, "1280x720"},
      {{"render", kRoom, "-o", png, "--size", "0x10"}, 2, "1280x720"},
      {{"render", kRoom, "-o", png, "--at", "-1"}, 2, "from 0"},
      {{"render", kRoom, "-o", png, "--camera", "eye", "--view", "top"}, 2, "one viewpoint"},
      {{"render", kRoom, "-o", png, "--depth", "--segmentation"}, 2, "two pictures"},
      {{"render", kRoom, "-o", png, "--overlay", "ray"}, 2, "did you mean 'rays'"},
      {{"render", kRoom, "-o", png, "--camera", "eyes"}, 1, "did you mean 'eye'"},
      {{"render", kRoom, "-o", png, "--view", "topp"}, 1, "did you mean 'top'"},
      {{"render", kRoom, "-o", png, "--size", "100000x100000"}, 1, "limit"},
      {{"render", kRoom, "-o", folder / "x.gif", "--every", "1ns", "--at", "1"},
       1,
       "larger --every"},
      {{"map", kRoom, "-o", folder / "x.gif", "--every", "1ns", "--at", "1"}, 1, "larger --every"},
      {{"render", folder / "none.mcap", "-o", png}, 1, "none.mcap"},
      {{"render", folder / "none.mcap", "-o", png, "--backend", "toy"}, 2, "recording"},
      {{"map", kRoom, "-o", folder / "no/where.png"}, 1, "no/where.png"},
      {{"map", kRoom, "-o", png, "--area", "1,2,3"}, 2, "lower left"},
      {{"map", kRoom, "-o", png, "--width", "5"}, 2, "64"},
      {{"map", kRoom, "-o", png, "--trail", "crat"}, 1, "did you mean 'crate'"},
      {{"map", kRoom, "-o", folder / "x.bmp"}, 1, ".svg, .png or .pdf"},
  };
  for (const auto& c : cases) {
    const Outcome outcome = drawn(c.arguments);
    std::string line;
    for (const std::string& argument : c.arguments) line += argument + " ";
    INFO(line << "\n" << outcome.err);
    CHECK(outcome.status == c.status);
    CHECK_THAT(outcome.err, Contains(c.text));
  }
  CHECK(folder.files().empty());
}
