// What gnuplot makes of figures: files of the right kind, ink where the data is, nothing run.
#include <cstdlib>

#include <cmath>

#include <tinyxml2.h>
#include <catch2/catch.hpp>

#include "cogrsim/core/image.h"
#include "cogrsim/core/output_file.h"
#include "support.h"

using namespace cogrsim::figures;
using cogrsim::Image;

namespace {

struct Rgb {
  int r, g, b;
};
constexpr Rgb kFirst{0x00, 0x72, 0xbd};   // of the first series
constexpr Rgb kSecond{0xd9, 0x53, 0x19};  // of the second, and of medians

Image picture(const Figure& figure, const Folder& folder) {
  const std::string path = folder / "figure.png";
  drawn(figure, path);
  auto image = cogrsim::load_image(path);
  REQUIRE(image);
  return *image;
}

/// Whether a pixel has the colour, give or take the smoothing of edges.
bool has(const Image& image, int column, int row, const Rgb& color) {
  const std::uint8_t* p = image.pixel(column, row);
  constexpr int kNear = 24;
  return std::abs(p[0] - color.r) <= kNear && std::abs(p[1] - color.g) <= kNear &&
         std::abs(p[2] - color.b) <= kNear;
}

/// Pixels of a colour within a part of the picture, given in fractions from the upper left.
int ink(const Image& image, const Rgb& color, double left = 0, double top = 0, double right = 1,
        double bottom = 1) {
  int count = 0;
  for (int row = static_cast<int>(top * image.height); row < bottom * image.height; ++row)
    for (int column = static_cast<int>(left * image.width); column < right * image.width; ++column)
      count += has(image, column, row, color) ? 1 : 0;
  return count;
}

std::vector<double> ramp(int count) {
  std::vector<double> x;
  for (int i = 0; i < count; ++i) x.push_back(i);
  return x;
}

}  // namespace

TEST_CASE("a curve has its ink where its data is", "[drawing]") {
  const Folder folder;
  // From the lower left to the upper right; the other two corners stay empty.
  const Image image = picture(curve(ramp(100), ramp(100)), folder);
  CHECK(image.width == 960);
  CHECK(image.height == 640);
  // The diagonal of the axes is about 1000 pixels long.
  CHECK(ink(image, kFirst) > 700);
  CHECK(ink(image, kFirst, 0, 0.6, 0.4, 1) > 150);
  CHECK(ink(image, kFirst, 0.6, 0, 1, 0.4) > 150);
  CHECK(ink(image, kFirst, 0, 0, 0.4, 0.4) == 0);
  CHECK(ink(image, kFirst, 0.6, 0.6, 1, 1) == 0);
}

TEST_CASE("a gap is a gap and a single point is seen", "[drawing]") {
  const Folder folder;
  std::vector<double> y(101, 1.0);
  for (std::size_t i = 30; i < 70; ++i) y[i] = kNaN;
  Figure figure = curve(ramp(101), y);
  figure.y.minimum = 0;
  figure.y.maximum = 2;
  const Image gap = picture(figure, folder);
  CHECK(ink(gap, kFirst, 0.1, 0, 0.3, 1) > 100);
  CHECK(ink(gap, kFirst, 0.75, 0, 0.95, 1) > 100);
  CHECK(ink(gap, kFirst, 0.4, 0, 0.65, 1) == 0);
  figure.series[0].y[50] = 1.0;
  CHECK(ink(picture(figure, folder), kFirst, 0.4, 0, 0.65, 1) > 5);
}

TEST_CASE("a path is drawn in equal scales", "[drawing]") {
  const Folder folder;
  std::vector<double> x, y;
  for (int i = 0; i <= 400; ++i) {
    x.push_back(std::cos(i * 0.0157));
    y.push_back(std::sin(i * 0.0157));
  }
  Figure figure = map(x, y);
  figure.legend = false;
  const Image image = picture(figure, folder);
  int left = image.width, right = 0, top = image.height, bottom = 0;
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column)
      if (has(image, column, row, kFirst)) {
        left = std::min(left, column);
        right = std::max(right, column);
        top = std::min(top, row);
        bottom = std::max(bottom, row);
      }
  REQUIRE(right - left > 300);
  // A circle; the mark at its start adds half of its 10 or so pixels on the right.
  CHECK(std::abs((right - left) - (bottom - top)) <= 12);
}

