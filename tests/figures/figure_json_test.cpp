#include <cmath>

#include <catch2/catch.hpp>

#include "support.h"

using namespace cogrsim::figures;

namespace {

std::string json_of(const Figure& figure) {
  const auto text = to_json(figure);
  REQUIRE(text);
  return *text;
}

std::string refused(const std::string& text) {
  const auto figure = figure_from_json(text);
  REQUIRE_FALSE(figure);
  return figure.error().text();
}

std::vector<Figure> one_of_each() {
  Figure line = curve({0, 1, 2}, {1.0 / 3.0, kNaN, kInfinity}, "a \"quoted\"\nlabel");
  add_series(line, {0, 1}, {-kInfinity, 1e-320}, "second");
  line.title = "title ü";
  line.name = "bot.path";
  line.x = {"time", "s", true, 0.1, 10.0};
  line.legend = false;
  Figure boxes = box({{1, 2, 3, 50}, {}}, {"left", "right"});
  boxes.notches = true;
  boxes.whisker = 2.5;
  Figure counted = histogram({0.25, 0.5, 2.75}, "h", BinRule::freedman_diaconis);
  return {line,
          boxes,
          counted,
          surface({0, 1, 2}, {0, 1, 0}, {5, 6, 7}, 3, 2),
          surface_of({0, 1}, {0}, {3, kNaN}),
          map({0, 1}, {2, 3}, "p")};
}

}  // namespace

TEST_CASE("a figure comes back from its JSON as it was", "[json]") {
  for (const Figure& figure : one_of_each()) {
    CAPTURE(to_string(figure.kind));
    const std::string text = json_of(figure);
    const auto back = figure_from_json(text);
    INFO((back ? "" : back.error().text()));
    REQUIRE(back);
    CHECK(back->kind == figure.kind);
    CHECK(back->title == figure.title);
    REQUIRE(back->series.size() == figure.series.size());
    CHECK(back->series[0].label == figure.series[0].label);
    CHECK(json_of(*back) == text);
  }
}

TEST_CASE("numbers come back to the last bit, gaps and infinities too", "[json]") {
  const auto back = figure_from_json(json_of(one_of_each().front()));
  REQUIRE(back);
  CHECK(back->series[0].y[0] == 1.0 / 3.0);
  CHECK(std::isnan(back->series[0].y[1]));
  CHECK(back->series[0].y[2] == kInfinity);
  CHECK(back->series[1].y[0] == -kInfinity);
  CHECK(back->series[1].y[1] == 1e-320);
  CHECK(back->x.maximum == 10.0);
  CHECK_FALSE(back->y.maximum);
}

TEST_CASE("statistics are in the JSON with their method and are not computed again", "[json]") {
  Figure figure = box({{1, 2, 3, 4}});
  std::string text = json_of(figure);
  CHECK(text.find("(k - 0.5)/n") != std::string::npos);
  CHECK(text.find("\"median\": 2.5") != std::string::npos);
  text.replace(text.find("\"median\": 2.5"), 13, "\"median\": 2.75");
  const auto back = figure_from_json(text);
  REQUIRE(back);
  CHECK(back->series[0].box->median == 2.75);
}

TEST_CASE("JSON that is not a figure is refused", "[json]") {
  const std::string head = R"({"format": "cogrsim-figure", "version": 1, )";
  CHECK(refused("{").find("not JSON") != std::string::npos);
  CHECK(refused("[1]").find("not a figure") != std::string::npos);
  CHECK(refused("{}").find("not a figure") != std::string::npos);
  CHECK(refused(R"({"format": "cogrsim-figure", "version": 2, "kind": "curve", "series": []})")
            .find("version 2") != std::string::npos);
  CHECK(refused(R"({"format": "cogrsim-figure", "version": "1"})").find("'version'") !=
        std::string::npos);
  CHECK(refused(head + R"("kind": "curv", "series": []})").find("'curv'") != std::string::npos);
  CHECK(refused(head + R"("kind": "curve"})").find("'series'") != std::string::npos);
  CHECK(refused(head + R"("kind": "curve", "series": [{"x": 1}]})").find("'series[0].x'") !=
        std::string::npos);
  CHECK(refused(head + R"("kind": "curve", "series": [{"x": [1], "y": []}]})").find("1 values") !=
        std::string::npos);
  CHECK(refused(head + R"("kind": "curve", "series": [], "x": {"log": 1}})").find("'x.log'") !=
        std::string::npos);
  CHECK(refused(head + R"("kind": "histogram", "series": [], "bins": {"edges": [1, 0]}})")
            .find("must rise") != std::string::npos);
  CHECK(refused(head + R"("kind": "surface", "columns": 1e300, "series": []})").find("'columns'") !=
        std::string::npos);
  CHECK(refused(head + R"("kind": "surface", "series": [{"grid": {"x": [1], "y": [1], "z": []}}]})")
            .find("grid") != std::string::npos);
}

TEST_CASE("a figure that cannot be drawn is refused before drawing", "[figure]") {
  Figure lengths = curve({1, 2}, {1});
  CHECK_FALSE(complete(lengths));
  Figure two = surface({1}, {1}, {1});
  add_series(two, {1}, {1});
  CHECK(complete(two).error().message.find("one series") != std::string::npos);
  Figure empty = curve({1}, {1});
  empty.y.minimum = 2;
  empty.y.maximum = 2;
  CHECK_FALSE(complete(empty));
  Figure log = curve({1}, {1});
  log.y.log = true;
  log.y.minimum = 0;
  CHECK(complete(log).error().message.find("logarithmic") != std::string::npos);
  CHECK_FALSE(kind_from("pie"));
  CHECK(kind_from("histgram").error().hint.find("'histogram'") != std::string::npos);
}
