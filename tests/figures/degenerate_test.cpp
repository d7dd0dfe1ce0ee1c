// Figures of nothing, of one sample, of constants, gaps and the largest and smallest numbers.
#include <catch2/catch.hpp>

#include "support.h"

using namespace cogrsim::figures;

namespace {

void check_draws(Figure figure, const std::string& what) {
  const Folder folder;
  CAPTURE(what);
  for (const bool log : {false, true}) {
    figure.y.log = log && figure.kind != Kind::surface;
    figure.z.log = log;
    const std::string path = folder / (log ? "log.png" : "linear.png");
    drawn(figure, path);
    CHECK(content(path).substr(1, 3) == "PNG");
  }
}

}  // namespace

TEST_CASE("odd samples are drawn by every kind of figure", "[degenerate]") {
  const std::vector<std::vector<double>> samples = {{},
                                                    {2.5},
                                                    {-3, -3, -3},
                                                    {0, 0},
                                                    {kNaN, kNaN},
                                                    {kInfinity, 1, -kInfinity, 2},
                                                    {1, kNaN, 2, kNaN, 3},
                                                    {1e-320, 3e-320, 2e-320},
                                                    {-1.7e308, 1.7e308, 0, 5},
                                                    {1e15, 1e15 + 1, 1e15 + 2}};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::vector<double>& y = samples[i];
    std::vector<double> x;
    for (std::size_t k = 0; k < y.size(); ++k) x.push_back(static_cast<double>(k));
    const std::string what = "case " + std::to_string(i);
    check_draws(curve(x, y), what + " curve");
    check_draws(curve(y, x), what + " curve turned");
    check_draws(map(y, y), what + " map");
    check_draws(histogram(y), what + " histogram");
    Figure boxes = box({y, {1, 2, 3}, {}});
    check_draws(boxes, what + " box");
    boxes.notches = true;
    check_draws(boxes, what + " notched box");
    check_draws(surface(x, y, y), what + " surface");
  }
}

TEST_CASE("figures without a series are drawn", "[degenerate]") {
  for (const Kind kind : {Kind::curve, Kind::box, Kind::histogram, Kind::surface, Kind::map}) {
    Figure figure;
    figure.kind = kind;
    check_draws(figure, to_string(kind));
  }
}