TEST_CASE("boxes show median, box and outliers at their heights", "[drawing]") {
  const Folder folder;
  Figure figure = box({{1, 2, 3, 4, 5, 6, 7, 8, 9, 30}});
  figure.y.minimum = 0;
  figure.y.maximum = 40;
  const Image image = picture(figure, folder);
  // 5.5 of 40 lies at an eighth of the axes' height, from below.
  CHECK(ink(image, kSecond, 0, 0.75, 1, 0.92) > 200);
  CHECK(ink(image, kSecond, 0, 0, 1, 0.7) == 0);
  CHECK(ink(image, kFirst, 0, 0.7, 1, 1) > 400);
  CHECK(ink(image, {0xa2, 0x14, 0x2f}, 0.4, 0.15, 0.6, 0.35) > 8);  // the outlier
}

TEST_CASE("bars stand where the samples are", "[drawing]") {
  const Folder folder;
  std::vector<double> samples(90, 1.0);
  samples.insert(samples.end(), 10, 4.0);
  const Image image = picture(histogram(samples), folder);
  const Rgb bar{77, 157, 209};  // the first colour at 0.7 on white
  CHECK(ink(image, bar, 0, 0, 0.35, 1) > 20000);
  CHECK(ink(image, bar, 0.35, 0, 0.7, 1) == 0);
  const int low = ink(image, bar, 0.7, 0, 1, 1);
  CHECK(low > 2000);
  CHECK(low < ink(image, bar, 0, 0, 0.35, 1) / 5);
}

TEST_CASE("a surface is coloured by its values", "[drawing]") {
  const Folder folder;
  const Image image =
      picture(surface_of({0, 1, 2}, {0, 1, 2}, {0, 0, 0, 0, 0, 0, 0, 0, 1}), folder);
  CHECK(ink(image, {0x44, 0x01, 0x54}, 0.1, 0, 0.85, 1) > 10000);  // dark: 0
  CHECK(ink(image, {0xfd, 0xe7, 0x25}, 0.1, 0, 0.85, 1) > 2000);   // bright: 1
}

TEST_CASE("every format agrees with its name, with script, data and figure beside it",
          "[drawing]") {
  const Folder folder;
  Figure figure = curve({0, 1, 2}, {0, 1, 4}, "first");
  add_series(figure, {0, 1, 2}, {4, 1, 0}, "second");
  for (const std::string format : {"png", "svg", "pdf"})
    CHECK(drawn(figure, folder / ("speed." + format)).front() == folder / ("speed." + format));
  CHECK(folder.files() == std::vector<std::string>{"speed-1.csv", "speed-2.csv", "speed.gp",
                                                   "speed.json", "speed.pdf", "speed.png",
                                                   "speed.svg"});
  CHECK(content(folder / "speed.png").substr(1, 3) == "PNG");
  CHECK(content(folder / "speed.pdf").substr(0, 5) == "%PDF-");
  tinyxml2::XMLDocument svg;
  CHECK(svg.LoadFile((folder / "speed.svg").c_str()) == tinyxml2::XML_SUCCESS);
  REQUIRE(svg.RootElement() != nullptr);
  CHECK(std::string(svg.RootElement()->Name()) == "svg");
  CHECK(drawn(figure, folder / "UPPER.PNG").size() == 5);
  CHECK(content(folder / "UPPER.PNG").substr(1, 3) == "PNG");
  CHECK(drawn(figure, folder / "alone.json") == std::vector<std::string>{folder / "alone.json"});
  CHECK(figure_from_json(content(folder / "alone.json")));
}

TEST_CASE("the script draws the same picture by itself", "[drawing]") {
  for (const Kind kind : {Kind::curve, Kind::box, Kind::histogram, Kind::surface, Kind::map}) {
    const Folder folder;
    Figure figure = curve({0, 1, 2, 3}, {0, 1, 4, 2});
    figure.kind = kind;
    figure.series[0].z = {1, 2, 3, 4};
    drawn(figure, folder / "it.png");
    const std::string before = content(folder / "it.png");
    std::filesystem::remove(folder / "it.png");
    REQUIRE(std::system(("cd '" + folder.path.string() + "' && gnuplot it.gp 2>&1").c_str()) == 0);
    CHECK(cogrsim::marked(cogrsim::OutputKind::png, content(folder / "it.png")) == before);
  }
}

TEST_CASE("nothing in a title or label is run or taken for markup", "[drawing]") {
  const std::string evil =
      "`touch pwned` $(touch pwned) \"; system('touch pwned'); ' ! touch pwned | @x %d %s _a^b "
      "{/=40 big} <b>&amp; \\n \\";
  for (const Kind kind : {Kind::curve, Kind::box, Kind::histogram, Kind::surface, Kind::map}) {
    const Folder folder;
    Figure figure = curve({0, 1, 2}, {0, 1, 4}, evil);
    figure.kind = kind;
    figure.name = figure.title = evil + "\nsystem(\"touch pwned\")\r\n\x01\xff";
    figure.x = figure.y = figure.z = {evil, evil};
    figure.series[0].z = {1, 2, 3};
    figure.legend = true;
    for (const std::string format : {"png", "pdf", "svg"}) drawn(figure, folder / ("f." + format));
    for (const std::string& file : folder.files()) CHECK(file.substr(0, 1) == "f");
    tinyxml2::XMLDocument svg;
    REQUIRE(svg.LoadFile((folder / "f.svg").c_str()) == tinyxml2::XML_SUCCESS);
    const std::string text = content(folder / "f.svg");
    // As it was written, but for what XML must escape.
    CHECK(text.find("%d %s _a^b {/=40 big} &lt;b>&amp;amp; \\n \\") != std::string::npos);
    CHECK(text.find("`touch pwned` $(touch pwned)") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists("pwned"));
  }
}

TEST_CASE("nothing in a file's name is run", "[drawing]") {
  const Folder folder;
  const Figure figure = curve({0, 1}, {0, 1});
  for (const std::string name : {"<touch pwned", "|touch pwned", "`touch pwned`", "-e", "a'b\"c\\d",
                                 "$(touch pwned)", "100%d"}) {
    drawn(figure, folder / (name + ".png"));
    CHECK(content(folder / (name + ".png")).substr(1, 3) == "PNG");
    CHECK_FALSE(std::filesystem::exists(folder / "pwned"));
  }
}

TEST_CASE("without gnuplot the message names the package", "[drawing]") {
  const Folder folder;
  const std::string before = getenv("PATH");
  setenv("PATH", folder.path.string().c_str(), 1);
  const auto none = draw(curve({0, 1}, {0, 1}), folder / "a.png");
  const auto json = draw(curve({0, 1}, {0, 1}), folder / "b.json");
  setenv("PATH", before.c_str(), 1);
  REQUIRE_FALSE(none);
  CHECK(none.error().text().find("gnuplot-nox") != std::string::npos);
  CHECK(json);
  CHECK(figure_from_json(content(folder / "a.json")));
}

TEST_CASE("paths that cannot be written are refused", "[drawing]") {
  const Folder folder;
  const Figure figure = curve({0, 1}, {0, 1});
  CHECK(draw(figure, folder / "a.bmp").error().hint.find(".svg") != std::string::npos);
  CHECK(draw(figure, folder / "none").error().hint.find(".png") != std::string::npos);
  CHECK(draw(figure, folder / "no/where.png").error().message.find("no folder") !=
        std::string::npos);
  DrawOptions huge;
  huge.width = 1000000;
  CHECK_FALSE(draw(figure, folder / "a.png", huge));
  CHECK(folder.files().empty());
}
